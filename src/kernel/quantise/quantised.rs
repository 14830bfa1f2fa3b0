//! A quantised kernel.

use super::{
    super::Kernel,
    entry::{Quantiser, Sum},
    error::QuantiseError,
};
use crate::{elementary, plane::Plane};

/// A kernel in few values.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantised {
    /// What a chip computes with.
    pub levels: Kernel,
    /// What they are to be multiplied by; above 0. Divide thresholds by it instead.
    pub scale: f64,
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
        let largest = kernel.largest();
        if largest == 0.0 {
            return Err(QuantiseError::Nothing);
        }
        // What cancels in the kernel must cancel in its levels.
        let sum = if sum == Sum::Kept && kernel.cancels() {
            Sum::Zero
        } else {
            sum
        };
        let (height, width) = kernel.weights().dim();
        let chosen = |sum| -> Result<Quantised, QuantiseError> {
            let (levels, scale) = (self.entry.quantise)(self, &weights, sum, seed)?;
            let levels = Plane::from_shape_fn((height, width), |(y, x)| levels[y * width + x]);
            let levels = Kernel { weights: levels };
            Ok(Quantised { levels, scale })
        };
        let mut found = chosen(sum)?;
        if sum == Sum::Kept && found.levels.sum() == 0.0 {
            // Levels without a sum need not stay at the scale at which theirs was asked for.
            let error = found.relative_error(kernel);
            let nearer = |it: &Quantised| {
                kernel.sum().abs() <= it.scale / 2.0 && it.relative_error(kernel) < error
            };
            if let Some(other) = chosen(Sum::Zero).ok().filter(nearer) {
                found = other;
            }
        }
        if found.levels.is_zero() {
            return Err(QuantiseError::Vanished {
                quantiser: self,
                largest,
            });
        }
        Ok(found)
    }
}

impl Quantised {
    /// The same kernel in levels of at most 1, by a power of two: where the scale is free
    /// anyway, an array then halves on the way instead of losing the bits of its input first.
    #[must_use]
    pub fn within_one(mut self) -> Self {
        let largest = self.levels.largest();
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
