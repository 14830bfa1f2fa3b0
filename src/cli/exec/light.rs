//! What falls on the photodiodes.

use std::path::Path;

use miette::miette;

use super::{super::files, arguments::Arguments};
use crate::{
    limit::FRAMES,
    plane::{Plane, Size},
    program::Program,
    scene::{ASSUMED_FPS, Frame, Observation, Scene, SceneError},
};

/// The light, as it is asked for.
pub struct Light {
    pub scene: Option<Box<dyn Scene>>,
    frames: Option<u64>,
    fps: f64,
}

impl Light {
    pub fn open(
        arguments: &Arguments,
        program: &Program,
        observation: &Observation,
    ) -> miette::Result<Self> {
        let own = program.settings.image.as_ref().map(|image| {
            if image.starts_with("pattern:") {
                return image.clone();
            }
            arguments.source.folder().join(image).display().to_string()
        });
        let asked = arguments.fps.or(program.settings.fps);
        let image = arguments.image.as_deref().or(own.as_deref());
        if let (None, Some(image)) = (&arguments.image, image) {
            files::reads(Path::new(image))?;
        }
        let scene = image
            .map(|spec| arguments.samples.open(Some(spec), asked, observation))
            .transpose()?;
        let found = scene.as_deref().map_or(ASSUMED_FPS, <dyn Scene>::fps);
        let frames = arguments.frames.or(program.settings.frames);
        if frames == Some(0) {
            return Err(miette!(
                help = "the first frame runs `init`, every later one `frame`",
                "--frames 0: nothing would run"
            ));
        }
        if let Some(asked) = frames.filter(|asked| *asked > FRAMES) {
            return Err(miette!(
                help = "run fewer frames, or a clip of your own in parts",
                "{asked} frames; {FRAMES} frames at most"
            ));
        }
        Ok(Self {
            scene,
            frames,
            fps: asked.unwrap_or(found),
        })
    }
}

/// The light as a scene. What ends, a still picture or the dark, is there as long as it is asked
/// for; the dark has the size of the array.
pub struct Lasting {
    light: Light,
    size: Size,
    /// Frames in all, where the scene has fewer.
    enough: u64,
    given: u64,
    /// The light that goes on when the scene ends, kept only if it may end too soon.
    last: Option<Plane<f64>>,
}

impl Lasting {
    /// At least so many frames, unless others are asked for.
    pub fn new(light: Light, size: Size, least: u64) -> Self {
        Self {
            size,
            enough: light.frames.unwrap_or(least),
            light,
            given: 0,
            last: None,
        }
    }
}

impl Scene for Lasting {
    fn size(&self) -> Size {
        self.size
    }

    fn fps(&self) -> f64 {
        self.light.fps
    }

    fn frames(&self) -> Option<u64> {
        self.light.frames
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.light.frames.is_some_and(|asked| self.given >= asked) {
            return Ok(None);
        }
        let scene = self.light.scene.as_mut();
        let too_short = scene
            .as_ref()
            .is_none_or(|scene| scene.frames().is_none_or(|all| all < self.enough));
        let next = match scene {
            Some(scene) => scene.next_frame()?,
            None => None,
        };
        let index = self.given;
        let frame = match next {
            Some(frame) => frame,
            None if index >= self.enough => return Ok(None),
            None => Frame {
                index,
                seconds: index as f64 / self.light.fps,
                light: { self.last.take() }.unwrap_or_else(|| Plane::zeros(self.size.shape())),
            },
        };
        self.given += 1;
        if too_short && self.given < self.enough {
            self.last = Some(frame.light.clone());
        }
        Ok(Some(frame))
    }
}
