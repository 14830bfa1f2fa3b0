//! Receptive fields: small planes of weights, as data.
//!
//! Kernels are **correlations**: `out(p) = sum over d of k(d) in(p + d)`, with row 0 of a
//! kernel to the north and column 0 to the west. Sides are odd, so that a kernel has a centre.
//! Built-in kernels are files in `kernels/`, each with where it came from.

mod file;
mod gaussian;
mod loss;
pub mod quantise;
mod zoo;

pub use file::{FEWER, FILE, KernelFileError, ROWS, SHAPES, wrong_number};
pub use gaussian::Gaussian;
pub use loss::{Loss, LossKind};

use ndarray::ArrayView1;

use crate::{
    limit::{KERNEL_SIDE, LEAST_WEIGHT, MOST_WEIGHT},
    plane::Plane,
};

/// A receptive field.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    weights: Plane<f64>,
}

/// Weights that do not make a kernel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum KernelError {
    /// No weights at all.
    #[error(
        "the kernel is empty; give an odd number of rows, each with the same odd number of weights"
    )]
    Empty,
    /// A side without a middle.
    #[error(
        "the kernel is {} by {}; both must be odd, so that it has a centre",
        crate::unit::counted(*height, "row"),
        crate::unit::counted(*width, "column")
    )]
    Even {
        /// Rows.
        height: usize,
        /// Columns.
        width: usize,
    },
    /// Rows of different lengths.
    #[error(
        "row {row} of the kernel has {}, row 0 has {want}; all rows must be of one length",
        crate::unit::counted(*got, "weight")
    )]
    Ragged {
        /// Which row.
        row: usize,
        /// Its length.
        got: usize,
        /// The length of row 0.
        want: usize,
    },
    /// A Gaussian without a width.
    #[error("the sigma of a Gaussian is {sigma}; give a finite number above 0, in pixels")]
    Sigma {
        /// Its standard deviation.
        sigma: f64,
    },
    /// A side that is too long.
    #[error(
        "the kernel is {} by {}; a side of a kernel is at most {KERNEL_SIDE}",
        crate::unit::counted(*height, "row"),
        crate::unit::counted(*width, "column")
    )]
    Size {
        /// Rows.
        height: usize,
        /// Columns.
        width: usize,
    },
    /// Weights that floats hold only in part.
    #[error(
        "the largest weight, {value:e} at row {row}, column {column}, is too small: a float below {:e} loses its digits",
        f64::MIN_POSITIVE
    )]
    Subnormal {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The weight.
        value: f64,
    },
    /// Weights whose sizes have no finite sum.
    #[error(
        "the sizes of the weights add up beyond the largest float, 1.8e308; the largest is {value:e} at row {row}, column {column}"
    )]
    Overflow {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The weight.
        value: f64,
    },
    /// Weights that cannot be squared and added up.
    #[error(
        "the largest weight, {value:e} at row {row}, column {column}, is too {}: it must lie from {LEAST_WEIGHT:e} to {MOST_WEIGHT:e} in size",
        if value.abs() < 1.0 { "small" } else { "large" }
    )]
    Unworkable {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The weight.
        value: f64,
    },
    /// NaN or infinity.
    #[error("the weight at row {row}, column {column} is {value}; weights must be finite")]
    NotFinite {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The weight.
        value: f64,
    },
}

impl Kernel {
    /// A kernel from a plane of weights, `[row, column]`, row 0 north.
    ///
    /// # Errors
    /// When a side is zero, even or too long, when a weight is not finite, or when the weights
    /// are too small or too large for floats to compute with.
    pub fn new(weights: Plane<f64>) -> Result<Self, KernelError> {
        let (height, width) = weights.dim();
        if height == 0 || width == 0 {
            return Err(KernelError::Empty);
        }
        if height % 2 == 0 || width % 2 == 0 {
            return Err(KernelError::Even { height, width });
        }
        if height.max(width) > KERNEL_SIDE {
            return Err(KernelError::Size { height, width });
        }
        if let Some(((row, column), &value)) = weights.indexed_iter().find(|(_, w)| !w.is_finite())
        {
            return Err(KernelError::NotFinite { row, column, value });
        }
        let kernel = Self { weights };
        let ((row, column), value) = kernel.at_largest();
        if value.is_subnormal() {
            return Err(KernelError::Subnormal { row, column, value });
        }
        let sizes = kernel.weights.iter().map(|w| w.abs());
        if sizes.sum::<f64>().is_infinite() {
            return Err(KernelError::Overflow { row, column, value });
        }
        Ok(kernel)
    }

    /// Where the weight that is largest in size stands, and what it is.
    fn at_largest(&self) -> ((usize, usize), f64) {
        let all = self.weights.indexed_iter().map(|(at, w)| (at, *w));
        all.reduce(|most, one| {
            if one.1.abs() > most.1.abs() {
                one
            } else {
                most
            }
        })
        .unwrap_or(((0, 0), 0.0))
    }

    /// Whether the weights can be squared and added up, as quantising, compiling and fitting do.
    ///
    /// # Errors
    /// When the largest weight is too small or too large for that. All weights may be zero.
    pub fn workable(&self) -> Result<(), KernelError> {
        let ((row, column), value) = self.at_largest();
        if value == 0.0 || (LEAST_WEIGHT..=MOST_WEIGHT).contains(&value.abs()) {
            return Ok(());
        }
        Err(KernelError::Unworkable { row, column, value })
    }

    /// A kernel from rows of weights, row 0 north.
    ///
    /// # Errors
    /// As [`Kernel::new`], and when rows differ in length.
    pub fn from_rows(rows: &[Vec<f64>]) -> Result<Self, KernelError> {
        let width = rows.first().map_or(0, Vec::len);
        if rows.len().max(width) > KERNEL_SIDE {
            return Err(KernelError::Size {
                height: rows.len(),
                width,
            });
        }
        if let Some((row, bad)) = rows.iter().enumerate().find(|(_, row)| row.len() != width) {
            return Err(KernelError::Ragged {
                row,
                got: bad.len(),
                want: width,
            });
        }
        let weights = Plane::from_shape_fn((rows.len(), width), |(y, x)| rows[y][x]);
        Self::new(weights)
    }

    /// The weights, `[row, column]`, row 0 north.
    #[must_use]
    pub const fn weights(&self) -> &Plane<f64> {
        &self.weights
    }

    /// The weights row by row, as they are told: one that was rounded to 0 from below is 0.
    #[must_use]
    pub fn rows(&self) -> Vec<Vec<f64>> {
        let row = |row: ArrayView1<'_, f64>| row.iter().map(|weight| weight + 0.0).collect();
        self.weights.rows().into_iter().map(row).collect()
    }

    /// How far the kernel reaches from its centre: rows, columns.
    #[must_use]
    pub fn reach(&self) -> (usize, usize) {
        let (height, width) = self.weights.dim();
        (height / 2, width / 2)
    }

    /// Whether all weights are 0.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.weights.iter().all(|weight| *weight == 0.0)
    }

    /// The response to uniform light.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.weights.sum()
    }

    /// The sum of the weights' magnitudes: the most by which the response can move where the light
    /// of every pixel moves by 1.
    #[must_use]
    pub fn magnitude(&self) -> f64 {
        self.weights.iter().map(|weight| weight.abs()).sum()
    }

    /// The largest magnitude of a weight.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.at_largest().1.abs()
    }

    /// Whether what is left of the sum is rounding alone, of weights in f32 too: 1e-6 of the weights'
    /// magnitudes.
    #[must_use]
    pub fn cancels(&self) -> bool {
        self.sum().abs() < 1e-6 * self.magnitude()
    }

    /// The response to uniform light, 0 where only rounding is left of it.
    #[must_use]
    pub fn dc(&self) -> f64 {
        if self.cancels() { 0.0 } else { self.sum() }
    }

    /// The same field with ON and OFF exchanged.
    #[must_use]
    pub fn negated(&self) -> Self {
        Self {
            weights: -&self.weights,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_odd_and_rows_even_long() {
        assert_eq!(Kernel::from_rows(&[]), Err(KernelError::Empty));
        assert_eq!(
            Kernel::from_rows(&[vec![1.0, 2.0]]),
            Err(KernelError::Even {
                height: 1,
                width: 2
            })
        );
        assert_eq!(
            Kernel::from_rows(&[vec![1.0], vec![1.0, 2.0], vec![1.0]]),
            Err(KernelError::Ragged {
                row: 1,
                got: 2,
                want: 1
            })
        );
        assert!(Kernel::from_rows(&[vec![f64::NAN]]).is_err());
        assert_eq!(
            Kernel::from_rows(&[vec![1.0; 5], vec![0.0; 5], vec![0.0; 5]])
                .unwrap()
                .reach(),
            (1, 2)
        );
    }

    #[test]
    fn what_rounding_leaves_of_a_sum_is_no_response_to_uniform_light() {
        let row = |weights: [f64; 3]| Kernel::from_rows(&[weights.to_vec()]).unwrap();
        let rounded = row([0.1, 0.2, -0.3]);
        assert!(rounded.sum() != 0.0 && rounded.dc() == 0.0);
        let whole = row([1.0, -3.0, 1.5]);
        assert_eq!((whole.dc(), whole.magnitude()), (-0.5, 5.5));
    }
}
