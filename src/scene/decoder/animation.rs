//! Animations, GIF and APNG: decoded frame by frame onto a canvas.
//!
//! The delays must be equal to within the unit in which they are written (a GIF of 30 frames/s has
//! delays of 3, 3, 4 hundredths); the rate is then the inverse of their mean. The last frame's
//! delay says when the animation begins again and does not count. The file is read twice, as all
//! delays must be known before the first frame. Pixels that are never drawn are black.

use std::{
    io::{BufRead, Cursor, Seek},
    num::NonZeroU64,
    path::{Path, PathBuf},
    sync::OnceLock,
};

use super::{
    canvas::{Area, Canvas, Delay, Disposal, Patch},
    frame_spacing, png_chunks,
    still::MOST_CODED,
};
use crate::{
    plane::Size,
    scene::{
        Frame, OpenOptions, Outline, Scene, SceneError,
        checks::{self, MemoryLimit},
        light::{
            conversion::Source,
            pixel::{self, Depth, Layout},
        },
        time::frame_rate::Rate,
    },
};

/// Bytes held per pixel: as it is coded, as a patch, on the canvas now and before, as light.
const HELD: u128 = MOST_CODED + 16 + 3 * checks::PIXEL_BYTES;

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// A decoder that gives an animation as patches.
trait Patches: Send {
    /// Size of the canvas.
    fn size(&self) -> Size;

    /// The unit of the delays, in seconds.
    fn unit(&self) -> f64;

    /// What the file says about its samples.
    fn source(&self) -> Source {
        Source::pictures(8)
    }

    /// The next patch.
    fn next_patch(&mut self) -> Result<Option<Patch>, Cause>;
}

/// An animation being shown.
struct Animation {
    path: PathBuf,
    patches: Box<dyn Patches>,
    size: Size,
    canvas: Canvas,
    rate: Rate,
    count: u64,
    next: u64,
}

/// Opens a GIF.
pub(in crate::scene) fn open_gif(
    path: &Path,
    options: OpenOptions,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    Animation::open(path, options, &|| {
        Ok(Box::new(Gif::new(
            path,
            checks::open_file(path)?,
            MemoryLimit::new(options),
        )?))
    })
}

/// Opens an animated PNG.
pub(in crate::scene) fn open_apng(
    path: &Path,
    options: OpenOptions,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    Animation::open(path, options, &|| {
        Ok(Box::new(Apng::new(
            path,
            checks::open_file(path)?,
            MemoryLimit::new(options),
        )?))
    })
}

/// Plays an animated PNG that is in memory; `name` is for messages, and `known` has its delays once
/// they were read.
pub(super) fn play_apng(
    name: &Path,
    bytes: &'static [u8],
    options: OpenOptions,
    known: &OnceLock<Vec<Delay>>,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    let start: &Start<'_> = &|| {
        let stream = Cursor::new(bytes);
        Ok(Box::new(Apng::new(
            name,
            stream,
            MemoryLimit::new(options),
        )?))
    };
    if known.get().is_none() {
        // Whoever comes second reads the same.
        let _ = known.set(delays(name, start)?);
    }
    let delays = known.get().map_or(&[][..], Vec::as_slice);
    Animation::of(name, options, start, delays)
}

/// Whether a PNG is animated.
pub(in crate::scene) fn is_apng(path: &Path) -> Result<bool, SceneError> {
    let file = checks::open_file(path)?;
    match png::Decoder::new(file).read_info() {
        Ok(reader) => Ok(reader.info().animation_control.is_some()),
        Err(cause) => Err(SceneError::Picture {
            path: path.into(),
            frame: 0,
            cause: cause.into(),
        }),
    }
}

/// A decoder at the start of an animation.
type Start<'a> = dyn Fn() -> Result<Box<dyn Patches>, Cause> + 'a;

fn damaged(path: &Path, frame: u64, cause: Cause) -> SceneError {
    match cause.downcast() {
        Ok(scene_error) => *scene_error,
        Err(cause) => SceneError::Picture {
            path: path.into(),
            frame,
            cause,
        },
    }
}

/// The delays of all frames.
fn delays(path: &Path, start: &Start<'_>) -> Result<Vec<Delay>, SceneError> {
    let mut patches = start().map_err(|e| damaged(path, 0, e))?;
    let mut delays = Vec::new();
    while let Some(patch) = patches
        .next_patch()
        .map_err(|e| damaged(path, delays.len() as u64, e))?
    {
        delays.push(patch.delay);
        checks::check_drawn(path, patches.size(), delays.len() as u64)?;
    }
    Ok(delays)
}

impl Animation {
    /// The animation, and what its samples are.
    fn open(
        path: &Path,
        options: OpenOptions,
        start: &Start<'_>,
    ) -> Result<(Self, Source), SceneError> {
        Self::of(path, options, start, &delays(path, start)?)
    }

    /// The same of one whose delays are known.
    fn of(
        path: &Path,
        options: OpenOptions,
        start: &Start<'_>,
        delays: &[Delay],
    ) -> Result<(Self, Source), SceneError> {
        let asked = options.fps;
        let patches = start().map_err(|e| damaged(path, 0, e))?;
        let found = match asked {
            Some(_) => None,
            None => even_rate(path, delays, patches.unit())?,
        };
        let rate = match delays.len() {
            0 => {
                return Err(SceneError::Empty {
                    path: path.into(),
                    missing: "frame",
                });
            }
            // One frame has no rate to be wrong about.
            1 => Rate::asked_or_assumed(asked),
            _ => Rate::asked_or_found(asked, found, path)?,
        };
        let (size, source) = (patches.size(), patches.source());
        let animation = Self {
            path: path.into(),
            patches,
            size,
            canvas: Canvas::new(size),
            rate,
            count: delays.len() as u64,
            next: 0,
        };
        Ok((animation, source))
    }
}

/// The rate of evenly spaced frames; `None` when the delays are 0.
fn even_rate(path: &Path, delays: &[Delay], unit: f64) -> Result<Option<f64>, SceneError> {
    let Some((_, shown)) = delays.split_last() else {
        return Ok(None);
    };
    let (mut length, mut exact) = (0.0, Some(0_u64));
    let denominator = shown.first().map_or(1, |delay| delay.denominator);
    for delay in shown {
        length += delay.seconds();
        exact = exact
            .filter(|_| delay.denominator == denominator)
            .map(|sum| sum + u64::from(delay.numerator));
    }
    let count = shown.len() as f64;
    let mut times = vec![0.0];
    for delay in shown {
        times.push(times[times.len() - 1] + delay.seconds());
    }
    let rounded = frame_spacing::check(path, &times, unit)?;
    if rounded.is_some() {
        return Ok(rounded);
    }
    // Summed as fractions where they share a denominator, so that 1/10 s gives exactly 10.
    Ok((length > 0.0).then(|| match exact {
        Some(sum) => count * f64::from(denominator) / sum as f64,
        None => count / length,
    }))
}

impl Scene for Animation {
    fn outline(&self) -> Outline {
        Outline {
            frames: Some(self.count),
            bytes: HELD * self.size.pixels() as u128,
            ..Outline::at(self.rate, self.size)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let index = self.next;
        let damaged = |cause| SceneError::Picture {
            path: self.path.clone(),
            frame: index,
            cause,
        };
        let Some(patch) = self.patches.next_patch().map_err(damaged)? else {
            return Ok(None);
        };
        let light = self
            .canvas
            .draw(&patch)
            .ok_or_else(|| damaged("it does not fit on the canvas".into()))?
            .clone()
            .into();
        self.next += 1;
        Ok(Some(Frame {
            index,
            seconds: self.rate.seconds(index),
            light,
        }))
    }
}

/// A GIF.
struct Gif<R: BufRead> {
    decoder: gif::Decoder<R>,
    size: Size,
}

impl<R: BufRead> Gif<R> {
    fn new(path: &Path, stream: R, room: MemoryLimit) -> Result<Self, Cause> {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        options.check_frame_consistency(true);
        // Room for a frame of the largest canvas, four bytes a pixel.
        let most = NonZeroU64::MIN.saturating_add(4 * Size::MOST_PIXELS as u64);
        options.set_memory_limit(gif::MemoryLimit::Bytes(most));
        let decoder = options.read_info(stream)?;
        let size = checks::checked_size(path, decoder.height().into(), decoder.width().into())?;
        room.check(path, size, HELD * size.pixels() as u128)?;
        Ok(Self { decoder, size })
    }
}

impl<R: BufRead + Send> Patches for Gif<R> {
    fn size(&self) -> Size {
        self.size
    }
    fn unit(&self) -> f64 {
        0.01
    }
    fn next_patch(&mut self) -> Result<Option<Patch>, Cause> {
        let Some(frame) = self.decoder.read_next_frame()? else {
            return Ok(None);
        };
        let layout = Layout {
            channels: 4,
            depth: Depth::Eight,
        };
        Ok(Some(Patch {
            area: Area {
                y: frame.top.into(),
                x: frame.left.into(),
                size: Size::new(frame.height.into(), frame.width.into()),
            },
            pixels: pixel::pixels(layout, &frame.buffer).collect(),
            over: true,
            disposal: match frame.dispose {
                gif::DisposalMethod::Any | gif::DisposalMethod::Keep => Disposal::Keep,
                gif::DisposalMethod::Background => Disposal::Background,
                gif::DisposalMethod::Previous => Disposal::Previous,
            },
            delay: Delay {
                numerator: frame.delay,
                denominator: 100,
            },
        }))
    }
}

/// An animated PNG.
struct Apng<R: BufRead + Seek> {
    reader: png::Reader<R>,
    size: Size,
    left: u32,
    bytes: Vec<u8>,
}

impl<R: BufRead + Seek> Apng<R> {
    fn new(path: &Path, stream: R, room: MemoryLimit) -> Result<Self, Cause> {
        let mut decoder = png::Decoder::new(stream);
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info()?;
        let info = reader.info();
        let left = info.animation_control.map_or(0, |a| a.num_frames);
        let is_apart = info.frame_control.is_none();
        let size = checks::checked_size(path, info.height as usize, info.width as usize)?;
        room.check(path, size, HELD * size.pixels() as u128)?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
        // A first picture outside the animation is for viewers that show none.
        if is_apart {
            reader.next_frame(&mut bytes)?;
        }
        Ok(Self {
            reader,
            size,
            left,
            bytes,
        })
    }
}

impl<R: BufRead + Seek + Send> Patches for Apng<R> {
    fn size(&self) -> Size {
        self.size
    }
    fn unit(&self) -> f64 {
        0.001
    }
    fn source(&self) -> Source {
        let info = self.reader.info();
        let bits = match info.bit_depth {
            png::BitDepth::Sixteen => 16,
            // Fewer are spread over the eight.
            _ => 8,
        };
        png_chunks::source(bits, info)
    }
    fn next_patch(&mut self) -> Result<Option<Patch>, Cause> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        let drawn = self.reader.next_frame(&mut self.bytes)?;
        let control = self
            .reader
            .info()
            .frame_control
            .ok_or("it has no frame control")?;
        let channels = drawn.color_type.samples();
        let bytes = self
            .bytes
            .get(..drawn.buffer_size())
            .ok_or("it is too large")?;
        let depth = match drawn.bit_depth {
            png::BitDepth::Eight => Depth::Eight,
            png::BitDepth::Sixteen => Depth::Sixteen(u16::from_be_bytes),
            png::BitDepth::One | png::BitDepth::Two | png::BitDepth::Four => {
                return Err("its samples were not unpacked".into());
            }
        };
        // The standard: a denominator of 0 means hundredths.
        let denominator = if control.delay_den == 0 {
            100
        } else {
            control.delay_den
        };
        Ok(Some(Patch {
            area: Area {
                y: control.y_offset as usize,
                x: control.x_offset as usize,
                size: Size::new(drawn.height as usize, drawn.width as usize),
            },
            pixels: pixel::pixels(Layout { channels, depth }, bytes).collect(),
            over: control.blend_op == png::BlendOp::Over,
            disposal: match control.dispose_op {
                png::DisposeOp::None => Disposal::Keep,
                png::DisposeOp::Background => Disposal::Background,
                png::DisposeOp::Previous => Disposal::Previous,
            },
            delay: Delay {
                numerator: control.delay_num,
                denominator,
            },
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_delays_are_even_and_others_are_not() {
        let rate = |hundredths: &[u16]| {
            let delay = |n: &u16| Delay {
                numerator: *n,
                denominator: 100,
            };
            let delays: Vec<_> = hundredths.iter().map(delay).collect();
            even_rate(Path::new("a.gif"), &delays, 0.01)
        };
        let thirty: Vec<u16> = [3, 3, 4].into_iter().cycle().take(31).collect();
        assert_eq!(rate(&thirty).unwrap(), Some(30.0));
        assert_eq!(rate(&[0, 0, 50]).unwrap(), None);
        assert_eq!(rate(&[10, 10, 900]).unwrap(), Some(10.0));
        let message = rate(&[10, 10, 30, 10]).unwrap_err().to_string();
        assert!(
            message.contains("frame 3, at 0.500000 s, comes 0.300000 s"),
            "{message}"
        );
    }
}
