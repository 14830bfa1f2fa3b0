//! Frames that are the one before once more.
//!
//! A clip that was filmed at a lower rate than its file has shows each picture several times. All
//! that moves then moves in the frames between, at a multiple of its speed, and events come in
//! bursts. Video that was coded with loss changes a little where it repeats: a frame that changes by
//! less than a part ([`LITTLE`]) of what frames do before and after it repeats the one before. A
//! scene that stands still for long repeats frames too, and rightly: only short runs between frames
//! that change are counted. What holds numbers, not codes, or few pixels, is not looked at.

use crate::scene::{Image, light::image::Codes};

/// A run that is longer is a scene that stands still.
const LONGEST: usize = 4;

/// The part of the change before and of the change after that coding with loss makes of none:
/// x264 at its default quality makes 0.01 to 0.06 of it in clips that move.
const LITTLE: f64 = 0.1;

/// Pixels of the smallest picture that is looked at: a few pixels of a still scene often hold their
/// value while the others of the clip change.
const FEWEST: usize = 32 * 32;

/// Frames that are looked at; a clip that is longer is not looked at to its end.
const MOST: usize = 1 << 20;

/// Of all frames, those that repeat the one before in short runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Repeated {
    /// How many frames do.
    pub frames: u64,
    /// All frames that were seen.
    pub of: u64,
}

impl Repeated {
    /// The number of frames of which one is to go, again and again, where that is what there is.
    #[must_use]
    pub fn cycle(&self) -> Option<u64> {
        let one_of = self.of as f64 / self.frames.max(1) as f64;
        let cycle = one_of.round();
        // A run at an end may be cut off.
        let far = (self.frames as f64 - self.of as f64 / cycle).abs();
        (cycle >= 2.0 && far <= 2.0 + 0.02 * self.of as f64).then_some(cycle as u64)
    }
}

/// Looks for repeated frames.
#[derive(Debug, Default)]
pub(super) struct Repeats {
    before: Option<Codes>,
    /// The mean change of a code from each frame to the next.
    changes: Vec<f64>,
}

impl Repeats {
    /// The next frame.
    pub fn see(&mut self, light: &Image) {
        let Some(coded) = light.coded() else {
            return;
        };
        if self.changes.len() == MOST || light.size().pixels() < FEWEST {
            return;
        }
        let codes = coded.codes();
        if let Some(before) = self.before.replace(codes.clone()) {
            self.changes.push(before.mean_change(codes));
        }
    }

    /// What was found; none where no frame is repeated between two changes.
    pub fn found(&self) -> Option<Repeated> {
        let repeats: Vec<bool> = (0..self.changes.len())
            .map(|at| self.is_little(at))
            .collect();
        let runs = repeats.chunk_by(|a, b| a == b);
        let (mut frames, mut is_between, mut at) = (0, false, 0);
        for run in runs {
            let is_end = at == 0 || at + run.len() == repeats.len();
            if run[0] && run.len() <= LONGEST {
                frames += run.len() as u64;
                is_between |= !is_end;
            }
            at += run.len();
        }
        is_between.then_some(Repeated {
            frames,
            of: self.changes.len() as u64 + 1,
        })
    }

    /// Whether this change is none beside those of the frames around it.
    fn is_little(&self, at: usize) -> bool {
        let change = self.changes[at];
        let most = |changes: &[f64]| changes.iter().copied().reduce(f64::max);
        let before = most(&self.changes[at.saturating_sub(LONGEST)..at]);
        let to = (at + 1 + LONGEST).min(self.changes.len());
        let after = most(&self.changes[at + 1..to]);
        let [before, after] = [before.or(after), after.or(before)].map(Option::unwrap_or_default);
        change == 0.0 || change <= LITTLE * before.min(after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Size;
    use crate::scene::light::image::Levels;

    /// What is found in frames of these pictures.
    fn found(pictures: &[u8]) -> Option<(u64, u64)> {
        let mut repeats = Repeats::default();
        for picture in pictures {
            let codes = vec![*picture; FEWEST];
            let image = Image::of_bytes(Size::new(32, 32), codes, Levels::bytes());
            repeats.see(&image.expect("as many codes"));
        }
        repeats.found().map(|found| (found.frames, found.of))
    }

    #[test]
    fn short_runs_between_changes_are_counted() {
        assert_eq!(found(&[1, 2, 3, 4]), None);
        assert_eq!(found(&[1, 2, 2, 3, 3, 4, 4]), Some((3, 7)));
        assert_eq!(found(&[1, 1, 2, 2, 3]), Some((2, 5)));
        // What stands still before it moves, for long, or at the end, repeats nothing.
        assert_eq!(found(&[1, 1, 1, 2, 3]), None);
        assert_eq!(found(&[1, 2, 2, 2, 2, 2, 2, 3, 4]), None);
        assert_eq!(found(&[1, 2, 3, 3, 3]), None);
    }

    #[test]
    fn what_loss_leaves_of_a_repeated_frame_is_a_repeat() {
        // A ramp that moves on every second frame, and trembles by one code between.
        assert_eq!(found(&[10, 11, 31, 30, 50, 51, 71, 70, 90]), Some((4, 9)));
        // Slow and fast are no repeats, nor is what trembles before it moves.
        assert_eq!(found(&[10, 14, 34, 38, 58, 62]), None);
        assert_eq!(found(&[10, 11, 10, 11, 10, 11, 31, 51, 71]), None);
        let cycle = |frames, of| Repeated { frames, of }.cycle();
        assert_eq!(
            [cycle(30, 60), cycle(49, 100), cycle(20, 100)],
            [Some(2), Some(2), Some(5)]
        );
        assert_eq!([cycle(60, 100), cycle(40, 100)], [None, None]);
    }

    #[test]
    fn few_pixels_and_numbers_are_not_looked_at() {
        let mut repeats = Repeats::default();
        for code in [1, 2, 2, 3, 3, 4, 4] {
            let few = Image::of_bytes(Size::new(31, 32), vec![code; 31 * 32], Levels::bytes());
            repeats.see(&few.expect("as many codes"));
        }
        assert_eq!(repeats.found(), None);
        let mut repeats = Repeats::default();
        for _ in 0..8 {
            repeats.see(&crate::plane::Plane::zeros((2, 2)).into());
        }
        assert_eq!(repeats.found(), None);
    }
}
