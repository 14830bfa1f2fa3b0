//! Receptive fields: small planes of weights, as data.
//!
//! Kernels are **correlations**: `out(p) = sum over d of k(d) in(p + d)`, with row 0 of a
//! kernel to the north and column 0 to the west. Sides are odd, so that a kernel has a centre.
//! Built-in kernels are files in `kernels/`, each with where it came from.

mod file;
pub mod quantise;
mod zoo;

pub use file::KernelFileError;

use crate::plane::Plane;

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
        "the kernel is {height} rows by {width} columns; both must be odd, so that it has a centre"
    )]
    Even {
        /// Rows.
        height: usize,
        /// Columns.
        width: usize,
    },
    /// Rows of different lengths.
    #[error(
        "row {row} of the kernel has {got} weights, row 0 has {want}; all rows must be of one length"
    )]
    Ragged {
        /// Which row.
        row: usize,
        /// Its length.
        got: usize,
        /// The length of row 0.
        want: usize,
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
    /// When a side is zero or even, or a weight is not finite.
    pub fn new(weights: Plane<f64>) -> Result<Self, KernelError> {
        let (height, width) = weights.dim();
        if height == 0 || width == 0 {
            return Err(KernelError::Empty);
        }
        if height % 2 == 0 || width % 2 == 0 {
            return Err(KernelError::Even { height, width });
        }
        if let Some(((row, column), &value)) = weights.indexed_iter().find(|(_, w)| !w.is_finite())
        {
            return Err(KernelError::NotFinite { row, column, value });
        }
        Ok(Self { weights })
    }

    /// A kernel from rows of weights, row 0 north.
    ///
    /// # Errors
    /// As [`Kernel::new`], and when rows differ in length.
    pub fn from_rows(rows: &[Vec<f64>]) -> Result<Self, KernelError> {
        let width = rows.first().map_or(0, Vec::len);
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

    /// How far the kernel reaches from its centre: rows, columns.
    #[must_use]
    pub fn reach(&self) -> (usize, usize) {
        let (height, width) = self.weights.dim();
        (height / 2, width / 2)
    }

    /// The response to uniform light.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.weights.sum()
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
}
