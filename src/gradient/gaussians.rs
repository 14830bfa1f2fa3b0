//! From the gradient of a kernel to that of the Gaussians that it is the sum of.

use crate::{kernel::Gaussian, plane::Plane};

/// The gradient of one Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianGradient {
    /// Of its standard deviation. The side of its square is held.
    pub sigma: f64,
    /// Of its gain.
    pub gain: f64,
}

/// The gradients of the Gaussians whose sum, by [`Kernel::from_gaussians`], has the gradient
/// `kernel`; `None` where that is not of the sum's size.
///
/// With `l = exp(-x² / 2σ²) / Z` a line of weights, `dl/dσ = l (x² - <x²>) / σ³`, where `<x²>` is the
/// mean over the line: from `Z`.
///
/// [`Kernel::from_gaussians`]: crate::kernel::Kernel::from_gaussians
#[must_use]
pub fn gaussian_gradients(
    parts: &[Gaussian],
    kernel: &Plane<f64>,
) -> Option<Vec<GaussianGradient>> {
    let side = parts.iter().map(Gaussian::side).max()?;
    if kernel.dim() != (side, side) {
        return None;
    }
    let of = |part: &Gaussian| {
        let line = part.line();
        let half = (line.len() / 2) as f64;
        let total: f64 = line.iter().sum();
        let square = |i: usize| (i as f64 - half).powi(2);
        let mean: f64 = line
            .iter()
            .enumerate()
            .map(|(i, l)| square(i) * l / total)
            .sum();
        let inset = (side - line.len()) / 2;
        let mut gradient = GaussianGradient {
            sigma: 0.0,
            gain: 0.0,
        };
        for (y, row) in line.iter().enumerate() {
            for (x, column) in line.iter().enumerate() {
                let asked = kernel[[inset + y, inset + x]] * row * column / (total * total);
                gradient.gain += asked;
                let spread = square(y) + square(x) - 2.0 * mean;
                gradient.sigma += part.gain * asked * spread / part.sigma.powi(3);
            }
        }
        gradient
    };
    Some(parts.iter().map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;

    #[test]
    fn the_gradient_is_the_difference() {
        let parts = [(1.0, 1.3), (2.04, -0.9)].map(|(sigma, gain)| Gaussian { sigma, gain });
        let asked = Plane::from_shape_fn((13, 13), |(y, x)| ((7 * y + 3 * x) % 11) as f64 - 4.5);
        let loss = |parts: &[Gaussian]| {
            let kernel = Kernel::from_gaussians(parts).unwrap();
            (kernel.weights() * &asked).sum()
        };
        let gradients = gaussian_gradients(&parts, &asked).unwrap();
        for (n, gradient) in gradients.iter().enumerate() {
            let step = 1e-5;
            let difference = |moved: &dyn Fn(&mut Gaussian, f64)| {
                let at = |by| {
                    let mut parts = parts;
                    moved(&mut parts[n], by);
                    loss(&parts)
                };
                (at(step) - at(-step)) / (2.0 * step)
            };
            let sigma = difference(&|part, by| part.sigma += by);
            let gain = difference(&|part, by| part.gain += by);
            assert!((gradient.sigma - sigma).abs() < 1e-6 * sigma.abs().max(1.0));
            assert!((gradient.gain - gain).abs() < 1e-6 * gain.abs().max(1.0));
        }
        assert_eq!(gaussian_gradients(&parts, &Plane::zeros((5, 5))), None);
    }
}
