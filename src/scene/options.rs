//! Options for opening a scene.

use super::Coding;

/// Options that every scene takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenOptions {
    /// Frames per second, in place of what the file says; the rate of most formats without one is
    /// [`ASSUMED_FPS`](super::ASSUMED_FPS).
    pub fps: Option<f64>,
    /// The most bytes that the reader may hold; `None` leaves it to the limits of frames.
    pub memory: Option<u64>,
    /// What its samples mean, where the file is not to decide.
    pub coding: Coding,
}
