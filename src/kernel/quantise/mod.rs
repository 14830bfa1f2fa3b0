//! Quantisers: a kernel in few values, and the scale that brings it back.
//!
//! A kernel `w` becomes `s · l`: levels `l` that shifts, additions and halvings can make, and one
//! scale `s`. Comparing `s l * u` with a threshold `θ` is comparing `l * u` with `θ / s`, so
//! the scale costs nothing on a chip.
//!
//! [`ENTRIES`] is the list of quantisers; `docs/guides/from-kernel-to-chip.md` shows it.
//!
//! With [`Sum::Zero`] or [`Sum::Kept`] the levels are the nearest, at their scale, among those
//! whose sum is what was asked; for `ternary` and a sum of 0 the scale is the best as well, and
//! for `csd-D` the levels are only near: one weight after the other is moved where it hurts
//! least.

mod digits;
mod fixed;
mod levels;
mod list;
mod response;
mod total;

pub use list::{Chosen, ENTRIES, Entry, Parameters, Quantiser, QuantiserNameError, known};
pub use response::Change;

use super::{Kernel, KernelError};
use crate::{elementary, plane::Plane};

/// Bits of the levels of `csd-D`, without their sign.
pub const FINEST: u32 = 8;

/// To which multiple a weight is brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rounding {
    /// The nearest, halves to even.
    #[default]
    Nearest,
    /// The next below.
    Floor,
    /// One of the two next, each with the chance that makes the mean right.
    Stochastic,
}

/// What the sum of the quantised kernel must be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sum {
    /// Whatever comes.
    #[default]
    Free,
    /// 0: uniform light gives nothing.
    Zero,
    /// As near to the sum of the kernel as the levels allow.
    Kept,
}

/// A kernel in few values.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantised {
    /// What a chip computes with.
    pub levels: Kernel,
    /// What they are to be multiplied by; above 0. Divide thresholds by it instead.
    pub scale: f64,
}

/// A kernel that cannot be quantised as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum QuantiseError {
    /// Weights too small or too large to compute with.
    #[error(transparent)]
    #[diagnostic(help("multiply the kernel by a number, and the threshold with it"))]
    Weights(#[from] KernelError),
    /// More work than is allowed.
    #[error("{weights} weights in {quantiser} take {needed:.1e} {what}, more than {most:.1e}")]
    #[diagnostic(help(
        "cut the kernel where its weights are small, take a quantiser of fewer levels or digits, or leave the sum free"
    ))]
    Work {
        /// Which quantiser.
        quantiser: Quantiser,
        /// How many weights there are.
        weights: usize,
        /// How much it would be.
        needed: f64,
        /// How much it may be.
        most: f64,
        /// In what.
        what: &'static str,
    },
    /// No weight but 0.
    #[error("all weights are 0")]
    #[diagnostic(help("give a kernel that sees something"))]
    Nothing,
    /// A sum that these levels cannot have.
    #[error("no choice of levels of {quantiser} sums to {sum} over {weights} weights")]
    #[diagnostic(help(
        "leave the sum free, or take a quantiser with more levels, such as ternary"
    ))]
    Sum {
        /// Which quantiser.
        quantiser: Quantiser,
        /// In levels.
        sum: f64,
        /// How many weights there are.
        weights: usize,
    },
    /// A sum over levels that have no common step.
    #[error("the two scales of ternary-split leave the sum as it comes")]
    #[diagnostic(help("take `ternary`, which can keep the sum"))]
    SplitSum,
    /// Everything became 0.
    #[error("every weight becomes 0 in {quantiser}; the largest is {largest}")]
    #[diagnostic(help("take more bits after the point, or multiply the kernel"))]
    Vanished {
        /// Which quantiser.
        quantiser: Quantiser,
        /// The largest weight's magnitude.
        largest: f64,
    },
}

impl Quantiser {
    /// The kernel in these levels; `seed` is that of stochastic rounding.
    ///
    /// # Errors
    /// When the kernel is all 0 or becomes so, or the levels cannot have the sum.
    pub fn quantise(
        self,
        kernel: &Kernel,
        sum: Sum,
        seed: u64,
    ) -> Result<Quantised, QuantiseError> {
        kernel.workable()?;
        let weights: Vec<f64> = kernel.weights().iter().copied().collect();
        let largest = weights.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
        if largest == 0.0 {
            return Err(QuantiseError::Nothing);
        }
        // What cancels in the kernel must cancel in its levels.
        let magnitude: f64 = weights.iter().map(|w| w.abs()).sum();
        let cancels = kernel.sum().abs() < 1e-12 * magnitude;
        let sum = if sum == Sum::Kept && cancels {
            Sum::Zero
        } else {
            sum
        };
        let (levels, scale) = (self.entry.quantise)(self, &weights, sum, seed)?;
        if levels.iter().all(|level| *level == 0.0) {
            return Err(QuantiseError::Vanished {
                quantiser: self,
                largest,
            });
        }
        let (height, width) = kernel.weights().dim();
        let levels = Plane::from_shape_fn((height, width), |(y, x)| levels[y * width + x]);
        Ok(Quantised {
            levels: Kernel { weights: levels },
            scale,
        })
    }
}

impl Quantised {
    /// The same kernel in levels of at most 1, by a power of two: where the scale is free
    /// anyway, an array then halves on the way instead of losing the bits of its input first.
    #[must_use]
    pub fn within_one(mut self) -> Self {
        let largest = self
            .levels
            .weights
            .iter()
            .fold(0.0, |most: f64, l| most.max(l.abs()));
        if largest > 0.0 {
            let power = 2f64.powi(elementary::log2(largest).ceil() as i32);
            self.levels.weights /= power;
            self.scale *= power;
        }
        self
    }

    /// The kernel that the levels and the scale stand for.
    #[must_use]
    pub fn kernel(&self) -> Kernel {
        Kernel {
            weights: &self.levels.weights * self.scale,
        }
    }

    /// `|w - s l| / |w|`, root mean square: 0 is the kernel itself, 1 is nothing.
    #[must_use]
    pub fn relative_error(&self, kernel: &Kernel) -> f64 {
        let weights = kernel.weights();
        let square = |plane: &Plane<f64>| plane.iter().map(|w| w * w).sum::<f64>();
        (square(&(self.kernel().weights() - weights)) / square(weights)).sqrt()
    }
}

/// Refuses work that would take too long or too much room.
fn affordable(
    quantiser: Quantiser,
    weights: usize,
    needed: f64,
    most: u64,
    what: &'static str,
) -> Result<(), QuantiseError> {
    let most = most as f64;
    if needed <= most {
        return Ok(());
    }
    Err(QuantiseError::Work {
        quantiser,
        weights,
        needed,
        most,
        what,
    })
}

/// The scale that brings levels nearest to the weights.
fn best_scale(weights: &[f64], levels: &[f64]) -> f64 {
    let both: f64 = weights.iter().zip(levels).map(|(w, l)| w * l).sum();
    let own: f64 = levels.iter().map(|l| l * l).sum();
    both / own
}

#[cfg(test)]
mod tests;
