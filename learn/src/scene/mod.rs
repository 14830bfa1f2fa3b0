//! What the sensors watch: clips of photographs moved along exact flow, and of video.
//!
//! A clip is a pure function of (photographs, motion, size, frames, seed, index): see [`Clips`].
//! Coordinates are those of the library: x to the right, y down, planes indexed `[y, x]`; light is
//! 0 to 255 in whole steps.

mod affine;
mod clip;
mod clips;
mod error;
mod kept;
mod layer;
mod motion;
mod outline;
mod photographs;
mod video;

use std::fmt::Write as _;

pub use clip::{Clip, Flow};
pub use clips::Clips;
pub use error::SceneError;
pub use kept::PLACE;
pub use motion::Motion;
pub use photographs::{FEWEST, Photograph, Photographs};
pub use video::Video;

/// A digest as it is written.
pub(crate) fn hex(digest: &[u8]) -> String {
    digest.iter().fold(String::new(), |mut text, byte| {
        // A string takes all that is written to it.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
