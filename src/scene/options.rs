//! Options for opening a scene.

use super::{Coding, View};
use crate::memory::Budget;

/// Options that every scene takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenOptions {
    /// Frames per second, in place of what the file says; the rate of most formats without one is
    /// [`ASSUMED_FPS`](super::ASSUMED_FPS).
    pub fps: Option<f64>,
    /// What the program may hold, the reader included; `None` leaves it to the limits of frames.
    /// Frames of a few MiB are read in any case.
    pub memory: Option<Budget>,
    /// What its samples mean, where the file is not to decide.
    pub coding: Coding,
    /// What of it is shown, and how large.
    pub view: View,
}
