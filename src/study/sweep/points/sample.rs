//! Points drawn from the grid: at random, or by Sobol's sequence.
//!
//! Every axis is a dimension, the choice of the side the first. A number in [0, 1) chooses the
//! value of a list by equal shares, and a place on a range. Sobol's points fill all dimensions
//! evenly: of the first 2^k, each of 2^k equal parts of any axis has exactly one.

use super::{
    grid::{self, Axes, MOST_POINTS},
    point::Point,
};
use crate::rng::{GOLDEN, Hash};

/// How points are searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// The share of the candidates that are computed on the whole scene.
    pub finish: f64,
    /// The column that error is weighed against.
    pub cost: &'static str,
    /// Draws the parts of the scene, and the candidates where there are too many.
    pub seed: u64,
}

/// How points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Independently.
    Random,
    /// Sobol's sequence, scrambled as Owen does, by Burley's hash (JCGT 9(4), 2020).
    Sobol,
    /// The grid, or Sobol's points where it has more or has no end; some of them are computed.
    Search,
}

impl Method {
    /// The most points.
    #[must_use]
    pub const fn most(self) -> u64 {
        match self {
            Self::Random => MOST_POINTS,
            // As far as the sequence goes.
            Self::Sobol | Self::Search => 1 << 16,
        }
    }
}

/// Points in place of the whole grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// How points are chosen.
    pub method: Method,
    /// How many; the same one may come twice.
    pub points: u64,
    /// Seed of the choice.
    pub seed: u64,
    /// How a search goes on.
    pub search: Option<Search>,
}

impl Sample {
    /// The number in [0, 1) of a point in a dimension.
    #[must_use]
    pub fn part(&self, point: u64, dimension: usize) -> f64 {
        match self.method {
            Method::Random => {
                let spread = |n: u64| GOLDEN.wrapping_mul(n + 1);
                let key = Hash::raw(self.seed).with_mixed(spread(dimension as u64));
                key.with_mixed(spread(point)).uniform()
            }
            Method::Sobol | Method::Search => {
                let seed = Hash::new(self.seed).bits() as u32;
                f64::from(sobol_burley::sample(point as u32, dimension as u32, seed))
            }
        }
    }

    /// The points, in the order in which they are drawn.
    #[must_use]
    pub fn points(&self, sides: &[Axes]) -> Vec<Point> {
        let ranges = { sides.iter() }
            .flat_map(|axes| &axes.axes)
            .any(|axis| axis.count().is_none());
        if self.method == Method::Search
            && !ranges
            && let Ok(grid) = grid::points(sides)
            && grid.len() as u64 <= self.points
        {
            return grid;
        }
        let draw = |point: u64| {
            let side = (self.part(point, 0) * sides.len() as f64) as usize;
            let axes = sides.get(side.min(sides.len().checked_sub(1)?))?;
            let mut values = Vec::new();
            for (axis, dimension) in axes.axes.iter().zip(1..) {
                let value = axis.draw(self.part(point, dimension))?;
                values.push((axis.key.name, value));
            }
            Some(Point::new(axes.side, values))
        };
        (0..self.points).filter_map(draw).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What makes the sequence Sobol's: of the first 2^k points each of 2^k equal intervals of
    /// each dimension has one, and of the first two dimensions each box of equal area.
    #[test]
    fn sobol_points_fill_every_interval_once() {
        for seed in [0, 7] {
            let sample = Sample {
                method: Method::Sobol,
                points: 256,
                seed,
                search: None,
            };
            for dimension in 0..24 {
                let mut hits = [0; 256];
                for point in 0..256 {
                    hits[(sample.part(point, dimension) * 256.0) as usize] += 1;
                }
                assert_eq!(hits, [1; 256], "dimension {dimension}");
            }
            let mut boxes = [0; 256];
            for point in 0..256 {
                let [x, y] = [0, 1].map(|d| (sample.part(point, d) * 16.0) as usize);
                boxes[16 * y + x] += 1;
            }
            assert_eq!(boxes, [1; 256]);
        }
    }

    #[test]
    fn random_points_are_uniform_and_differ_by_seed_and_dimension() {
        let sample = |seed| Sample {
            method: Method::Random,
            points: 4096,
            seed,
            search: None,
        };
        for dimension in 0..4 {
            let mean: f64 = (0..4096).map(|i| sample(1).part(i, dimension)).sum::<f64>() / 4096.0;
            // Four standard errors of a uniform mean.
            assert!(
                (mean - 0.5).abs() < 4.0 / (12.0 * 4096.0_f64).sqrt(),
                "{mean}"
            );
        }
        assert_ne!(sample(1).part(0, 0), sample(2).part(0, 0));
        assert_ne!(sample(1).part(0, 0), sample(1).part(0, 1));
    }
}
