//! A contact sheet of clips, and how long one takes.
//!
//! `cargo run --release -p amacrine-learn --example clips -- SHEET.png [FOLDER]`: a row a clip: the
//! first, the middle and the last frame, and the middle one with arrows' colours: blue moves right,
//! red left, black is not seen in the next frame.

use std::{path::Path, time::Instant};

use amacrine::plane::Size;
use amacrine_learn::scene::{Clips, Motion, Photographs};
use image::{Rgb, RgbImage, imageops};
use miette::{IntoDiagnostic, Result};

const SIDE: u32 = 96;
const ROWS: u64 = 8;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let sheet = arguments.next().unwrap_or_else(|| "clips.png".to_owned());
    let photographs = match arguments.next() {
        Some(folder) => Photographs::folder(Path::new(&folder))?,
        None => Photographs::bundled()?,
    };
    let (train, held_out) = photographs.split();
    println!(
        "{} photographs to train with, {} held out",
        train.all().len(),
        held_out.all().len()
    );
    let small = Clips::new(&train, &Motion::default(), Size::new(48, 48), 9, 1)?;
    let start = Instant::now();
    let clips = 400;
    let mut layers = 0;
    for index in 0..clips {
        let clip = small.clip(index);
        layers += u32::from(
            clip.flow
                .is_some_and(|flow| flow.seen.iter().any(|seen| !seen)),
        );
    }
    let each = start.elapsed().as_secs_f64() * 1e3 / clips as f64;
    println!(
        "{each:.2} ms a clip of 9 frames of 48x48; {layers} of {clips} have pixels that vanish"
    );

    let size = Size::new(SIDE as usize, SIDE as usize);
    let large = Clips::new(&train, &Motion::default(), size, 9, 1)?;
    let step = i64::from(SIDE) + 4;
    let mut page = RgbImage::from_pixel(4 * (SIDE + 4), ROWS as u32 * (SIDE + 4), Rgb([255; 3]));
    for row in 0..ROWS {
        let clip = large.clip(row);
        let frame = |n: usize| {
            RgbImage::from_fn(SIDE, SIDE, |x, y| {
                Rgb([clip.light[(n, y as usize, x as usize)] as u8; 3])
            })
        };
        let mut shown = vec![frame(0), frame(clip.middle()), frame(8)];
        if let Some(flow) = &clip.flow {
            shown.push(RgbImage::from_fn(SIDE, SIDE, |x, y| {
                let at = (y as usize, x as usize);
                let shade = |v: f32| (128.0 + 40.0 * v).clamp(0.0, 255.0) as u8;
                if flow.seen[at] {
                    Rgb([shade(-flow.u[at]), shade(flow.v[at]), shade(flow.u[at])])
                } else {
                    Rgb([0; 3])
                }
            }));
        }
        for (column, picture) in (0..).zip(&shown) {
            imageops::replace(&mut page, picture, column * step, row as i64 * step);
        }
    }
    page.save(&sheet).into_diagnostic()
}
