//! What a trainer gets: frames, and what is known of their motion.

use std::sync::Arc;

use amacrine::plane::Plane;
use ndarray::Array3;

/// A few frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Light of shape (frames, rows, columns): 0 to 255, whole.
    pub light: Array3<f32>,
    /// How what the middle frame shows moves; not known of video.
    pub flow: Option<Flow>,
    /// The photograph behind, or the video, by its file name.
    pub name: Arc<str>,
}

impl Clip {
    /// The number of the middle frame.
    #[must_use]
    pub fn middle(&self) -> usize {
        middle(self.light.dim().0)
    }
}

/// The number of the middle frame of so many.
pub(super) const fn middle(frames: usize) -> usize {
    frames / 2
}

/// Optical flow of the middle frame, exact.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// How far what is at the middle of each pixel moves to the right until the next frame, in
    /// pixels.
    pub u: Plane<f32>,
    /// The same, down.
    pub v: Plane<f32>,
    /// Whether it is seen at both ends: in the next frame it is neither hidden by the other layer
    /// nor beyond the border.
    pub seen: Plane<bool>,
}
