//! What is shown to sensors, the same for every verb that has a scene of its own to show: the
//! scene, and how it is read.

use std::path::Path;

use super::{heading, light::Samples};
use crate::{
    cli::output::files::Named,
    isa::Device,
    rig::Larger,
    scene::{Observation, Scene, SceneError},
};

/// What the scene is called where none was given.
const BUNDLED: &str = "the bundled clip";

/// Whether a scene is a pattern that does not say how many frames it has: a program then shows as
/// many of it as it has itself.
pub(in crate::cli) fn goes_on(scene: &str) -> bool {
    scene.starts_with("pattern:") && !scene.contains("frames=")
}

/// A scene that must be given, and how it is read.
#[derive(Clone, Debug, clap::Args)]
pub(in crate::cli) struct GivenScene {
    /// Scene: a clip, a folder of pictures, a picture, a .npy, a pattern, or `bundled`
    ///
    /// Clips are .y4m, .mp4, .mov, .m4v, .gif and .apng, pictures .png, .pgm, .ppm and .pnm. A
    /// folder is shown in the order of the numbers in its names. A .npy has the shape (T,H,W). A
    /// pattern is pattern:NAME?key=value (see `amacrine list patterns`).
    #[arg(long, alias = "image")]
    pub(in crate::cli) scene: Named,
    #[command(flatten)]
    pub(in crate::cli) samples: Samples,
}

impl GivenScene {
    /// The scene from its start; what is seen of it is noted.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub(in crate::cli) fn open(
        &self,
        observation: &Observation,
    ) -> Result<Box<dyn Scene>, SceneError> {
        self.samples.open(Some(&self.scene), observation)
    }

    /// What a sensor made of it is called.
    pub(in crate::cli) fn seen_by(&self, sensor: &Path) -> String {
        format!("{} seen by {}", self.scene, sensor.display())
    }
}

/// A scene that may be given, and how it is read.
#[derive(Clone, Debug, clap::Args)]
pub(in crate::cli) struct Clip {
    /// Scene: a clip, image folder, .npy or pattern [default: the bundled clip]
    #[arg(long, alias = "image", help_heading = heading::SCENE)]
    scene: Option<Named>,
    #[command(flatten)]
    samples: Samples,
}

impl Clip {
    /// The scene from its start; what is seen of it is noted.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub(in crate::cli) fn open(
        &self,
        observation: &Observation,
    ) -> Result<Box<dyn Scene>, SceneError> {
        self.samples.open(self.scene.as_deref(), observation)
    }

    /// Refuses a scene that is larger than the chip's array.
    ///
    /// # Errors
    /// When it is.
    pub(in crate::cli) fn check_fits(
        &self,
        scene: &dyn Scene,
        device: &Device,
    ) -> miette::Result<()> {
        let name = self.given().map(|name| format!("--scene {name}"));
        let name = name.as_deref().unwrap_or(BUNDLED);
        Ok(Larger::check(name, scene.size(), device)?)
    }

    /// What it is called.
    pub(in crate::cli) fn name(&self) -> &str {
        self.scene.as_deref().unwrap_or(BUNDLED)
    }

    /// The scene that was given.
    pub(in crate::cli) fn given(&self) -> Option<&str> {
        self.scene.as_deref()
    }

    /// Frames per second, where they were given.
    pub(in crate::cli) const fn fps(&self) -> Option<f64> {
        self.samples.fps()
    }

    /// The options that were given, as they are written.
    pub(in crate::cli) fn written(&self) -> Vec<(&'static str, String)> {
        let scene = { self.scene.as_deref() }.map(|scene| ("scene", scene.to_owned()));
        scene.into_iter().chain(self.samples.written()).collect()
    }
}
