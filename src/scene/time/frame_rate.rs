//! Frame rates, and whether they are given or assumed.

use std::{fmt, path::Path};

use crate::scene::SceneError;

/// Frames per second where nobody says (`.npy`, folders, stills): the rate of the clips on
/// which the RGC sensor's authors trained (`GoPro`, 240 frames/s; quoted).
pub const ASSUMED_FPS: f64 = 240.0;

/// A frame rate and whether it is only assumed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Rate {
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

/// The most frames per second: a thousand within a microsecond, between which events are not told
/// apart.
pub(in crate::scene) const MOST_FPS: f64 = 1e9;

/// Whether a number can be a frame rate.
fn usable(fps: f64) -> bool {
    fps > 0.0 && fps <= MOST_FPS
}

/// Refuses a number of frames per second that is no rate.
///
/// # Errors
/// [`SceneError::BadRate`].
pub fn check_rate(fps: f64) -> Result<(), SceneError> {
    if usable(fps) {
        Ok(())
    } else {
        Err(SceneError::BadRate { fps })
    }
}

/// A number that is no rate, without hundreds of digits.
pub(in crate::scene) struct Shown(pub f64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size > MOST_FPS || (size > 0.0 && size < 1e-6) {
            write!(f, "{:e}", self.0)
        } else {
            self.0.fmt(f)
        }
    }
}
