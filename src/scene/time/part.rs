//! Scenes made of another scene: its first frames, or those after them.

use crate::scene::{Frame, Outline, Scene, SceneError};

/// The first frames of a scene.
#[derive(Debug)]
pub struct First<S> {
    source: S,
    left: u64,
}

impl<S: Scene> First<S> {
    /// The first `frames` frames of `source`, or all where it has fewer.
    pub const fn new(source: S, frames: u64) -> Self {
        Self {
            source,
            left: frames,
        }
    }
}

impl<S: Scene> Scene for First<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        Outline {
            frames: source.frames.map(|frames| frames.min(self.left)),
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        self.source.next_frame()
    }
}

/// A scene without its first frames; the others keep their numbers and times.
#[derive(Debug)]
pub struct After<S> {
    source: S,
    skipped: u64,
    left: u64,
}

impl<S: Scene> After<S> {
    /// Without so many.
    pub const fn new(source: S, frames: u64) -> Self {
        Self {
            source,
            skipped: frames,
            left: frames,
        }
    }
}

impl<S: Scene> Scene for After<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        Outline {
            frames: source
                .frames
                .map(|frames| frames.saturating_sub(self.skipped)),
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        while self.left > 0 {
            self.left -= 1;
            if self.source.next_frame()?.is_none() {
                self.left = 0;
            }
        }
        self.source.next_frame()
    }
}
