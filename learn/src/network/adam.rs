//! Adam (Kingma and Ba 2015, <https://arxiv.org/abs/1412.6980>).

use amacrine::gradient::Float;
use multiversion::multiversion;
use serde::{Deserialize, Serialize};

/// The running moments of some parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Adam<R> {
    /// Running means of gradients.
    pub first: Vec<R>,
    /// Running means of their squares.
    pub second: Vec<R>,
    /// Steps so far.
    pub steps: u64,
}

const FIRST: f64 = 0.9;
const SECOND: f64 = 0.99;
const LEAST: f64 = 1e-8;

impl<R: Float> Adam<R> {
    /// For so many parameters.
    #[must_use]
    pub fn new(parameters: usize) -> Self {
        Self {
            first: vec![R::ZERO; parameters],
            second: vec![R::ZERO; parameters],
            steps: 0,
        }
    }

    /// Moves parameters against their gradient, about `rate` each.
    pub fn step(&mut self, parameters: &mut [R], gradient: &[R], rate: f64) {
        self.steps += 1;
        let pace = R::from_f64(rate / (1.0 - power(FIRST, self.steps)));
        let scale = R::from_f64(1.0 / (1.0 - power(SECOND, self.steps)));
        let (a, b) = (R::from_f64(FIRST), R::from_f64(SECOND));
        let (c, d) = (R::from_f64(1.0 - FIRST), R::from_f64(1.0 - SECOND));
        let least = R::from_f64(LEAST);
        walk(
            parameters,
            gradient,
            (&mut self.first, &mut self.second),
            [a, b, c, d, scale, pace, least],
        );
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn walk<R: Float>(
    parameters: &mut [R],
    gradient: &[R],
    (first, second): (&mut [R], &mut [R]),
    [a, b, c, d, scale, pace, least]: [R; 7],
) {
    let moments = first.iter_mut().zip(second);
    for ((parameter, g), (first, second)) in parameters.iter_mut().zip(gradient).zip(moments) {
        *first = a * *first + c * *g;
        *second = b * *second + d * (*g * *g);
        let root = R::from_f64((*second * scale).to_f64().sqrt());
        *parameter = *parameter - pace * *first / (root + least);
    }
}

/// By squaring, so that it has the same bits on every machine.
fn power(base: f64, exponent: u64) -> f64 {
    let (mut base, mut rest, mut product) = (base, exponent, 1.0);
    while rest > 0 {
        if rest % 2 == 1 {
            product *= base;
        }
        base *= base;
        rest /= 2;
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_descended() {
        let mut adam = Adam::new(2);
        let mut at = [3.0f64, -2.0];
        for step in 0..2000 {
            let slope = [2.0 * (at[0] - 1.0), 20.0 * (at[1] - 0.5)];
            adam.step(&mut at, &slope, 0.05 * (1.0 - f64::from(step) / 2000.0));
        }
        assert!(
            (at[0] - 1.0).abs() < 1e-3 && (at[1] - 0.5).abs() < 1e-3,
            "{at:?}"
        );
        // The first step is as long as the rate, whatever the slope.
        let (mut adam, mut at) = (Adam::new(1), [0.0f64]);
        adam.step(&mut at, &[1e-3], 0.1);
        assert!((at[0] + 0.1).abs() < 1e-5);
    }
}
