//! Light over time: one frame after another, pushed one way.
//!
//! A [`Scene`] is read once, frame by frame, so memory does not grow with a clip's length.
//! Frame `n` is at `n / fps` seconds, computed from `n` (never accumulated), so time does
//! not drift.

use crate::plane::{Plane, Size};

/// One picture of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Number of the frame, from 0.
    pub index: u64,
    /// When it was taken, in seconds.
    pub seconds: f64,
    /// Linear light, `[y, x]`: 0 to 255 for 8-bit video, as given for `.npy`.
    pub light: Plane<f64>,
}

/// A source of frames, all of one size.
pub trait Scene: Send {
    /// Size of every frame.
    fn size(&self) -> Size;

    /// Frames per second.
    fn fps(&self) -> f64;

    /// How many frames there are, where that is known beforehand.
    fn frames(&self) -> Option<u64>;

    /// The next frame; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read, or a frame is damaged, of another size, or not finite.
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError>;
}

/// Why a scene cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SceneError {
    /// The file cannot be opened or read.
    #[error("{path}: {cause}")]
    #[diagnostic(help("give a file that exists and can be read"))]
    Unreadable {
        /// Which file.
        path: std::path::PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
}
