//! One picture: a scene of one frame, and the frames of a folder.

use std::{
    io::{BufRead, Seek},
    path::{Path, PathBuf},
};

use image::{ImageDecoder, ImageFormat, ImageReader};

use super::{
    Frame, Scene, SceneError,
    gray::{self, Layout},
    light,
    rate::Rate,
};
use crate::plane::{Plane, Size};

/// A scene of one frame.
pub(super) struct Still {
    light: Option<Plane<f64>>,
    size: Size,
    rate: Rate,
}

/// Opens one picture.
pub(super) fn open(path: &Path, asked: Option<f64>) -> Result<impl Scene + use<>, SceneError> {
    let light = read(path, 0)?;
    Ok(Still {
        size: Size::of(&light),
        light: Some(light),
        rate: Rate::asked_or_assumed(asked),
    })
}

impl Scene for Still {
    fn size(&self) -> Size {
        self.size
    }
    fn fps(&self) -> f64 {
        self.rate.fps
    }
    fn fps_is_assumed(&self) -> bool {
        self.rate.assumed
    }
    fn frames(&self) -> Option<u64> {
        Some(1)
    }
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        Ok(self.light.take().map(|light| Frame {
            index: 0,
            seconds: 0.0,
            light,
        }))
    }
}

/// Reads the picture at `path`: a PNG or a PNM, 8 or 16 bits, gray or colour.
///
/// `frame` is its number in the scene, for messages.
pub(super) fn read(path: &Path, frame: u64) -> Result<Plane<f64>, SceneError> {
    let file = light::open_file(path)?;
    let reader = ImageReader::new(file)
        .with_guessed_format()
        .map_err(|cause| SceneError::unreadable(path, cause))?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Pnm) => decode(reader, path, frame),
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
) -> Result<Plane<f64>, SceneError> {
    let damaged = |cause: Box<dyn std::error::Error + Send + Sync>| SceneError::Picture {
        path: PathBuf::from(path),
        frame,
        cause,
    };
    let decoder = reader.into_decoder().map_err(|e| damaged(e.into()))?;
    let (width, height) = decoder.dimensions();
    let size = light::checked_size(path, height as usize, width as usize)?;
    let colour = decoder.color_type();
    let channels = usize::from(colour.channel_count());
    let mut bytes = vec![0; size.pixels() * usize::from(colour.bytes_per_pixel())];
    decoder
        .read_image(&mut bytes)
        .map_err(|e| damaged(e.into()))?;
    let (samples, most): (Vec<f64>, f64) = match bytes.len() / (size.pixels() * channels) {
        1 => (bytes.iter().map(|&b| b.into()).collect(), 255.0),
        2 => {
            let pairs = bytes.as_chunks().0.iter();
            let samples = pairs.map(|&pair| u16::from_ne_bytes(pair).into());
            (samples.collect(), 65535.0)
        }
        _ => return Err(damaged("more than 16 bits a sample".into())),
    };
    let lights = gray::pixels(Layout { channels, most }, &samples).map(|p| p.light);
    light::plane(size, lights.collect()).ok_or_else(|| damaged("too few samples".into()))
}
