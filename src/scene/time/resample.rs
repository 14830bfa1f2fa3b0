//! The same light shown at another frame rate.
//!
//! Between two frames of a source each pixel's light is a straight line in time, as in
//! [`upsample`](super::upsample): things fade, they do not move. Frames come at whole multiples
//! of 1/fps after the first one, computed from their number. Where a frame of the source is at
//! such a moment it is given unchanged.

use ndarray::Zip;

use crate::scene::{Frame, Outline, Scene, SceneError, check_rate};

/// Moments closer than this are one: half of what events tell apart, in seconds.
const SAME: f64 = 5e-7;

/// A scene whose light is shown so many times a second.
#[derive(Debug)]
pub struct Resampled<S> {
    source: S,
    fps: f64,
    given: u64,
    /// When the first frame was.
    start: f64,
    /// The frame of the source at or before the next moment, and the one after it.
    between: Option<(Frame, Option<Frame>)>,
}

impl<S: Scene> Resampled<S> {
    /// So many frames a second, from the first frame of the source to its last.
    ///
    /// # Errors
    /// When the rate is not a finite number above 0.
    pub fn new(source: S, fps: f64) -> Result<Self, SceneError> {
        check_rate(fps)?;
        Ok(Self {
            source,
            fps,
            given: 0,
            start: 0.0,
            between: None,
        })
    }

    fn begin(&mut self) -> Result<bool, SceneError> {
        let Some(first) = self.source.next_frame()? else {
            return Ok(false);
        };
        self.start = first.seconds;
        let second = self.source.next_frame()?;
        self.between = Some((first, second));
        Ok(true)
    }
}

impl<S: Scene> Scene for Resampled<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        // How many there are is known where the source knows; `as` saturates.
        let frames = source.frames.map(|frames| match frames.checked_sub(1) {
            Some(intervals) => ((intervals as f64 / source.fps + SAME) * self.fps) as u64 + 1,
            None => 0,
        });
        // The frames on both sides, and the one that is given.
        let held = 3 * crate::scene::checks::PIXEL_BYTES * source.size.pixels() as u128;
        Outline {
            fps: self.fps,
            fps_is_assumed: false,
            frames,
            bytes: source.bytes + held,
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.given == 0 && self.between.is_none() && !self.begin()? {
            return Ok(None);
        }
        let seconds = self.start + self.given as f64 / self.fps;
        while let Some((_, Some(to))) = &self.between
            && to.seconds <= seconds + SAME
        {
            let next = self.source.next_frame()?;
            if let Some((_, Some(to))) = self.between.take() {
                self.between = Some((to, next));
            }
        }
        let Some((from, to)) = &self.between else {
            return Ok(None);
        };
        let (seconds, light) = if (seconds - from.seconds).abs() <= SAME {
            (from.seconds, from.light.clone())
        } else if let Some(to) = to {
            let share = (seconds - from.seconds) / (to.seconds - from.seconds);
            let mut light = from.light.clone().into_plane();
            Zip::from(&mut light)
                .and(&*to.light)
                .for_each(|now, to| *now += (to - *now) * share);
            (seconds, light.into())
        } else {
            // The last frame of the source is past.
            return Ok(None);
        };
        let index = self.given;
        self.given += 1;
        Ok(Some(Frame {
            index,
            seconds,
            light,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        plane::{Plane, Size},
        scene::memory::held::Held,
    };

    /// One pixel of light 0, 10, 20, … at 10 frames a second.
    fn ramp(frames: u32) -> Held {
        let frame = |i: u32| Frame {
            index: i.into(),
            seconds: f64::from(i) / 10.0,
            light: Plane::from_elem((1, 1), 10.0 * f64::from(i)).into(),
        };
        Held::new((0..frames).map(frame).collect(), Size::new(1, 1), 10.0)
    }

    fn shown(frames: u32, fps: f64) -> Vec<(u64, f64, f64)> {
        let mut scene = Resampled::new(ramp(frames), fps).unwrap();
        let told = scene.frames().unwrap();
        let mut all = Vec::new();
        while let Some(frame) = scene.next_frame().unwrap() {
            all.push((frame.index, frame.seconds, frame.light[(0, 0)]));
        }
        assert_eq!(all.len() as u64, told, "{frames} frames at {fps}");
        assert!(scene.next_frame().unwrap().is_none());
        all
    }

    /// On a ramp the light of every moment is known: 100 a second.
    #[test]
    fn light_lies_on_the_line_between_frames() {
        for (frames, fps, count) in [
            (4, 10.0, 4),
            (4, 40.0, 13),
            (4, 30.0, 10),
            (4, 7.0, 3),
            (4, 5.0, 2),
            (5, 2.5, 2),
            (1, 100.0, 1),
            (0, 100.0, 0),
        ] {
            let all = shown(frames, fps);
            assert_eq!(all.len(), count, "{frames} frames at {fps}");
            for (i, (index, seconds, light)) in all.into_iter().enumerate() {
                assert_eq!(index, i as u64);
                assert!((seconds - i as f64 / fps).abs() < 1e-9);
                assert!(
                    (light - 100.0 * seconds).abs() < 1e-9,
                    "{light} at {seconds}"
                );
            }
        }
    }

    #[test]
    fn frames_of_the_source_are_given_unchanged() {
        let all = shown(8, 130.0);
        for k in 0..8 {
            assert_eq!(all[13 * k].1, k as f64 / 10.0);
            assert_eq!(all[13 * k].2, 10.0 * k as f64);
        }
        for fps in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Resampled::new(ramp(2), fps).is_err());
        }
    }
}
