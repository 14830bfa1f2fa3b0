//! What of a scene is shown, and how large.

use super::{
    Scene, SceneError,
    crop::{Crop, Cropped},
    resize::Resized,
    slice::{Slice, Sliced},
};
use crate::plane::Size;

/// What of a scene is shown, and how large: all of it where nothing is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct View {
    /// Its frames.
    pub slice: Option<Slice>,
    /// The part of each picture.
    pub crop: Option<Crop>,
    /// To what size that is averaged.
    pub resize: Option<Size>,
}

impl View {
    /// What it shows of a scene.
    ///
    /// # Errors
    /// When the scene has no such part.
    pub fn of<'a>(self, scene: Box<dyn Scene + 'a>) -> Result<Box<dyn Scene + 'a>, SceneError> {
        let mut shown = scene;
        if let Some(slice) = self.slice {
            shown = Box::new(Sliced::new(shown, slice));
        }
        if let Some(crop) = self.crop {
            shown = Box::new(Cropped::new(shown, crop)?);
        }
        if let Some(size) = self.resize {
            shown = Box::new(Resized::new(shown, size)?);
        }
        Ok(shown)
    }
}
