//! Frames that are held in memory, to be shown again and again.

use std::sync::Arc;

use crate::{
    plane::Size,
    scene::{Frame, Outline, Scene, SceneError},
};

/// Frames in memory, as a scene.
#[derive(Clone, Debug)]
pub struct Held {
    frames: Arc<[Frame]>,
    size: Size,
    fps: f64,
    given: usize,
}

impl Held {
    /// Of frames of this size, so many a second.
    #[must_use]
    pub fn new(frames: Vec<Frame>, size: Size, fps: f64) -> Self {
        Self {
            frames: frames.into(),
            size,
            fps,
            given: 0,
        }
    }

    /// The frames, those that were given included.
    #[must_use]
    pub fn all(&self) -> &[Frame] {
        &self.frames
    }

    /// The same frames, from the first on.
    #[must_use]
    pub fn again(&self) -> Self {
        Self {
            given: 0,
            ..self.clone()
        }
    }
}

impl Scene for Held {
    fn outline(&self) -> Outline {
        Outline {
            frames: Some(self.frames.len() as u64),
            ..Outline::new(self.size, self.fps)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let frame = self.frames.get(self.given).cloned();
        self.given += usize::from(frame.is_some());
        Ok(frame)
    }
}
