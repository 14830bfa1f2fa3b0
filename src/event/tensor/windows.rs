//! Windows of time, one after the other.

use std::str::FromStr;

use super::{
    error::{TensorError, named, time},
    period::Period,
};
use crate::unit::Micros;

/// Where a window lies about the time it is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alignment {
    /// It ends there: nothing in it comes from later. Window `n` is that of `start + (n + 1) every`.
    #[default]
    Causal,
    /// It has its middle there. Window `n` is that of `start + n every`.
    Centred,
}

const NAMES: [(&str, Alignment); 2] = [
    ("causal", Alignment::Causal),
    ("centred", Alignment::Centred),
];

impl FromStr for Alignment {
    type Err = TensorError;

    fn from_str(text: &str) -> Result<Self, TensorError> {
        named(&NAMES, "alignment", text)
    }
}

/// Windows of one length, each some time after the one before; they may overlap.
///
/// Windows are half-open, (start, end]; the first one has the events at its start, too. An event at
/// the time of a frame is in the window that ends with that frame, and none is lost at 0. Bounds are
/// whole microseconds, as the times of frames and events are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Windows {
    length: Period,
    every: Period,
    alignment: Alignment,
    /// In microseconds.
    start: i64,
}

impl Windows {
    /// Windows of `length` seconds, one `every` so many, from 0 s on.
    ///
    /// # Errors
    /// When one of the two is less than a microsecond, or not finite.
    pub fn new(length: f64, every: f64, alignment: Alignment) -> Result<Self, TensorError> {
        Ok(Self {
            length: Period::from_seconds(time("the window", length)?),
            every: Period::from_seconds(time("the time from window to window", every)?),
            alignment,
            start: 0,
        })
    }

    /// The same, from a time on.
    #[must_use]
    pub const fn from(mut self, start: Micros) -> Self {
        self.start = if start.0 > i64::MAX as u64 {
            i64::MAX
        } else {
            start.0 as i64
        };
        self
    }

    /// The same, without those that end before a time: the first is the one in which it lies.
    #[must_use]
    pub fn reaching(self, first: Micros) -> Self {
        let first = first.0.min(i64::MAX as u64) as i64;
        let start = self.multiple(self.every.within(first), 0);
        self.from(Micros(start.clamp(0, first) as u64))
    }

    /// The time from which they are counted.
    #[must_use]
    pub const fn start(&self) -> Micros {
        Micros(self.start as u64)
    }

    /// Start and end of window `n`, in microseconds; the start may lie before 0.
    #[must_use]
    pub fn bounds(&self, n: u64) -> (i64, i64) {
        let (from, to) = match self.alignment {
            Alignment::Causal => {
                let n = n.saturating_add(1);
                (self.multiple(n, -2), self.multiple(n, 0))
            }
            Alignment::Centred => (self.multiple(n, -1), self.multiple(n, 1)),
        };
        let from = self.start.saturating_add(from);
        let to = self.start.saturating_add(to);
        (from, to.max(from.saturating_add(1)))
    }

    /// So many times `every`, and so many halves of the length.
    fn multiple(&self, count: u64, halves: i128) -> i64 {
        self.every.times(count, halves, self.length)
    }

    /// The events of window `n` are after this time, and up to its end.
    pub(super) fn after(&self, n: u64) -> i64 {
        self.bounds(n).0 - i64::from(n == 0)
    }

    /// How many windows it takes for what ends at `end`: at least one. Centred ones have their
    /// middles up to it, and one more where something would be left behind the last.
    #[must_use]
    pub fn count(&self, end: Micros) -> u64 {
        let end = end.0 as i64;
        // Near it, and then exactly: bounds are rounded.
        let near = self.every.within(end.saturating_sub(self.start));
        let mut count = near.max(2) - 1;
        match self.alignment {
            Alignment::Causal => {
                while count > 1 && self.bounds(count - 2).1 >= end {
                    count -= 1;
                }
                while self.bounds(count - 1).1 < end {
                    count += 1;
                }
            }
            Alignment::Centred => {
                let middle = |n: u64| self.start.saturating_add(self.multiple(n, 0));
                while count > 1 && middle(count - 1) > end {
                    count -= 1;
                }
                // The largest time stands for all that are beyond it.
                while middle(count) <= end.min(i64::MAX - 1) {
                    count += 1;
                }
                // What lies behind the last of them is in one whose middle is beyond the end.
                if self.bounds(count - 1).1 < end && self.after(count) < end {
                    count += 1;
                }
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Windows as long as their distance leave nothing out and take nothing twice.
        #[test]
        fn tiles_meet(length in 1e-5f64..3.0, n in 0u64..100_000) {
            let windows = Windows::new(length, length, Alignment::Causal).unwrap();
            prop_assert_eq!(windows.bounds(n).1, windows.bounds(n + 1).0);
            prop_assert_eq!(windows.bounds(0).0, 0);
        }

        /// The last window reaches the end, and the one before does not.
        #[test]
        fn as_many_as_it_takes(length in 1e-4f64..1.0, every in 1e-4f64..1.0, end in 0u64..5_000_000) {
            let causal = Windows::new(length, every, Alignment::Causal).unwrap();
            let count = causal.count(Micros(end));
            prop_assert!(causal.bounds(count - 1).1 >= end as i64);
            prop_assert!(count == 1 || causal.bounds(count - 2).1 < end as i64);
            let centred = Windows::new(length, every, Alignment::Centred).unwrap();
            let count = centred.count(Micros(end));
            let middle = |n: u64| (n as f64 * every * 1e6).round();
            prop_assert!(middle(count) > end as f64);
            let (last, next) = (centred.bounds(count - 1), centred.bounds(count));
            prop_assert!(last.1 >= end as i64 || next.0 >= end as i64);
            prop_assert!(
                count == 1
                    || middle(count - 1) <= end as f64
                    || (count == 2 || middle(count - 2) <= end as f64)
                        && centred.bounds(count - 2).1 < end as i64
                        && last.0 < end as i64
            );
        }
    }

    #[test]
    fn the_largest_time_has_an_end() {
        for alignment in [Alignment::Causal, Alignment::Centred] {
            let windows = Windows::new(0.05, 0.05, alignment).unwrap();
            let last = Micros(i64::MAX as u64);
            let windows = windows.reaching(Micros(last.0 - 5_000_000));
            assert!((95..=105).contains(&windows.count(last)), "{alignment:?}");
        }
    }

    /// However far from 0, windows lie where they would at 0.
    #[test]
    fn late_windows_are_exact() {
        // A multiple of each distance.
        let far = (1_u64 << 60) / 300_000 * 300_000;
        for (length, every, skipped) in [
            (0.05, 0.05, far / 50_000),
            (0.1, 0.03, far / 30_000),
            (1.0 / 30.0, 1.0 / 30.0, far / 100_000 * 3),
        ] {
            for alignment in [Alignment::Causal, Alignment::Centred] {
                let windows = Windows::new(length, every, alignment).unwrap();
                for first in [far, far + 7] {
                    assert_eq!(windows.reaching(Micros(first)).start(), Micros(far));
                }
                for n in 0..100 {
                    let (from, to) = windows.bounds(n);
                    let shifted = (from + far as i64, to + far as i64);
                    assert_eq!(windows.reaching(Micros(far)).bounds(n), shifted);
                    // But at 0 a half is rounded to the other side.
                    if from >= 0 {
                        assert_eq!(windows.bounds(skipped + n), shifted);
                    }
                }
                let reaching = windows.reaching(Micros(far));
                let end = far + 999_999;
                assert_eq!(reaching.count(Micros(end)), windows.count(Micros(999_999)));
            }
        }
    }

    #[test]
    fn windows_of_frames() {
        // Five frames back from each frame at 30 frames/s.
        let windows = Windows::new(5.0 / 30.0, 1.0 / 30.0, Alignment::Causal).unwrap();
        assert_eq!(windows.bounds(0), (-133_333, 33_333));
        assert_eq!(windows.bounds(5), (33_333, 200_000));
        let windows = Windows::new(0.1, 0.1, Alignment::Centred)
            .unwrap()
            .from(Micros(1_000_000));
        assert_eq!(windows.bounds(0), (950_000, 1_050_000));
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Windows::new(wrong, 1.0, Alignment::Causal).is_err());
            assert!(Windows::new(1.0, wrong, Alignment::Causal).is_err());
        }
    }
}
