//! Frame rates, and whether they are given or assumed.

use std::path::Path;

use super::SceneError;

/// Frames per second where nobody says (`.npy`, folders, stills): the rate of the clips on
/// which the RGC sensor's authors trained (`GoPro`, 240 frames/s; quoted).
pub const ASSUMED_FPS: f64 = 240.0;

/// A frame rate and whether it is only assumed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rate {
    pub fps: f64,
    pub assumed: bool,
}

impl Rate {
    /// The caller's rate, else [`ASSUMED_FPS`].
    pub fn asked_or_assumed(asked: Option<f64>) -> Self {
        Self {
            fps: asked.unwrap_or(ASSUMED_FPS),
            assumed: asked.is_none(),
        }
    }

    /// The caller's rate, else the one in the file, which must be a usable number.
    pub fn asked_or_found(
        asked: Option<f64>,
        found: Option<f64>,
        path: &Path,
    ) -> Result<Self, SceneError> {
        match asked.or(found.filter(|fps| usable(*fps))) {
            Some(fps) => Ok(Self {
                fps,
                assumed: false,
            }),
            None => Err(SceneError::NoRate { path: path.into() }),
        }
    }

    /// When frame `index` is: computed from its number, so that it does not drift.
    pub fn seconds(self, index: u64) -> f64 {
        index as f64 / self.fps
    }
}

/// Whether a number can be a frame rate.
pub(super) fn usable(fps: f64) -> bool {
    fps.is_finite() && fps > 0.0
}
