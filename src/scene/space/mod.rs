//! Scenes in space: which part of a picture is shown, and how large.
//!
//! - [`crop`]: the part that is asked for; [`cropped`]: a scene of it.
//! - [`resized`]: a scene in larger pixels.

pub(super) mod crop;
pub(super) mod cropped;
pub(super) mod resized;
