//! A part of each picture of a scene.

use std::{fmt, str::FromStr};

use ndarray::s;

use super::{Codes, Frame, Image, Outline, Scene, SceneError};
use crate::plane::{At, Size};

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Its height and width.
    pub size: Size,
    /// Its upper left pixel; in the middle of the picture where it is left out.
    pub at: Option<At>,
}

impl FromStr for Crop {
    type Err = String;

    /// Reads `WIDTHxHEIGHT`, in the middle, or `WIDTHxHEIGHT+X+Y`.
    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (size, at) = match text.split_once('+') {
                Some((size, at)) => (size, Some(at.split_once('+')?)),
                None => (text, None),
            };
            let at = match at {
                Some((x, y)) => Some(At {
                    y: y.parse().ok()?,
                    x: x.parse().ok()?,
                }),
                None => None,
            };
            let size = read_size(size)?;
            Some(Self { size, at })
        };
        read().ok_or_else(|| {
            "give WIDTHxHEIGHT for the middle of the picture, or WIDTHxHEIGHT+X+Y from its left and its top, such as 256x256+10+20".to_owned()
        })
    }
}

fn read_size(text: &str) -> Option<Size> {
    let (width, height) = text.split_once('x')?;
    let size = Size::new(height.parse().ok()?, width.parse().ok()?);
    size.is_possible().then_some(size)
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.size)?;
        self.at.map_or(Ok(()), |at| write!(f, "+{}+{}", at.x, at.y))
    }
}

/// A scene of which only a rectangle is shown.
#[derive(Debug)]
pub struct Cropped<S> {
    source: S,
    size: Size,
    at: At,
}

impl<S: Scene> Cropped<S> {
    /// The rectangle of `source`.
    ///
    /// # Errors
    /// When it does not lie in the picture.
    pub fn new(source: S, crop: Crop) -> Result<Self, SceneError> {
        let (whole, size) = (source.size(), crop.size);
        let at = crop.at.unwrap_or(At {
            y: whole.height.saturating_sub(size.height) / 2,
            x: whole.width.saturating_sub(size.width) / 2,
        });
        let fits = |at: usize, part: usize, whole: usize| {
            at.checked_add(part).is_some_and(|end| end <= whole)
        };
        if !(fits(at.y, size.height, whole.height) && fits(at.x, size.width, whole.width)) {
            return Err(SceneError::CropOutside { crop, size: whole });
        }
        Ok(Self { source, size, at })
    }

    fn cropped(&self, light: &Image) -> Image {
        let (At { y, x }, Size { height, width }) = (self.at, self.size);
        let Some(coded) = light.coded() else {
            let part = light.slice(s![y..y + height, x..x + width]);
            return part.to_owned().into();
        };
        let levels = coded.levels().clone();
        let whole = coded.size().width;
        let part = match coded.codes() {
            Codes::Bytes(codes) => Image::of_bytes(self.size, self.rows(codes, whole), levels),
            Codes::Words(codes) => Image::of_words(self.size, self.rows(codes, whole), levels),
        };
        part.expect("as many codes as pixels")
    }

    fn rows<T: Copy>(&self, codes: &[T], width: usize) -> Vec<T> {
        let rows = codes.chunks_exact(width).skip(self.at.y);
        rows.take(self.size.height)
            .flat_map(|row| &row[self.at.x..][..self.size.width])
            .copied()
            .collect()
    }
}

impl<S: Scene> Scene for Cropped<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        let drawn = Outline::new(self.size, source.fps);
        Outline {
            size: self.size,
            bytes: source.bytes + drawn.bytes,
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let frame = self.source.next_frame()?;
        Ok(frame.map(|frame| Frame {
            light: self.cropped(&frame.light),
            ..frame
        }))
    }
}
