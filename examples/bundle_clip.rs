//! Packs the first frames of a gray 8-bit clip into a small lossless animation.
//!
//! ```text
//! cargo run --release --example bundle_clip -- vtest_256x256.y4m clips/vtest_256x256.apng 1900000
//! ```
//!
//! It takes as many leading frames as fit into that many bytes and prints how many, with
//! the FNV-1a hash of their pixels, to which `tests/scene.rs` holds the result. Of a still
//! camera's picture most stays as it was: what has not changed is left transparent.

use std::{io::Write, path::Path};

use amacrine::{
    plane::Size,
    save::save,
    scene::{OpenOptions, Scene, open},
};
use miette::{IntoDiagnostic, bail, miette};
use png::{BitDepth, BlendOp, ColorType, Compression, Encoder, Filter};

const FILTERS: [Filter; 6] = [
    Filter::NoFilter,
    Filter::Sub,
    Filter::Up,
    Filter::Avg,
    Filter::Paeth,
    Filter::Adaptive,
];

/// One frame as it is stored.
struct Step {
    pixels: Vec<u8>,
    over: bool,
    filter: Filter,
}

fn main() -> miette::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, to, most] = arguments.as_slice() else {
        bail!("usage: bundle_clip CLIP.y4m OUT.apng BYTES");
    };
    let most: usize = most.parse().into_diagnostic()?;
    let mut scene = open(from, &OpenOptions::default())?;
    let (size, fps) = (scene.size(), scene.fps());
    if fps.fract() != 0.0 || fps > 65535.0 {
        bail!("{from}: {fps} frames/s; only whole rates are packed");
    }
    let mut frames = Vec::new();
    while let Some(frame) = scene.next_frame()? {
        if frame
            .light
            .iter()
            .any(|v| v.fract() != 0.0 || !(0.0..=255.0).contains(v))
        {
            bail!("{from}: only 8-bit gray is packed");
        }
        frames.push(frame.light.iter().map(|v| *v as u8).collect::<Vec<u8>>());
    }
    let key = (0..=255)
        .find(|v| !frames.iter().flatten().any(|pixel| pixel == v))
        .ok_or_else(|| miette!("{from}: no gray is free to stand for \"unchanged\""))?;

    let mut steps: Vec<Step> = Vec::new();
    let mut bytes = 1000;
    for (n, frame) in frames.iter().enumerate() {
        let before = n.checked_sub(1).map(|n| &frames[n]);
        let (step, cost) = smallest(frame, before, size, key)?;
        bytes += cost;
        if bytes > most {
            break;
        }
        steps.push(step);
    }
    save(Path::new(to), |file| {
        write(file, &steps, size, key, fps as u16).map_err(std::io::Error::other)
    })?;
    let written = std::fs::metadata(to).into_diagnostic()?.len();
    println!(
        "{} of {} frames, {written} bytes, FNV-1a {:#018x}",
        steps.len(),
        frames.len(),
        fnv(frames.iter().take(steps.len()).flatten())
    );
    Ok(())
}

/// The cheapest way to store a frame after the one before it, and its bytes.
fn smallest(
    frame: &[u8],
    before: Option<&Vec<u8>>,
    size: Size,
    key: u8,
) -> miette::Result<(Step, usize)> {
    let whole = |pixels, over| Step {
        pixels,
        over,
        filter: Filter::NoFilter,
    };
    let mut ways = vec![whole(frame.to_vec(), false)];
    if let Some(before) = before {
        let changed = frame.iter().zip(before);
        let pixels = changed.map(|(now, was)| if now == was { key } else { *now });
        ways.push(whole(pixels.collect(), true));
    }
    let mut best: Option<(Step, usize)> = None;
    for way in ways {
        for filter in FILTERS {
            let mut bytes = Vec::new();
            let step = Step {
                pixels: way.pixels.clone(),
                over: way.over,
                filter,
            };
            write(&mut bytes, std::slice::from_ref(&step), size, key, 1).into_diagnostic()?;
            if best.as_ref().is_none_or(|(_, least)| bytes.len() < *least) {
                best = Some((step, bytes.len()));
            }
        }
    }
    best.ok_or_else(|| miette!("no way to store a frame"))
}

fn write(
    file: impl Write,
    steps: &[Step],
    size: Size,
    key: u8,
    fps: u16,
) -> Result<(), png::EncodingError> {
    let mut encoder = Encoder::new(file, size.width as u32, size.height as u32);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::High);
    encoder.set_trns(vec![0, key]);
    encoder.set_animated(steps.len() as u32, 0)?;
    encoder.set_frame_delay(1, fps)?;
    let mut writer = encoder.write_header()?;
    for step in steps {
        writer.set_blend_op(if step.over {
            BlendOp::Over
        } else {
            BlendOp::Source
        })?;
        writer.set_filter(step.filter);
        writer.write_image_data(&step.pixels)?;
    }
    writer.finish()
}

/// The 64-bit FNV-1a hash.
fn fnv<'a>(bytes: impl Iterator<Item = &'a u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
