//! Frames that are the one before once more.
//!
//! A clip that was filmed at a lower rate than its file has shows each picture several times. All
//! that moves then moves in the frames between, at a multiple of its speed, and events come in
//! bursts. A scene that stands still for long repeats frames too, and rightly: only short runs
//! between frames that change are counted. What holds numbers, not codes, is not looked at.

use super::{Image, image::Codes};

/// A run that is longer is a scene that stands still.
const LONGEST: u64 = 4;

/// Of all frames, those that repeat the one before in short runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Repeated {
    /// How many frames do.
    pub frames: u64,
    /// All frames that were seen.
    pub of: u64,
}

/// Looks for repeated frames.
#[derive(Debug, Default)]
pub(super) struct Repeats {
    before: Option<Codes>,
    seen: u64,
    /// Frames that repeat the one before since the last change.
    run: u64,
    /// The run before the first change, once there was one.
    first: Option<u64>,
    /// In short runs between two changes.
    between: u64,
}

impl Repeats {
    /// The next frame.
    pub fn see(&mut self, light: &Image) {
        let Some(coded) = light.coded() else {
            return;
        };
        self.seen += 1;
        let codes = coded.codes().clone();
        let Some(before) = self.before.replace(codes) else {
            return;
        };
        if self.before.as_ref() == Some(&before) {
            self.run += 1;
            return;
        }
        let run = std::mem::take(&mut self.run);
        if self.first.is_some() {
            self.between += short(run);
        } else {
            self.first = Some(run);
        }
    }

    /// What was found; none where no frame is repeated between two changes.
    pub fn found(&self) -> Option<Repeated> {
        let ends = short(self.first.unwrap_or(0)) + short(self.run);
        (self.between > 0).then_some(Repeated {
            frames: self.between + ends,
            of: self.seen,
        })
    }
}

/// A run, unless it is long.
const fn short(run: u64) -> u64 {
    if run > LONGEST { 0 } else { run }
}

#[cfg(test)]
mod tests {
    use super::{super::image::Levels, *};
    use crate::plane::Size;

    /// What is found in frames of these pictures.
    fn found(pictures: &[u8]) -> Option<(u64, u64)> {
        let mut repeats = Repeats::default();
        for picture in pictures {
            let codes = vec![*picture; 4];
            let image = Image::of_bytes(Size::new(2, 2), codes, Levels::bytes());
            repeats.see(&image.expect("four codes"));
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
    fn numbers_are_not_looked_at() {
        let mut repeats = Repeats::default();
        for _ in 0..8 {
            repeats.see(&crate::plane::Plane::zeros((2, 2)).into());
        }
        assert_eq!(repeats.found(), None);
    }
}
