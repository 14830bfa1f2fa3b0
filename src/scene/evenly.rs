//! Frames inserted evenly: the same light, looked at more often.
//!
//! [`Upsampled`](super::upsample::Upsampled) inserts where light changes fast, so that its
//! steps are not of one length. A chip decides at its own rate: here every step is a whole part
//! of a frame interval. Between two frames of the source each pixel's light is a straight line
//! in time, as there.

use std::num::NonZeroU32;

use ndarray::Zip;

use super::{Frame, Scene, SceneError, light};
use crate::plane::{Plane, Size};

/// A scene with so many steps from each frame of its source to the next.
///
/// All frames of the source are among the frames, unchanged and at their own times.
#[derive(Debug)]
pub struct Evenly<S> {
    source: S,
    times: NonZeroU32,
    /// The frames of the source on both sides; none before the first and after the last.
    between: Option<(Frame, Option<Frame>)>,
    /// Steps since the first of them.
    step: u32,
    given: u64,
}

impl<S: Scene> Evenly<S> {
    /// So many frames for each of the source.
    pub const fn new(source: S, times: NonZeroU32) -> Self {
        Self {
            source,
            times,
            between: None,
            step: 0,
            given: 0,
        }
    }
}

impl<S: Scene> Scene for Evenly<S> {
    fn size(&self) -> Size {
        self.source.size()
    }

    fn fps(&self) -> f64 {
        self.source.fps() * f64::from(self.times.get())
    }

    fn fps_is_assumed(&self) -> bool {
        self.source.fps_is_assumed()
    }

    fn frames(&self) -> Option<u64> {
        let frames = self.source.frames()?;
        Some(match frames.checked_sub(1) {
            Some(gaps) => gaps * u64::from(self.times.get()) + 1,
            None => 0,
        })
    }

    /// Those of the source, the frames on both sides, and the one that is made.
    fn bytes(&self) -> u128 {
        self.source.bytes() + 3 * light::PIXEL_BYTES * self.size().pixels() as u128
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let (from, to) = match self.between.take() {
            Some((_, None)) => return Ok(None),
            Some((from, Some(to))) if self.step < self.times.get() => (from, Some(to)),
            Some((_, Some(to))) => {
                self.step = 0;
                (to, self.source.next_frame()?)
            }
            None if self.given > 0 => return Ok(None),
            None => match self.source.next_frame()? {
                Some(first) => (first, self.source.next_frame()?),
                None => return Ok(None),
            },
        };
        let share = f64::from(self.step) / f64::from(self.times.get());
        let frame = Frame {
            index: self.given,
            seconds: match &to {
                Some(to) => from.seconds + (to.seconds - from.seconds) * share,
                None => from.seconds,
            },
            light: match &to {
                Some(to) if self.step > 0 => mixed(&from.light, &to.light, share),
                _ => from.light.clone(),
            },
        };
        self.step += 1;
        self.given += 1;
        self.between = Some((from, to));
        Ok(Some(frame))
    }
}

/// A share of the way from one light to another.
fn mixed(a: &Plane<f64>, b: &Plane<f64>, share: f64) -> Plane<f64> {
    Zip::from(a).and(b).map_collect(|a, b| a + (b - a) * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{OpenOptions, bundled, open};

    fn all(mut scene: impl Scene) -> Vec<Frame> {
        let mut frames = Vec::new();
        while let Some(frame) = scene.next_frame().unwrap() {
            frames.push(frame);
        }
        frames
    }

    #[test]
    fn frames_of_the_source_stay_and_the_others_lie_on_the_way() {
        let times = NonZeroU32::new(4).unwrap();
        let source = || {
            let mut scene = bundled().unwrap();
            let frames: Vec<_> = (0..3)
                .map(|_| scene.next_frame().unwrap().unwrap())
                .collect();
            frames
        };
        let scene = || crate::scene::part::First::new(bundled().unwrap(), 3);
        let more = Evenly::new(scene(), times);
        assert_eq!((more.fps(), more.frames()), (40.0, Some(9)));
        let (given, own) = (all(more), source());
        assert_eq!(given.len(), 9);
        for (i, frame) in given.iter().enumerate() {
            assert_eq!(frame.index, i as u64);
            assert!((frame.seconds - i as f64 / 40.0).abs() < 1e-9);
        }
        for (i, frame) in own.iter().enumerate() {
            assert_eq!(given[4 * i].light, frame.light);
            assert_eq!(given[4 * i].seconds, frame.seconds);
        }
        for at in [(0, 0), (128, 200), (255, 255)] {
            let [a, b] = [0, 1].map(|i: usize| own[i].light[at]);
            assert_eq!(given[1].light[at], a + (b - a) * 0.25);
        }
    }

    #[test]
    fn one_step_is_the_source_and_one_frame_stays_one() {
        let one = NonZeroU32::MIN;
        assert_eq!(all(Evenly::new(bundled().unwrap(), one)).len(), 72);
        let still = open(
            "pattern:disc?width=8&height=8&frames=1",
            &OpenOptions::default(),
        );
        let still = Evenly::new(still.unwrap(), NonZeroU32::new(5).unwrap());
        assert_eq!(all(still).len(), 1);
    }
}
