//! One picture: a scene of one frame, and the frames of a folder.

use std::{
    io::{BufRead, Seek},
    path::{Path, PathBuf},
    sync::OnceLock,
};

use image::{ImageDecoder, ImageFormat, ImageReader};

use super::{pgm, png_chunks};
use crate::{
    plane::Size,
    scene::{
        Frame, Image, Levels, OpenOptions, Outline, Scene, SceneError,
        checks::{self, MemoryLimit},
        light::{
            conversion::Source,
            pixel::{self, Depth, Layout},
        },
        time::frame_rate::Rate,
    },
};

/// A scene of one frame.
pub(super) struct Still {
    light: Option<Image>,
    size: Size,
    rate: Rate,
}

/// Opens one picture.
pub(in crate::scene) fn open(
    path: &Path,
    options: OpenOptions,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    let (light, source) = read_with_source(path, 0, MemoryLimit::new(options))?;
    let still = Still {
        size: light.size(),
        light: Some(light),
        rate: Rate::asked_or_assumed(options.fps),
    };
    Ok((still, source))
}

impl Scene for Still {
    fn outline(&self) -> Outline {
        Outline {
            frames: Some(1),
            bytes: (MOST_CODED + checks::PIXEL_BYTES) * self.size.pixels() as u128,
            ..Outline::at(self.rate, self.size)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        Ok(self.light.take().map(|light| Frame {
            index: 0,
            seconds: 0.0,
            light,
        }))
    }
}

/// Most bytes of a pixel in a file: four samples of 16 bits.
pub(super) const MOST_CODED: u128 = 8;

/// Reads the picture at `path`: a PNG or a PNM, 8 or 16 bits, gray or colour.
///
/// `frame` is its number in the scene, for messages.
pub(super) fn read(path: &Path, frame: u64, room: MemoryLimit) -> Result<Image, SceneError> {
    Ok(read_with_bits(path, frame, room)?.0)
}

/// The same, and what the file says about its samples.
pub(in crate::scene) fn read_with_source(
    path: &Path,
    frame: u64,
    room: MemoryLimit,
) -> Result<(Image, Source), SceneError> {
    let (image, bits, format) = read_with_bits(path, frame, room)?;
    if format != ImageFormat::Png {
        return Ok((image, Source::pictures(bits)));
    }
    match png::Decoder::new(checks::open_file(path)?).read_info() {
        Ok(reader) => Ok((image, png_chunks::source(bits, reader.info()))),
        Err(cause) => Err(SceneError::Picture {
            path: path.into(),
            frame,
            cause: cause.into(),
        }),
    }
}

/// The same, with the bits of a sample and the format.
fn read_with_bits(
    path: &Path,
    frame: u64,
    room: MemoryLimit,
) -> Result<(Image, u32, ImageFormat), SceneError> {
    let mut file = checks::open_file(path)?;
    let start = file.fill_buf();
    let start = start.map_err(|cause| SceneError::unreadable(path, cause))?;
    let behind = start.strip_prefix(pgm::MAGIC).and_then(<[u8]>::first);
    if behind.is_some_and(u8::is_ascii_whitespace) {
        let (image, bits) = pgm::read(&mut file, path, frame, room)?;
        pgm::check_end(&mut file, path)?;
        return Ok((image, bits, ImageFormat::Pnm));
    }
    let reader = ImageReader::new(&mut file)
        .with_guessed_format()
        .map_err(|cause| SceneError::unreadable(path, cause))?;
    match reader.format() {
        Some(format @ (ImageFormat::Png | ImageFormat::Pnm)) => {
            let (image, bits) = decode(reader, path, frame, room)?;
            if format == ImageFormat::Pnm {
                pgm::check_end(&mut file, path)?;
            }
            Ok((image, bits, format))
        }
        Some(_) | None => Err(SceneError::Picture {
            path: path.into(),
            frame,
            cause: "its first bytes are neither those of a PNG nor of a PNM".into(),
        }),
    }
}

fn decode<R: BufRead + Seek>(
    reader: ImageReader<R>,
    path: &Path,
    frame: u64,
    room: MemoryLimit,
) -> Result<(Image, u32), SceneError> {
    let damaged = |cause: Box<dyn std::error::Error + Send + Sync>| SceneError::Picture {
        path: PathBuf::from(path),
        frame,
        cause,
    };
    let decoder = reader.into_decoder().map_err(|e| damaged(e.into()))?;
    let (width, height) = decoder.dimensions();
    let size = checks::checked_size(path, height as usize, width as usize)?;
    let colour = decoder.color_type();
    let channels = usize::from(colour.channel_count());
    let held = u128::from(colour.bytes_per_pixel()) + checks::PIXEL_BYTES;
    room.check(path, size, held * size.pixels() as u128)?;
    let mut bytes = vec![0; size.pixels() * usize::from(colour.bytes_per_pixel())];
    decoder
        .read_image(&mut bytes)
        .map_err(|e| damaged(e.into()))?;
    let (depth, bits) = match bytes.len() / (size.pixels() * channels) {
        1 => (Depth::Eight, 8),
        2 => (Depth::Sixteen(u16::from_ne_bytes), 16),
        _ => return Err(damaged("more than 16 bits a sample".into())),
    };
    let light = match (channels, depth) {
        (1, Depth::Eight) => Image::of_bytes(size, bytes, Levels::bytes()),
        (1, Depth::Sixteen(read)) => {
            let codes = bytes.as_chunks().0.iter().map(|pair| read(*pair)).collect();
            Image::of_words(size, codes, full_range())
        }
        _ => {
            let lights = pixel::pixels(Layout { channels, depth }, &bytes).map(|p| p.light);
            checks::plane(size, lights.collect()).map(Image::from)
        }
    };
    Ok((
        light.ok_or_else(|| damaged("too few samples".into()))?,
        bits,
    ))
}

/// What samples of 16 bits stand for.
fn full_range() -> Levels {
    static LEVELS: OnceLock<Levels> = OnceLock::new();
    let light = |code| f64::from(code) * 255.0 / 65535.0;
    LEVELS.get_or_init(|| Levels::of_words(light)).clone()
}
