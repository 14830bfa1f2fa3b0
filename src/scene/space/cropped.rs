//! A part of each picture of a scene.

use ndarray::s;

use super::crop::Crop;
use crate::{
    plane::{At, Size},
    scene::{Codes, Frame, Image, Outline, Scene, SceneError},
};

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
            return Err(SceneError::CropOutside {
                crop: crop.to_string(),
                size: whole,
            });
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
