//! A frame, and the trait of all sources of frames.

use super::{coding::Light, error::SceneError, image::Image, light};
use crate::plane::Size;

/// One picture of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Number of the frame, from 0.
    pub index: u64,
    /// When it was taken, in seconds.
    pub seconds: f64,
    /// Light, `[y, x]`, held as its samples are: 0 to 255 for video and pictures, as given for `.npy`;
    /// [`Scene::coding`] says what was undone.
    pub light: Image,
}

/// A source of frames, all of one size.
pub trait Scene: Send {
    /// Size of every frame.
    fn size(&self) -> Size;

    /// Frames of the source per second.
    fn fps(&self) -> f64;

    /// Whether [`fps`](Self::fps) is [`ASSUMED_FPS`](super::ASSUMED_FPS), because neither the source nor the
    /// caller said one. Whoever shows results should then say so.
    fn fps_is_assumed(&self) -> bool {
        false
    }

    /// How many frames there are, where that is known beforehand.
    fn frames(&self) -> Option<u64>;

    /// The next frame; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read, or a frame is damaged, of another size, or not finite.
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError>;

    /// How its samples became light, and who said so.
    fn coding(&self) -> Light {
        Light::DRAWN
    }

    /// The most bytes that the source holds while frames are taken from it, the frame that it gives
    /// included.
    fn bytes(&self) -> u128 {
        light::PIXEL_BYTES_HELD * self.size().pixels() as u128
    }
}

impl<S: Scene + ?Sized> Scene for Box<S> {
    fn size(&self) -> Size {
        (**self).size()
    }
    fn fps(&self) -> f64 {
        (**self).fps()
    }
    fn fps_is_assumed(&self) -> bool {
        (**self).fps_is_assumed()
    }
    fn frames(&self) -> Option<u64> {
        (**self).frames()
    }
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        (**self).next_frame()
    }
    fn coding(&self) -> Light {
        (**self).coding()
    }
    fn bytes(&self) -> u128 {
        (**self).bytes()
    }
}
