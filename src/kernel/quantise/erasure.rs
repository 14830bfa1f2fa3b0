//! What few values take from a kernel that an error in per cent does not tell: a surround that
//! is gone, and a symmetry that is gone.

use std::fmt;

use super::{super::Kernel, quantised::Quantised};
use crate::plane::Plane;

/// Something that the levels of a kernel have no more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Erasure {
    /// Only the centre is left: no receptive field, but one pixel.
    Surround {
        /// Weights off the centre, which are all 0 now.
        weights: usize,
        /// What they carried of the sum of magnitudes.
        share: f64,
    },
    /// No weight of one sign is left.
    Sign {
        /// Whether it is the negative ones that are gone.
        negative: bool,
        /// How many there were.
        weights: usize,
        /// What they carried of the sum of magnitudes.
        share: f64,
    },
    /// The kernel is the same mirrored or turned, its levels are not.
    Lopsided {
        /// What of the sum of magnitudes of the levels has no partner.
        share: f64,
    },
    /// Weights lie beyond the levels, whose scale is not free.
    Clipped {
        /// How many do.
        weights: usize,
        /// What they lose of the sum of magnitudes.
        share: f64,
    },
}

/// What may go without a word, as a part of the sum of magnitudes.
const LEAST: f64 = 0.1;

/// Symmetries hold to this part of the sum of magnitudes: weights were rounded when written.
const SAME: f64 = 1e-9;

impl Quantised {
    /// What of the kernel is erased.
    #[must_use]
    pub fn erasures(&self, kernel: &Kernel) -> Vec<Erasure> {
        let (weights, levels) = (kernel.weights(), self.levels.weights());
        let lost = surround(weights, levels).or_else(|| sign(weights, levels));
        let share = lopsided(weights, levels);
        let lopsided = (share > LEAST).then_some(Erasure::Lopsided { share });
        let clipped = self.clipped(weights);
        lost.into_iter().chain(lopsided).chain(clipped).collect()
    }

    /// Weights beyond the levels of fixed point, whose scale is 1: of others the scale makes room.
    fn clipped(&self, weights: &Plane<f64>) -> Option<Erasure> {
        let most = self.levels.largest();
        let beyond = weights.iter().zip(self.levels.weights());
        let beyond: Vec<f64> = { beyond.filter(|(w, l)| w.abs() > most && *w * *l > 0.0) }
            .map(|(w, l)| w.abs() - l.abs())
            .collect();
        let share = beyond.iter().sum::<f64>() / magnitude(weights);
        (self.scale == 1.0 && share >= LEAST).then_some(Erasure::Clipped {
            weights: beyond.len(),
            share,
        })
    }
}

fn magnitude(plane: &Plane<f64>) -> f64 {
    plane.iter().map(|w| w.abs()).sum()
}

/// How many weights at these places are not 0, and what they carry; none where they carry little,
/// or a level there is left.
fn gone(
    weights: &Plane<f64>,
    levels: &Plane<f64>,
    counts: impl Fn((usize, usize), f64) -> bool,
) -> Option<(usize, f64)> {
    let (mut number, mut carried) = (0, 0.0);
    for ((at, w), level) in weights.indexed_iter().zip(levels) {
        if counts(at, *w) && *w != 0.0 {
            number += 1;
            carried += w.abs();
        }
        if counts(at, *level) && *level != 0.0 {
            return None;
        }
    }
    let share = carried / magnitude(weights);
    (share >= LEAST).then_some((number, share))
}

fn surround(weights: &Plane<f64>, levels: &Plane<f64>) -> Option<Erasure> {
    let (height, width) = weights.dim();
    let off_centre = |at: (usize, usize), _: f64| at != (height / 2, width / 2);
    let (weights, share) = gone(weights, levels, off_centre)?;
    Some(Erasure::Surround { weights, share })
}

fn sign(weights: &Plane<f64>, levels: &Plane<f64>) -> Option<Erasure> {
    [true, false].into_iter().find_map(|negative| {
        let own = |_: (usize, usize), w: f64| if negative { w < 0.0 } else { w > 0.0 };
        let (weights, share) = gone(weights, levels, own)?;
        Some(Erasure::Sign {
            negative,
            weights,
            share,
        })
    })
}

/// The largest share of the levels without a partner, over all symmetries of the kernel: the
/// ways to mirror and turn it, the sign kept or changed.
fn lopsided(weights: &Plane<f64>, levels: &Plane<f64>) -> f64 {
    let (height, width) = weights.dim();
    let mut worst = 0.0_f64;
    for way in 1..8 {
        let [down, across, turned] = [1, 2, 4].map(|bit| way & bit != 0);
        if turned && height != width {
            continue;
        }
        for sign in [1.0, -1.0] {
            let apart = |plane: &Plane<f64>| {
                let partner = |(y, x): (usize, usize)| {
                    let y = if down { height - 1 - y } else { y };
                    let x = if across { width - 1 - x } else { x };
                    plane[if turned { (x, y) } else { (y, x) }]
                };
                let all = plane.indexed_iter();
                let apart: f64 = all.map(|(at, w)| (w - sign * partner(at)).abs()).sum();
                // What has no partner is missing there, too.
                apart / (2.0 * magnitude(plane))
            };
            if apart(weights) <= SAME {
                worst = worst.max(apart(levels));
            }
        }
    }
    worst
}

impl fmt::Display for Erasure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Surround { weights, share } => write!(
                f,
                "the surround is lost: {} off the centre, {:.0} % of |w|, became 0, and a plain DVS is left",
                crate::unit::counted(*weights, "weight"),
                100.0 * share
            ),
            Self::Sign {
                negative,
                weights,
                share,
            } => write!(
                f,
                "the surround is lost: {}, {:.0} % of |w|, became 0",
                crate::unit::counted(
                    *weights,
                    if *negative {
                        "negative weight"
                    } else {
                        "positive weight"
                    }
                ),
                100.0 * share
            ),
            Self::Lopsided { share } => write!(
                f,
                "lopsided: the kernel is symmetric, and {:.0} % of its levels have no partner",
                100.0 * share
            ),
            Self::Clipped { weights, share } => write!(
                f,
                "clipped: {} beyond the largest level, and {:.0} % of |w| is lost",
                crate::unit::counted(*weights, "weight"),
                100.0 * share
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::quantise::{Quantiser, Sum};

    fn erased(name: &str, to: &str, sum: Sum) -> Vec<Erasure> {
        let kernel = Kernel::builtin(name).unwrap();
        let to: Quantiser = to.parse().unwrap();
        to.quantise(&kernel, sum, 0).unwrap().erasures(&kernel)
    }

    #[test]
    fn a_surround_that_is_gone_is_told_of() {
        let gone = erased("csdvs-3", "ternary", Sum::Free);
        let [Erasure::Surround { weights: 8, share }] = gone[..] else {
            panic!("{gone:?}");
        };
        assert!((share - 0.5).abs() < 1e-12);
        assert!(
            gone[0]
                .to_string()
                .contains("8 weights off the centre, 50 %")
        );
    }

    #[test]
    fn weights_beyond_fixed_point_are_told_of() {
        let rows = [
            vec![1.0, 2.0, 0.0],
            vec![0.0, 3.0, -1.0],
            vec![0.0, 0.0, -4.0],
        ];
        let kernel = Kernel::from_rows(&rows).unwrap();
        let found = |to: &str| {
            let to: Quantiser = to.parse().unwrap();
            to.quantise(&kernel, Sum::Free, 0)
                .unwrap()
                .erasures(&kernel)
        };
        let gone = found("q2.3");
        let [Erasure::Clipped { weights: 2, share }] = gone[..] else {
            panic!("{gone:?}");
        };
        // 3 becomes 1.875, and -4 becomes -2.
        assert!((share - 3.125 / 11.0).abs() < 1e-12);
        assert!(found("q4.3").is_empty() && found("int-4").is_empty());
    }

    #[test]
    fn one_weight_in_a_corner_is_lopsided() {
        for name in ["csdvs-3", "csdvs-5"] {
            let gone = erased(name, "ternary", Sum::Zero);
            let [Erasure::Lopsided { share }] = gone[..] else {
                panic!("{name}: {gone:?}");
            };
            assert!((share - 0.5).abs() < 1e-12, "{name}: {share}");
        }
    }

    #[test]
    fn a_kernel_without_its_negative_half_is_told_of() {
        let kernel = Kernel::from_rows(&[vec![-0.2, -0.3, 1.0, 1.0, 1.0]]).unwrap();
        let levels = Quantiser::TERNARY.quantise(&kernel, Sum::Free, 0).unwrap();
        let gone = levels.erasures(&kernel);
        let [
            Erasure::Sign {
                negative: true,
                weights: 2,
                share,
            },
        ] = gone[..]
        else {
            panic!("{gone:?}");
        };
        assert!((share - 0.5 / 3.5).abs() < 1e-12);
    }

    #[test]
    fn kernels_that_keep_their_shape_say_nothing() {
        for (name, to) in [
            ("rgc-5x5", "ternary"),
            ("rgc-5x5", "int-5"),
            ("rgc-5x5", "po2-4"),
            ("csdvs-3", "po2-4"),
            ("csdvs-5", "int-7"),
            ("laplacian", "int-4"),
            ("sobel-x", "ternary"),
            ("dvs", "ternary"),
        ] {
            let gone = erased(name, to, Sum::Kept);
            assert!(gone.is_empty(), "{name} as {to}: {gone:?}");
        }
        // An edge is the same mirrored with its signs changed: one side alone is half of it.
        let kernel = Kernel::builtin("sobel-x").unwrap();
        let mut half = Quantiser::TERNARY.quantise(&kernel, Sum::Zero, 0).unwrap();
        half.levels = Kernel::from_rows(&[
            vec![-1.0, 0.0, 1.0],
            vec![-1.0, 0.0, 0.0],
            vec![-1.0, 0.0, 1.0],
        ])
        .unwrap();
        let [Erasure::Lopsided { .. }] = half.erasures(&kernel)[..] else {
            panic!("{:?}", half.erasures(&kernel));
        };
    }
}
