//! A share that some chips on some tiles give, and between what it lies.

use crate::{elementary, study::spread::Spread};

/// How many standard deviations of a normal distribution 10 and 90 % are from its middle.
const SIGMAS_OF_80_PERCENT: f64 = 1.281_551_565_545;

/// What was found on each chip, and what leaving out a tile changes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Estimate {
    /// For each chip, on all tiles.
    chips: Vec<f64>,
    /// The mean of the chips without each of the tiles; nothing where the whole sensor was seen.
    without: Vec<f64>,
}

impl Estimate {
    /// Of what each chip says: on all tiles, then without each of them.
    pub(super) fn new(each: &[Vec<f64>]) -> Self {
        let tiles = each.first().map_or(0, |own| own.len().saturating_sub(1));
        let of = |i: usize| each.iter().filter_map(move |own| own.get(i).copied());
        Self {
            chips: of(0).collect(),
            without: (1..=tiles)
                .map(|i| mean(&of(i).collect::<Vec<_>>()))
                .collect(),
        }
    }

    /// The same on all chips, of the whole sensor.
    pub(super) fn whole(value: f64) -> Self {
        Self {
            chips: vec![value],
            without: Vec::new(),
        }
    }

    /// Less what another takes, which is the same on all chips.
    pub(super) fn less(mut self, other: f64) -> Self {
        for value in self.chips.iter_mut().chain(&mut self.without) {
            *value -= other;
        }
        self
    }

    /// The mean of the chips.
    pub(super) fn mean(&self) -> f64 {
        mean(&self.chips)
    }

    /// Where 80 % of chips and of choices of tiles lie: the chips' own 10 and 90 %, and the jackknife
    /// of the tiles (Tukey 1958: the variance is `(n - 1) / n` of the squares of what leaving out one
    /// of n changes), as if the two were independent. Tiles are of strata, which spreads less than the
    /// jackknife says.
    pub(super) fn range(&self) -> [f64; 2] {
        let middle = self.mean();
        let n = self.without.len() as f64;
        let centre = mean(&self.without);
        let squares: f64 = { self.without.iter() }
            .map(|value| (value - centre) * (value - centre))
            .sum();
        let variance = if n > 1.0 {
            (n - 1.0) / n * squares
        } else {
            0.0
        };
        let tiles = SIGMAS_OF_80_PERCENT * variance.sqrt();
        let chips = Spread::new(&self.chips);
        let [low, high] = chips.map_or([middle; 2], |chips| [chips.p10, chips.p90]);
        [
            middle - elementary::hypot(middle - low, tiles),
            middle + elementary::hypot(high - middle, tiles),
        ]
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_of_chips_and_of_tiles() {
        // Chips alone: nine steps between ten values.
        let chips: Vec<Vec<f64>> = (0..10).map(|i| vec![f64::from(i)]).collect();
        let [low, high] = Estimate::new(&chips).range();
        assert!((low - 0.9).abs() < 1e-12 && (high - 8.1).abs() < 1e-12);
        // The jackknife of a mean is its standard error: of 1, 2, 3, 6 it is 1.0801.
        let without = [11.0, 10.0, 9.0, 6.0].map(|sum| sum / 3.0);
        let tiles = Estimate::new(&[[&[3.0], &without[..]].concat()]);
        let half = SIGMAS_OF_80_PERCENT * (14.0_f64 / 12.0).sqrt();
        let [low, high] = tiles.range();
        assert!((3.0 - low - half).abs() < 1e-12 && (high - 3.0 - half).abs() < 1e-12);
        assert_eq!(Estimate::whole(0.25).less(0.125).range(), [0.125; 2]);
    }
}
