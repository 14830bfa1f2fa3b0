//! What was seen of a scene while it was watched: the extent of its light, its cuts, and frames
//! that repeat.

use std::{
    fmt::Write as _,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use super::{
    cut::{Cut, Cuts},
    repeated_frames::{Repeated, Repeats},
    seen_light::SeenLight,
};
use crate::{
    elementary,
    scene::{Alias, Frame, Gap, Light, Outline, Scene, SceneError, Slice, Unlike},
    unit::counted,
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
    /// Times of the first and the last frame, in seconds.
    ends: (f64, f64),
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

    /// What studies tell of the light; none before a scene is watched.
    #[must_use]
    pub fn seen_light(&self) -> Option<SeenLight> {
        let light = self.light()?;
        let (least, most) = self.extent().unzip();
        Some(SeenLight {
            light,
            least,
            most,
            assumed_fps: self.assumed_fps(),
            cuts: self.cuts(),
        })
    }

    /// How samples became light, and what there was of numbers without a scale of their own; none
    /// before a scene is watched.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        let seen = self.seen();
        let light = seen.light?;
        let mut words = light.to_string();
        if light.has_free_scale()
            && let Some((least, most)) = seen.extent
        {
            let (least, most) = (brief(least), brief(most));
            let frames = counted(seen.frames, "frame");
            // Writing to a string cannot fail.
            let _ = write!(words, "; from {least} to {most} in the {frames} shown");
        }
        Some(words)
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

    /// The mean time from frame to frame, in seconds; none of a single frame.
    #[must_use]
    pub fn interval(&self) -> Option<f64> {
        let Seen { frames, ends, .. } = *self.seen();
        (frames > 1).then(|| (ends.1 - ends.0) / (frames - 1) as f64)
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
        if self.frames == 0 {
            self.ends.0 = frame.seconds;
        }
        self.ends.1 = frame.seconds;
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

/// A number in four digits, or in all of a whole one.
fn brief(number: f64) -> String {
    // -0 is 0.
    let number = number + 0.0;
    let size = number.abs();
    if size != 0.0 && !(1e-6..1e12).contains(&size) && number.is_finite() {
        let text = format!("{number:.3e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        return format!("{digits}e{power}");
    }
    if number.fract() == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    let before = elementary::log10(number.abs()).floor().max(-300.0) as i32;
    let after = usize::try_from(3 - before).unwrap_or(0);
    let text = format!("{number:.after$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::brief;

    #[test]
    fn a_number_is_four_digits_or_whole() {
        for (number, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (255.0, "255"),
            (65_535.0, "65535"),
            (0.123_456, "0.1235"),
            (-12.5, "-12.5"),
            (1e-5, "0.00001"),
            (1e300, "1e300"),
            (-1.2344e300, "-1.234e300"),
            (1e-300, "1e-300"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(brief(number), text);
        }
    }
}
