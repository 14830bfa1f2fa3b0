//! The scene that was watched, in numbers.

use crate::{
    event::Packet,
    plane::Size,
    scene::{Outline, Scene},
    unit::Micros,
};

/// The scene.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SceneSummary {
    /// What it is called.
    pub name: String,
    /// Width of the frames, in pixels.
    pub width: usize,
    /// Height of the frames, in pixels.
    pub height: usize,
    /// Frames that were watched.
    pub frames: u64,
    /// From the first frame to the last.
    pub seconds: f64,
    /// Frames a second, which the chip must keep up with.
    pub fps: f64,
    /// Whether neither the scene nor the caller said so.
    pub fps_is_assumed: bool,
    /// How its samples became light, in words; the JSON of the program has `light` of its own.
    #[serde(skip)]
    pub light: String,
    /// Whether that is linear.
    #[serde(skip)]
    pub is_linear: bool,
}

impl SceneSummary {
    pub(super) fn new(name: &str, scene: &dyn Scene, frames: u64, packet: &Packet) -> Self {
        let Size { height, width } = scene.size();
        let (from, to) = packet.span;
        let Outline {
            coding,
            fps_is_assumed,
            ..
        } = scene.outline();
        Self {
            name: name.to_owned(),
            width,
            height,
            frames,
            seconds: Micros(to.0.saturating_sub(from.0)).seconds(),
            fps: scene.fps(),
            fps_is_assumed,
            light: coding.to_string(),
            is_linear: coding.is_linear(),
        }
    }
}
