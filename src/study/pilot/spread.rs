//! Seconds that were measured a few times: the median, and how far the others are from it.
//!
//! A run is not repeated for it: every fifth of its frames is a measurement of its own, and all five
//! lie over the whole run. Of five the least and the most are left out, since one of them may have
//! waited for another process.

use serde::Serialize;

/// So many measurements are made of a run.
const PARTS: usize = 5;

/// Seconds of the frames of a run, in parts that each lie over all of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parts {
    seconds: [f64; PARTS],
    frames: [u64; PARTS],
    next: usize,
}

impl Parts {
    /// One more frame.
    pub fn add(&mut self, seconds: f64) {
        let part = self.next % PARTS;
        self.seconds[part] += seconds;
        self.frames[part] += 1;
        self.next += 1;
    }

    /// Seconds of a frame; 0 where there was none.
    pub fn per_frame(&self) -> Spread {
        let parts = self.seconds.iter().zip(self.frames);
        let each = parts.filter(|(_, frames)| *frames > 0);
        Spread::of(
            each.map(|(seconds, frames)| seconds / frames as f64)
                .collect(),
        )
    }
}

/// Seconds of which there is more than one measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The least of the measurements in the middle: of five and more, all but one at each end.
    pub least: f64,
    /// The most of them.
    pub most: f64,
}

/// Of so many measurements the least and the most are left out.
const TRIMMED: usize = 5;

impl Spread {
    /// Of measurements; 0 of none.
    #[must_use]
    pub fn of(mut measured: Vec<f64>) -> Self {
        measured.sort_unstable_by(f64::total_cmp);
        let last = measured.len().saturating_sub(1);
        let end = usize::from(measured.len() >= TRIMMED);
        let [Some(least), Some(most)] = [measured.get(end), measured.get(last - end)] else {
            return Self::default();
        };
        let middle = [last / 2, last - last / 2].map(|at| measured.get(at).copied());
        let [Some(low), Some(high)] = middle else {
            return Self::default();
        };
        Self {
            median: f64::midpoint(low, high),
            least: *least,
            most: *most,
        }
    }

    /// So many times as long, and so many seconds more.
    #[must_use]
    pub fn scaled(self, times: f64, more: f64) -> Self {
        let scaled = |seconds: f64| seconds.mul_add(times, more);
        Self {
            median: scaled(self.median),
            least: scaled(self.least),
            most: scaled(self.most),
        }
    }

    /// Half of what the least and the most are apart, as a part of the median; 0 of no time.
    #[must_use]
    pub fn part(self) -> f64 {
        if self.median > 0.0 {
            (self.most - self.least) / (2.0 * self.median)
        } else {
            0.0
        }
    }

    /// Whether one is not told from the other: what was measured of both overlaps.
    #[must_use]
    pub fn overlaps(self, other: Self) -> bool {
        self.least <= other.most && other.least <= self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_start_is_in_the_spread_and_not_in_the_median() {
        let mut parts = Parts::default();
        parts.add(8.0);
        parts.add(8.0);
        for _ in 0..8 {
            parts.add(2.0);
        }
        let spread = parts.per_frame();
        assert_eq!([spread.least, spread.median, spread.most], [2.0, 2.0, 5.0]);
        assert_eq!(spread.part(), 0.75);
        let scaled = spread.scaled(10.0, 1.0);
        assert_eq!([scaled.median, scaled.most], [21.0, 51.0]);
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_ones() {
        assert_eq!(Spread::of(vec![4.0, 1.0, 2.0, 9.0]).median, 3.0);
        assert_eq!(Spread::of(Vec::new()), Spread::default());
        let [a, b] = [[1.0, 2.0], [2.5, 3.0]].map(|of| Spread::of(of.to_vec()));
        assert!(!a.overlaps(b) && a.overlaps(Spread::of(vec![2.0, 2.5])));
    }
}
