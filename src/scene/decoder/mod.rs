//! Decoders: from files to frames.
//!
//! - [`y4m`], [`mp4`]: video; [`animation`]: GIF and APNG, on a [`canvas`].
//! - [`folder`]: pictures in natural order; [`still`]: one picture, PNG or [`pgm`]; [`png_chunks`]:
//!   what a PNG says about its samples.
//! - [`npy`]: arrays of numbers.
//! - [`bundled`]: the clip that comes with the program.
//! - [`frame_spacing`]: whether times of frames are even.

pub(super) mod animation;
pub(super) mod bundled;
mod canvas;
pub(super) mod folder;
mod frame_spacing;
pub(super) mod mp4;
pub(super) mod npy;
mod pgm;
mod png_chunks;
pub(super) mod still;
pub(super) mod y4m;
