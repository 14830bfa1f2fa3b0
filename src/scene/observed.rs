//! What was seen of a scene while it was watched: the extent of its light, its cuts, and frames
//! that repeat.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{
    Alias, Frame, Gap, Light, Outline, Scene, SceneError, Slice, Unlike,
    cut::{Cut, Cuts},
    repeats::{Repeated, Repeats},
};

/// What was seen of a scene. Clones share it, so that it can be asked while somebody else has
/// the scene, and filled by several passes: a frame counts once.
#[derive(Clone, Debug, Default)]
pub struct Observation(Arc<Mutex<Seen>>);

#[derive(Debug, Default)]
struct Seen {
    light: Option<Light>,
    assumed_fps: Option<f64>,
    gap: Option<Gap>,
    alias: Option<Alias>,
    unlike: Option<Unlike>,
    slice: Option<Slice>,
    frames: u64,
    extent: Option<(f64, f64)>,
    cuts: Cuts,
    repeats: Repeats,
}

impl Observation {
    /// Nothing seen yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn seen(&self) -> MutexGuard<'_, Seen> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes what a scene says of itself.
    pub fn begin(&self, outline: &Outline) {
        let mut seen = self.seen();
        seen.light = Some(outline.coding);
        seen.gap = outline.gap;
        seen.alias = outline.alias;
        seen.unlike = outline.unlike;
        seen.slice = outline.slice;
        seen.assumed_fps =
            (outline.fps_is_assumed && outline.frames != Some(1)).then_some(outline.fps);
    }

    /// Sees a frame, the next one of its scene.
    pub fn see(&self, frame: &Frame) {
        self.seen().see(frame);
    }

    /// How samples became light; none before a scene is watched.
    #[must_use]
    pub fn light(&self) -> Option<Light> {
        self.seen().light
    }

    /// The frame rate, where it is assumed and matters: neither the scene nor the caller said one,
    /// and there is not just one picture.
    #[must_use]
    pub fn assumed_fps(&self) -> Option<f64> {
        self.seen().assumed_fps
    }

    /// Numbers that are missing among those of its pictures.
    #[must_use]
    pub fn gap(&self) -> Option<Gap> {
        self.seen().gap
    }

    /// What a pattern draws finer than pixels or faster than frames.
    #[must_use]
    pub fn alias(&self) -> Option<Alias> {
        self.seen().alias
    }

    /// How players show it otherwise.
    #[must_use]
    pub fn unlike(&self) -> Option<Unlike> {
        self.seen().unlike
    }

    /// Which slice of its clip the scene is; none where it is all of it.
    #[must_use]
    pub fn slice(&self) -> Option<Slice> {
        self.seen().slice
    }

    /// Frames that were seen.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.seen().frames
    }

    /// The least and the most light of all frames that were seen.
    #[must_use]
    pub fn extent(&self) -> Option<(f64, f64)> {
        self.seen().extent
    }

    /// Cuts among the frames that were seen; a pattern has none.
    #[must_use]
    pub fn cuts(&self) -> Vec<Cut> {
        self.seen().cuts.found()
    }

    /// Frames that repeat the one before; a pattern has none.
    #[must_use]
    pub fn repeated(&self) -> Option<Repeated> {
        self.seen().repeats.found()
    }
}

impl Seen {
    fn see(&mut self, frame: &Frame) {
        // A later pass over the same scene: each frame counts once.
        if frame.index != self.frames {
            return;
        }
        self.frames += 1;
        let (low, high) = self.extent.unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        let ends = frame.light.extent();
        self.extent = Some(ends.map_or((low, high), |(a, b)| (low.min(a), high.max(b))));
        if self.light.is_none_or(|l| !l.samples.are_of_a_pattern()) {
            self.cuts.see(&frame.light, frame.seconds);
            self.repeats.see(&frame.light);
        }
    }
}

/// A scene under observation, which gives its frames unchanged.
#[derive(Debug)]
pub struct Observed<S> {
    scene: S,
    observation: Observation,
}

impl<S: Scene> Observed<S> {
    /// Notes in `observation` what is seen.
    pub fn new(scene: S, observation: &Observation) -> Self {
        observation.begin(&scene.outline());
        Self {
            scene,
            observation: observation.clone(),
        }
    }
}

impl<S: Scene> Scene for Observed<S> {
    fn outline(&self) -> Outline {
        self.scene.outline()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let next = self.scene.next_frame()?;
        if let Some(frame) = &next {
            self.observation.see(frame);
        }
        Ok(next)
    }
}
