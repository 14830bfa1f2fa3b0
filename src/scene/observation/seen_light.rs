//! What studies tell of the light that they showed.

use serde::Serialize;

use super::cut::Cut;
use crate::scene::Light;

/// How samples became light, and what was seen of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SeenLight {
    /// How samples became light.
    #[serde(flatten)]
    pub light: Light,
    /// The least light of all frames that were seen, 0 to 255; none where none was.
    pub least: Option<f64>,
    /// The most.
    pub most: Option<f64>,
    /// Frames per second, where nobody said them.
    pub assumed_fps: Option<f64>,
    /// Where one scene ends and another begins.
    pub cuts: Vec<Cut>,
}
