//! A slice of a scene in time.

use super::slice::{Moment, Slice};
use crate::{
    scene::{Frame, Outline, Scene, SceneError},
    unit::Micros,
};

/// A slice of a scene; its first frame is frame 0 at time 0.
#[derive(Debug)]
pub struct Sliced<S> {
    source: S,
    slice: Slice,
    /// Number and time of its first frame in the source.
    first: Option<(u64, f64)>,
    /// Frames of the source so far.
    seen: u64,
}

impl<S: Scene> Sliced<S> {
    /// The slice of `source`.
    pub const fn new(source: S, slice: Slice) -> Self {
        Self {
            source,
            slice,
            first: None,
            seen: 0,
        }
    }

    /// Frame and time from the start of the slice on.
    fn rebased(&mut self, frame: Frame) -> Frame {
        let (index, seconds) = *self.first.get_or_insert((frame.index, frame.seconds));
        let fps = self.source.fps();
        let even = |index: u64| index as f64 / fps;
        let is_even = frame.seconds == even(frame.index) && seconds == even(index);
        let number = frame.index - index;
        Frame {
            index: number,
            // Not a difference, which would be rounded twice.
            seconds: if is_even {
                even(number)
            } else {
                frame.seconds - seconds
            },
            light: frame.light,
        }
    }
}

impl<S: Scene> Scene for Sliced<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        let frames = match (self.slice.from, self.slice.to) {
            (Moment::Frame(from), Some(Moment::Frame(to))) => {
                source.frames.map(|all| all.min(to).saturating_sub(from))
            }
            (Moment::Frame(from), None) => source.frames.map(|all| all.saturating_sub(from)),
            _ => None,
        };
        Outline {
            frames,
            slice: Some(self.slice),
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        // Whether the source goes on behind the slice: how many frames it has is then not known.
        let mut goes_on = false;
        while let Some(frame) = self.source.next_frame()? {
            self.seen += 1;
            if self.slice.to.is_some_and(|to| is_reached(to, &frame)) {
                goes_on = true;
                break;
            }
            if is_reached(self.slice.from, &frame) {
                return Ok(Some(self.rebased(frame)));
            }
        }
        if self.first.is_none() {
            return Err(SceneError::EmptySlice {
                slice: self.slice.to_string(),
                frames: (!goes_on).then_some(self.seen),
                fps: self.source.fps(),
            });
        }
        Ok(None)
    }
}

/// Whether this frame is the moment, or later.
fn is_reached(moment: Moment, frame: &Frame) -> bool {
    match moment {
        Moment::Frame(number) => frame.index >= number,
        Moment::Time(time) => Micros::from_seconds(frame.seconds) >= time,
    }
}
