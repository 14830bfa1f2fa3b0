//! More frames between the frames of a source, where light changes fast.
//!
//! Real clips have 10 to 30 frames a second; an event sensor sees thousands of moments. As
//! in ESIM's adaptive sampling by brightness (Rebecq et al., `CoRL` 2018), no pixel moves by
//! more than a set bound from one frame to the next. Between two source frames each pixel's
//! light is a straight line in time: things fade, they do not move. Each step is as long as
//! the bound allows for the fastest pixel, so steps are not of one length.

use ndarray::Zip;

use crate::{
    elementary,
    plane::Plane,
    scene::{Frame, Image, Outline, Scene, SceneError, checks},
};

/// By how much a pixel may move in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// In natural logarithm: `|ln((b + offset) / (a + offset))| <= contrast`.
    Contrast {
        /// The most change, in ln units.
        contrast: f64,
        /// What is added to light, in its unit, so that black has a logarithm.
        offset: f64,
    },
    /// In light itself: `|b - a| <= light`.
    Light {
        /// The most change, in the unit of light.
        light: f64,
    },
}

/// Settings of the upsampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Upsampling {
    /// By how much a pixel may move in one step.
    pub bound: Bound,
    /// The most steps from one source frame to the next. More are an error, never a bound
    /// that is quietly passed.
    pub most_steps: u32,
}

impl Default for Upsampling {
    /// Contrast 0.1, offset 1 (of 255), at most 1000 steps.
    fn default() -> Self {
        Self {
            bound: Bound::Contrast {
                contrast: 0.1,
                offset: 1.0,
            },
            most_steps: 1000,
        }
    }
}

/// The most frames of an upsampled scene.
pub const MOST_FRAMES: u64 = crate::limit::FRAMES;

/// A scene with frames inserted.
///
/// All frames of the source are among the frames, unchanged and at their own times; their
/// number is then that in the upsampled scene. [`Scene::fps`] stays that of the source.
#[derive(Debug)]
pub struct Upsampled<S> {
    source: S,
    how: Upsampling,
    between: Option<Between>,
    given: u64,
    inserted: u64,
}

/// A pair of source frames, and how far the frames between them have got.
#[derive(Debug)]
struct Between {
    from: Frame,
    to: Frame,
    /// The pixels that decide how long a step may be: their light in `from` and in `to`.
    steepest: Vec<(f64, f64)>,
    /// The position of that frame between `from` and `to`, from 0 to 1.
    share: f64,
    /// Frames given so far in this pair.
    steps: u32,
}

/// A scene with frames inserted where its light changes by more than this contrast, in ln units;
/// as it is without one.
///
/// # Errors
/// When the contrast is not a finite number above 0.
pub fn by_contrast<'a>(
    scene: impl Scene + 'a,
    contrast: Option<f64>,
) -> Result<Box<dyn Scene + 'a>, SceneError> {
    let Some(contrast) = contrast else {
        return Ok(Box::new(scene));
    };
    let bound = Bound::Contrast {
        contrast,
        offset: 1.0,
    };
    let how = Upsampling {
        bound,
        ..Upsampling::default()
    };
    Ok(Box::new(Upsampled::new(scene, how)?))
}

impl<S: Scene> Upsampled<S> {
    /// Upsamples `source`.
    ///
    /// # Errors
    /// When the bound is not a finite number above 0, or no step is allowed.
    pub fn new(source: S, how: Upsampling) -> Result<Self, SceneError> {
        let check = |name, got: f64| {
            (got.is_finite() && got > 0.0)
                .then_some(())
                .ok_or(SceneError::BadBound {
                    name,
                    got,
                    want: "a finite number above 0",
                })
        };
        match how.bound {
            Bound::Contrast { contrast, offset } => {
                check("contrast", contrast)?;
                check("offset", offset)?;
            }
            Bound::Light { light } => check("light", light)?,
        }
        check("most_steps", how.most_steps.into())?;
        Ok(Self {
            source,
            how,
            between: None,
            given: 0,
            inserted: 0,
        })
    }

    /// How many frames were inserted so far.
    #[must_use]
    pub fn inserted(&self) -> u64 {
        self.inserted
    }

    /// The source.
    #[must_use]
    pub fn source(&self) -> &S {
        &self.source
    }

    fn give(&mut self, seconds: f64, light: Image) -> Frame {
        let index = self.given;
        self.given += 1;
        Frame {
            index,
            seconds,
            light,
        }
    }
}

impl<S: Scene> Scene for Upsampled<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        // The frames on both sides, the one in between as it is made and as it is given, and one
        // that has just been passed.
        let held = 5 * checks::PIXEL_BYTES * source.size.pixels() as u128;
        Outline {
            // Not known beforehand; the [`source`](Upsampled::source) knows how many it has.
            frames: None,
            bytes: source.bytes + held,
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let Some(between) = &mut self.between else {
            // The very first frame, or the end.
            let Some(first) = self.source.next_frame()? else {
                return Ok(None);
            };
            self.how.bound.check(&first)?;
            return self.begin(first);
        };
        if between.steps == self.how.most_steps {
            return Err(SceneError::TooManySteps {
                pair: between.from.index,
                most: self.how.most_steps,
            });
        }
        between.steps += 1;
        between.share += self
            .how
            .bound
            .longest_step(&between.steepest, between.share);
        let share = between.share;
        if share < 1.0 {
            let (from, to) = (&between.from, &between.to);
            let light = Zip::from(&*from.light)
                .and(&*to.light)
                .map_collect(|a, b| at(*a, *b, share));
            let seconds = at(from.seconds, to.seconds, share);
            self.inserted += 1;
            return Ok(Some(self.give(seconds, light.into())));
        }
        match self.between.take() {
            Some(between) => self.begin(between.to),
            None => Ok(None),
        }
    }
}

/// What lies so far between two values.
#[must_use]
pub fn at(from: f64, to: f64, share: f64) -> f64 {
    from + (to - from) * share
}

impl Upsampling {
    /// Where the frames between two frames of a source lie, from 0 to 1, both ends left out; none
    /// where they are more than allowed, or light cannot be bounded.
    #[must_use]
    pub fn shares(self, from: &Plane<f64>, to: &Plane<f64>) -> Option<Vec<f64>> {
        if let Bound::Contrast { offset, .. } = self.bound
            && from.iter().chain(to).any(|light| *light + offset <= 0.0)
        {
            return None;
        }
        let steepest = self.bound.steepest(from, to);
        let mut shares = Vec::new();
        let mut share = 0.0;
        loop {
            share += self.bound.longest_step(&steepest, share);
            if share >= 1.0 {
                return Some(shares);
            }
            if shares.len() + 1 >= self.most_steps as usize {
                return None;
            }
            shares.push(share);
        }
    }
}

impl<S: Scene> Upsampled<S> {
    /// Refuses a pair that needs more steps than allowed, before the first of them.
    fn check_steps(&self, from: &Frame, to: &Frame) -> Result<(), SceneError> {
        let least = self.how.bound.least_steps(&from.light, &to.light);
        let Upsampling { most_steps, .. } = self.how;
        // Rounding decides about the last step; it is counted when it is made.
        if least > f64::from(most_steps) + 1.0 {
            return Err(SceneError::TooManySteps {
                pair: from.index,
                most: most_steps,
            });
        }
        if self.given as f64 + least > MOST_FRAMES as f64 {
            return Err(SceneError::Endless {
                frame: to.index,
                most: MOST_FRAMES,
            });
        }
        Ok(())
    }

    /// Gives source frame `from` and reads the one after it.
    fn begin(&mut self, from: Frame) -> Result<Option<Frame>, SceneError> {
        let frame = self.give(from.seconds, from.light.clone());
        if let Some(to) = self.source.next_frame()? {
            self.how.bound.check(&to)?;
            self.check_steps(&from, &to)?;
            self.between = Some(Between {
                steepest: self.how.bound.steepest(&from.light, &to.light),
                from,
                to,
                share: 0.0,
                steps: 0,
            });
        }
        Ok(Some(frame))
    }
}

impl Bound {
    /// Whether the light of a source frame can be bounded.
    fn check(self, frame: &Frame) -> Result<(), SceneError> {
        let Self::Contrast { offset, .. } = self else {
            return Ok(());
        };
        let dark = frame
            .light
            .indexed_iter()
            .find(|(_, v)| **v + offset <= 0.0);
        match dark {
            None => Ok(()),
            Some(((y, x), value)) => Err(SceneError::NoLogarithm {
                frame: frame.index,
                y,
                x,
                value: *value,
                offset,
            }),
        }
    }

    /// The least number of steps between two source frames, which the pixel of largest change
    /// needs.
    fn least_steps(self, from: &Plane<f64>, to: &Plane<f64>) -> f64 {
        let most = |change: &dyn Fn(f64, f64) -> f64| {
            let fold = |most: f64, a: &f64, b: &f64| most.max(change(*a, *b).abs());
            Zip::from(from).and(to).fold(0.0, fold)
        };
        match self {
            Self::Contrast { contrast, offset } => {
                most(&|a, b| elementary::ln((b + offset) / (a + offset))) / contrast
            }
            Self::Light { light } => most(&|a, b| b - a) / light,
        }
    }

    /// The pixels of a pair of frames that can decide about a step, each light once.
    ///
    /// A pixel that goes from `a` to `b` allows `(e^c - 1) ((a + offset) / (b - a) + share)` on its
    /// way up and `(1 - e^-c) ((a + offset) / (a - b) - share)` on its way down, so whichever has
    /// the least `(a + offset) / |b - a|` of its direction allows the least all the way. Those
    /// that rounding cannot tell from it are kept as well.
    fn steepest(self, from: &Plane<f64>, to: &Plane<f64>) -> Vec<(f64, f64)> {
        const NEAR: f64 = 1.0 + 1e-9;
        let room = |a: f64, b: f64| match self {
            Self::Light { .. } => 1.0 / (b - a).abs(),
            Self::Contrast { offset, .. } => (a + offset) / (b - a).abs(),
        };
        let mut least = [f64::INFINITY; 2];
        let mut found = Vec::new();
        Zip::from(from).and(to).for_each(|a, b| {
            let (way, room) = (usize::from(b > a), room(*a, *b));
            if room <= least[way] * NEAR && a != b {
                least[way] = least[way].min(room);
                if found.last() != Some(&(*a, *b)) {
                    found.push((*a, *b));
                }
            }
        });
        let mut steepest = Vec::new();
        for (a, b) in found {
            if room(a, b) <= least[usize::from(b > a)] * NEAR && !steepest.contains(&(a, b)) {
                steepest.push((a, b));
            }
        }
        steepest
    }

    /// The longest step from the light at `share` that keeps the bound, as a share of the interval
    /// between the source frames; infinite where nothing changes.
    fn longest_step(self, steepest: &[(f64, f64)], share: f64) -> f64 {
        let pixels = steepest.iter().copied();
        match self {
            Self::Light { light } => {
                light / pixels.fold(0.0_f64, |most, (a, b)| most.max((b - a).abs()))
            }
            Self::Contrast { contrast, offset } => {
                // Up by e^c - 1 of what there is, or down by 1 - e^-c of it.
                let (up, down) = (elementary::exp_m1(contrast), elementary::exp_m1(-contrast));
                pixels.fold(f64::INFINITY, |longest, (a, b)| {
                    let change = b - a;
                    let may = (at(a, b, share) + offset) * if change > 0.0 { up } else { down };
                    longest.min((may / change).abs())
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{plane::Size, unit::Micros};

    /// Frames in memory.
    struct Clip(Vec<Plane<f64>>, usize);

    impl Scene for Clip {
        fn outline(&self) -> Outline {
            Outline {
                frames: Some(self.0.len() as u64),
                ..Outline::new(Size::of(&self.0[0]), 10.0)
            }
        }
        fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
            let index = self.1;
            self.1 += 1;
            Ok(self.0.get(index).map(|light| Frame {
                index: index as u64,
                seconds: index as f64 / 10.0,
                light: light.clone().into(),
            }))
        }
    }

    fn clip(lights: &[Vec<f64>]) -> Clip {
        let plane = |row: &Vec<f64>| Plane::from_shape_vec((1, row.len()), row.clone()).unwrap();
        Clip(lights.iter().map(plane).collect(), 0)
    }

    fn all(mut scene: Upsampled<Clip>) -> Result<(Vec<Frame>, u64), SceneError> {
        let mut frames = Vec::new();
        while let Some(frame) = scene.next_frame()? {
            frames.push(frame);
        }
        Ok((frames, scene.inserted()))
    }

    fn how(bound: Bound) -> Upsampling {
        Upsampling {
            bound,
            most_steps: 1000,
        }
    }

    proptest! {
        /// The few pixels that are looked at decide as all would, to the bit.
        #[test]
        fn the_steepest_pixels_decide(
            lights in prop::collection::vec((0u8..=255, 0u8..=255), 1..300),
            whole: bool,
            contrast in 0.01..0.5f64,
            offset in 0.5..5.0f64,
        ) {
            let light = |byte: u8| f64::from(byte) * if whole { 1.0 } else { 0.731 };
            let row = |take: fn(&(u8, u8)) -> u8| {
                let row = lights.iter().map(|pair| light(take(pair))).collect();
                Plane::from_shape_vec((1, lights.len()), row).unwrap()
            };
            let (from, to) = (row(|pair| pair.0), row(|pair| pair.1));
            let bound = Bound::Contrast { contrast, offset };
            let all: Vec<(f64, f64)> = from.iter().copied().zip(to.iter().copied()).collect();
            let some = bound.steepest(&from, &to);
            prop_assert!(some.len() <= all.len());
            let mut share = 0.0;
            while share < 1.0 {
                let step = bound.longest_step(&some, share);
                prop_assert_eq!(step.to_bits(), bound.longest_step(&all, share).to_bits());
                share += step;
            }
        }

        #[test]
        fn no_pixel_moves_too_far_and_the_source_is_kept(
            lights in prop::collection::vec(prop::collection::vec(0.0..255.0, 3), 1..5),
            contrast in 0.05..1.0,
            offset in 0.5..5.0,
        ) {
            let (contrast, offset): (f64, f64) = (contrast, offset);
            let bound = Bound::Contrast { contrast, offset };
            let (frames, inserted) = all(Upsampled::new(clip(&lights), how(bound)).unwrap()).unwrap();
            prop_assert_eq!(frames.len() as u64, lights.len() as u64 + inserted);
            for (count, pair) in frames.windows(2).enumerate() {
                prop_assert_eq!(pair[1].index, count as u64 + 1);
                prop_assert!(pair[0].seconds < pair[1].seconds);
                for (a, b) in pair[0].light.iter().zip(&pair[1].light) {
                    let moved = elementary::ln((b + offset) / (a + offset)).abs();
                    prop_assert!(moved <= contrast + 1e-9, "{}", moved);
                }
            }
            // Every source frame is there, as it was and when it was; all others lie on the
            // straight line between their neighbours.
            for (n, light) in lights.iter().enumerate() {
                let seconds = n as f64 / 10.0;
                let frame = frames.iter().find(|f| f.seconds == seconds).unwrap();
                prop_assert_eq!(&frame.light.iter().copied().collect::<Vec<_>>(), light);
            }
            for frame in &frames {
                let n = (frame.seconds * 10.0).floor() as usize;
                let (a, b) = (&lights[n], &lights[(n + 1).min(lights.len() - 1)]);
                let share = frame.seconds * 10.0 - n as f64;
                for ((v, a), b) in frame.light.iter().zip(a).zip(b) {
                    prop_assert!((v - (a + (b - a) * share)).abs() < 1e-9);
                }
            }
        }

        #[test]
        fn the_last_step_is_the_only_one_that_could_be_longer(
            lights in prop::collection::vec(prop::collection::vec(0.0..255.0, 2), 2),
        ) {
            let bound = Bound::Contrast { contrast: 0.2, offset: 1.0 };
            let (frames, _) = all(Upsampled::new(clip(&lights), how(bound)).unwrap()).unwrap();
            for pair in frames[..frames.len() - 1].windows(2) {
                let most = pair[0].light.iter().zip(&pair[1].light)
                    .map(|(a, b)| ((b + 1.0) / (a + 1.0)).ln().abs())
                    .fold(0.0, f64::max);
                prop_assert!((most - 0.2).abs() < 1e-9, "{}", most);
            }
        }
    }

    #[test]
    fn light_can_be_bounded_itself() {
        let lights = [vec![0.0, 9.0], vec![10.0, 9.0], vec![10.0, 9.0]];
        let bound = Bound::Light { light: 4.0 };
        let (frames, inserted) = all(Upsampled::new(clip(&lights), how(bound)).unwrap()).unwrap();
        let dots: Vec<_> = frames
            .iter()
            .map(|f| (f.index, Micros::from_seconds(f.seconds).0, f.light[(0, 0)]))
            .collect();
        assert_eq!(inserted, 2);
        assert_eq!(
            dots,
            [
                (0, 0, 0.0),
                (1, 40_000, 4.0),
                (2, 80_000, 8.0),
                (3, 100_000, 10.0),
                (4, 200_000, 10.0)
            ]
        );
    }

    #[test]
    fn what_cannot_be_bounded_is_an_error() {
        let far = [vec![0.0], vec![255.0]];
        let few = Upsampling {
            most_steps: 10,
            ..Upsampling::default()
        };
        let message = all(Upsampled::new(clip(&far), few).unwrap())
            .unwrap_err()
            .to_string();
        assert_eq!(message, "more than 10 steps between source frames 0 and 1");
        let dark = [vec![3.0], vec![-1.0]];
        let message = all(Upsampled::new(clip(&dark), Upsampling::default()).unwrap());
        assert!(
            message
                .unwrap_err()
                .to_string()
                .starts_with("source frame 1, y 0, x 0: light -1")
        );
        for contrast in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let bound = Bound::Contrast {
                contrast,
                offset: 1.0,
            };
            assert!(Upsampled::new(clip(&far), how(bound)).is_err());
        }
    }
}
