//! Kernels that are sums of Gaussians.

use crate::{elementary, limit::KERNEL_SIDE, plane::Plane};

use super::{Kernel, KernelError};

/// A term of a sum of Gaussians: cut at `int(6 sigma) + 1` made odd, normalised, then scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// Its standard deviation, in pixels; above 0.
    pub sigma: f64,
    /// The sum of its weights.
    pub gain: f64,
}

impl Gaussian {
    /// Rows and columns of its square.
    #[must_use]
    pub const fn side(&self) -> usize {
        ((6.0 * self.sigma) as usize).saturating_add(1) | 1
    }

    /// A row of it, not normalised: `exp(-x² / 2 sigma²)`.
    ///
    /// # Panics
    /// When sigma is so large, or infinite, that memory does not hold [`Gaussian::side`] numbers.
    /// [`Kernel::from_gaussians`] refuses such a sigma.
    #[must_use]
    pub fn line(&self) -> Vec<f64> {
        let own = self.side();
        let half = (own / 2) as f64;
        (0..own)
            .map(|i| elementary::exp(-(i as f64 - half).powi(2) / (2.0 * self.sigma * self.sigma)))
            .collect()
    }
}

impl Kernel {
    /// The sum of these Gaussians, as `gaussians = [...]` of a kernel file.
    ///
    /// # Errors
    /// When there are none, a sigma is not above 0, or their sum is no kernel.
    pub fn from_gaussians(parts: &[Gaussian]) -> Result<Self, KernelError> {
        let odd = |part: &&Gaussian| !(part.sigma.is_finite() && part.sigma > 0.0);
        if let Some(Gaussian { sigma, .. }) = parts.iter().find(odd) {
            return Err(KernelError::Sigma { sigma: *sigma });
        }
        let side = parts.iter().map(Gaussian::side).max();
        let side = side.ok_or(KernelError::Empty)?;
        if side > KERNEL_SIDE {
            let (height, width) = (side, side);
            return Err(KernelError::Size { height, width });
        }
        let mut weights = Plane::<f64>::zeros((side, side));
        for part in parts {
            let line = part.line();
            let total: f64 = line.iter().sum::<f64>().powi(2);
            let inset = (side - line.len()) / 2;
            for (y, row) in line.iter().enumerate() {
                for (x, column) in line.iter().enumerate() {
                    weights[[inset + y, inset + x]] += part.gain * row * column / total;
                }
            }
        }
        Self::new(weights)
    }
}
