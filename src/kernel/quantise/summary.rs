//! What a quantised kernel is and what it has lost, in numbers.

use super::{super::Kernel, quantised::Quantised, response::Change};

/// A kernel in few values, in numbers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Summary {
    /// The levels, row by row, row 0 to the north.
    pub levels: Vec<Vec<f64>>,
    /// What they are to be multiplied by.
    pub scale: f64,
    /// `|w - s l| / |w|`, root mean square.
    pub relative_error: f64,
    /// The sum of the kernel that levels and scale stand for.
    pub sum: f64,
    /// Levels that are not 0.
    pub taps: usize,
    /// What becomes of the frequency response.
    pub response: Change,
}

impl Summary {
    /// Of a kernel and what a quantiser has made of it.
    #[must_use]
    pub fn new(kernel: &Kernel, quantised: &Quantised) -> Self {
        let levels = quantised.levels.weights();
        let own = quantised.kernel();
        Self {
            levels: levels.rows().into_iter().map(|row| row.to_vec()).collect(),
            scale: quantised.scale,
            relative_error: quantised.relative_error(kernel),
            sum: own.dc(),
            taps: levels.iter().filter(|level| **level != 0.0).count(),
            response: Change::between(kernel, &own),
        }
    }
}
