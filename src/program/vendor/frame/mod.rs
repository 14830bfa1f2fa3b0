//! Frames and kernels: which words the array is asked for in which frame.
//!
//! - [`frame_loop`]: the loop over the frames, its first iteration and its steady one.
//! - [`beside`]: the host runs beside the array instead, and decides by what it reads.
//! - [`kernel`]: where kernels begin and end, and objects that hold them; [`recording`]: their words,
//!   recorded once and launched.
//! - [`light`]: which statements take in light.

pub(super) mod beside;
pub(super) mod frame_loop;
pub(super) mod kernel;
mod light;
mod recording;
