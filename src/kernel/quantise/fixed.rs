//! Multiples of a power of two: Qm.n.

use super::{QuantiseError, Quantiser, Rounding, Sum, total};
use crate::rng::Key;

/// The levels, and the scale, which is 1.
pub(super) fn quantise(
    quantiser: Quantiser,
    weights: &[f64],
    (whole, fraction, rounding): (u32, u32, Rounding),
    sum: Sum,
    seed: u64,
) -> Result<(Vec<f64>, f64), QuantiseError> {
    let one = 2f64.powi(fraction as i32);
    let half = 2f64.powi((whole + fraction) as i32 - 1);
    let (low, high) = (-half, half - 1.0);
    let round = |i: usize, value: f64| match rounding {
        Rounding::Nearest => value.round_ties_even(),
        Rounding::Floor => value.floor(),
        Rounding::Stochastic => (value + Key::new(seed).nth(i as u64).uniform()).floor(),
    };
    let values: Vec<f64> = weights.iter().map(|w| w * one).collect();
    let mut steps: Vec<f64> = values
        .iter()
        .enumerate()
        .map(|(i, value)| round(i, *value).clamp(low, high))
        .collect();
    if sum != Sum::Free {
        let asked = match sum {
            Sum::Kept => values.iter().sum::<f64>().round_ties_even(),
            Sum::Zero | Sum::Free => 0.0,
        };
        total::settle(&values, &mut steps, (low, high), asked).ok_or(QuantiseError::Sum {
            quantiser,
            sum: asked,
            weights: weights.len(),
        })?;
    }
    Ok((steps.iter().map(|step| step / one).collect(), 1.0))
}
