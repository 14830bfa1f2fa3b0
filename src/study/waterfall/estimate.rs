//! A share that some chips on some tiles give, and between what it lies.

use crate::elementary;

/// How many standard deviations of a normal distribution 10 and 90 % are from its middle.
const SIGMAS_OF_80_PERCENT: f64 = 1.281_551_565_545;

/// The same of Student's distribution, whose deviation is known from so many degrees of freedom:
/// closed forms for one and two, else the expansion of Fisher and Cornish 1960 (within 0.1 %).
fn student(freedom: usize) -> f64 {
    let z = SIGMAS_OF_80_PERCENT;
    match freedom {
        0 => f64::INFINITY,
        1 => 3.077_683_537_175,
        2 => 1.885_618_083_164,
        _ => {
            let (n, s) = (freedom as f64, z * z);
            let first = z * (s + 1.0) / 4.0;
            let second = z * ((5.0 * s + 16.0) * s + 3.0) / 96.0;
            let third = z * (((3.0 * s + 19.0) * s + 17.0) * s - 15.0) / 384.0;
            z + (first + (second + third / n) / n) / n
        }
    }
}

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

    /// Where a further chip and another choice of tiles lie with 80 %: the prediction interval of a
    /// normal distribution whose deviation is that of the chips (Student's, `t s sqrt(1 + 1 / n)`;
    /// the chips' own 10 and 90 % would hold half of the others where there are four), and the
    /// jackknife of the tiles (Tukey 1958: the variance is `(n - 1) / n` of the squares of what
    /// leaving out one of n changes), as if the two were independent. Tiles are of strata, which
    /// spreads less than the jackknife says. One chip says nothing of others.
    pub(super) fn range(&self) -> [f64; 2] {
        let middle = self.mean();
        let tiles = match self.without.len() as f64 {
            n if n > 1.0 => SIGMAS_OF_80_PERCENT * ((n - 1.0) / n * squares(&self.without)).sqrt(),
            _ => 0.0,
        };
        let chips = match self.chips.len() {
            0 | 1 => 0.0,
            n => {
                let (n, freedom) = (n as f64, n - 1);
                let variance = squares(&self.chips) / freedom as f64;
                student(freedom) * (variance * (1.0 + 1.0 / n)).sqrt()
            }
        };
        let half = elementary::hypot(chips, tiles);
        [middle - half, middle + half]
    }
}

/// The sum of the squares of what they differ from their mean.
fn squares(values: &[f64]) -> f64 {
    let centre = mean(values);
    let square = |value: &f64| (value - centre) * (value - centre);
    values.iter().map(square).sum()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Hash;

    #[test]
    fn a_range_is_of_chips_and_of_tiles() {
        // Chips alone: of 0 to 3 the deviation is 1.291, and 90 % of Student's with three degrees of
        // freedom lie below 1.6377.
        let chips: Vec<Vec<f64>> = (0..4).map(|i| vec![f64::from(i)]).collect();
        let [low, high] = Estimate::new(&chips).range();
        let half = 1.637_744 * (5.0_f64 / 3.0 * 1.25).sqrt();
        assert!((low - 1.5 + half).abs() < 3e-3 && (high - 1.5 - half).abs() < 3e-3);
        // The jackknife of a mean is its standard error: of 1, 2, 3, 6 it is 1.0801.
        let without = [11.0, 10.0, 9.0, 6.0].map(|sum| sum / 3.0);
        let tiles = Estimate::new(&[[&[3.0], &without[..]].concat()]);
        let half = SIGMAS_OF_80_PERCENT * (14.0_f64 / 12.0).sqrt();
        let [low, high] = tiles.range();
        assert!((3.0 - low - half).abs() < 1e-12 && (high - 3.0 - half).abs() < 1e-12);
        assert_eq!(Estimate::whole(0.25).less(0.125).range(), [0.125; 2]);
    }

    #[test]
    fn a_range_holds_four_of_five_further_chips() {
        for chips in [2, 3, 4, 8, 32] {
            let (mut held, all) = (0, 4000);
            for trial in 0..all {
                // A sum of twelve uniform numbers is nearly normal.
                let draw = |i: usize| {
                    let of = |j| Hash::new(trial).with(i as u64).with(j).uniform();
                    vec![(0..12).map(of).sum::<f64>()]
                };
                let each: Vec<_> = (0..chips).map(draw).collect();
                let [low, high] = Estimate::new(&each).range();
                held += u64::from((low..=high).contains(&draw(chips)[0]));
            }
            let share = held as f64 / all as f64;
            assert!((share - 0.8).abs() < 0.02, "{chips} chips: {share}");
        }
    }

    #[test]
    fn students_distribution_is_that_of_the_tables() {
        for (freedom, table) in [
            (1, 3.0777),
            (2, 1.8856),
            (3, 1.6377),
            (5, 1.4759),
            (31, 1.3095),
        ] {
            assert!((student(freedom) / table - 1.0).abs() < 1e-3, "{freedom}");
        }
    }
}
