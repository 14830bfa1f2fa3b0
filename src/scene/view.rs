//! What of a scene is shown, and how large.

use super::{space::crop::Crop, time::slice::Slice};
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
