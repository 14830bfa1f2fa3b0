//! A resistive grid of equal parts: its space constants, gain and modes.

use super::error::MeshError;
use crate::elementary;

/// Space constants of a sheet of equal parts, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sheet {
    lambda_y: f64,
    lambda_x: f64,
}

/// The largest space constant, in pixels: its square must stay finite.
pub const MOST_LAMBDA: f64 = 1e150;

/// The largest magnitude of a signal: sums over a grid must stay finite.
pub const MOST_SIGNAL: f64 = 1e290;

impl Sheet {
    /// A sheet with the same resistors both ways; `lambda` in pixels.
    ///
    /// # Errors
    /// When `lambda` is not a number from 0 to [`MOST_LAMBDA`].
    pub fn new(lambda: f64) -> Result<Self, MeshError> {
        Self::anisotropic(lambda, lambda)
    }

    /// A sheet whose resistors down and across differ: `lambda_y² = 1 / (Ry g)`,
    /// `lambda_x² = 1 / (Rx g)`.
    ///
    /// # Errors
    /// As [`Sheet::new`].
    pub fn anisotropic(lambda_y: f64, lambda_x: f64) -> Result<Self, MeshError> {
        for value in [lambda_y, lambda_x] {
            if !(0.0..=MOST_LAMBDA).contains(&value) {
                return Err(MeshError::Lambda {
                    value,
                    most: MOST_LAMBDA,
                });
            }
        }
        // -0.0 becomes 0.0.
        Ok(Self {
            lambda_y: lambda_y.abs(),
            lambda_x: lambda_x.abs(),
        })
    }

    /// The space constants, down and across, in pixels.
    #[must_use]
    pub const fn lambdas(self) -> (f64, f64) {
        (self.lambda_y, self.lambda_x)
    }

    /// The gain of the surround for a grating of `fy` and `fx` cycles a pixel: 1 for uniform light,
    /// down to `1 / (1 + 8 λ²)` for a checkerboard.
    #[must_use]
    pub fn gain(self, fy: f64, fx: f64) -> f64 {
        let loss = |lambda: f64, f: f64| {
            lambda * lambda * 4.0 * elementary::sin(std::f64::consts::PI * f).powi(2)
        };
        1.0 / (1.0 + loss(self.lambda_y, fy) + loss(self.lambda_x, fx))
    }
}

/// The eigenvalues `4 sin²(π k / 2n)` of a line of `n` nodes with open ends.
pub(super) fn eigenvalues(n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |k| {
        4.0 * elementary::sin(std::f64::consts::FRAC_PI_2 * k as f64 / n as f64).powi(2)
    })
}
