//! Fixed point, Qm.n: multiples of a power of two.

use super::{Entry, Parameters, QuantiseError, Quantiser, Rounding, Sum, entry::whole, total};
use crate::rng::Hash;

/// `qM.N`: M bits before the point, sign included, and N after it.
pub static ENTRY: Entry = Entry {
    form: "qM.N",
    numbers: "1 to 24 bits before the point and 0 to 24 after it; :floor or :stochastic may follow",
    parameters: Parameters::Fixed,
    levels: "multiples of 2^-N of M + N bits",
    scale: "1",
    quality: "half a step; `:floor` below one step, `:stochastic` below one, unbiased (these two move no level for a sum)",
    quantise: |quantiser, weights, sum, seed| {
        let [whole, fraction] = quantiser.numbers;
        let how = (whole, fraction, quantiser.rounding);
        quantise(quantiser, weights, how, sum, seed)
    },
};

/// The numbers of a name, and its rounding.
pub(super) fn numbers(text: &str) -> Result<([u32; 2], Rounding), String> {
    let (format, rounding) = text.split_once(':').unwrap_or((text, "nearest"));
    let (before, after) = format
        .split_once('.')
        .ok_or_else(|| "a Q format is written as q3.4".to_owned())?;
    let rounding = match rounding {
        "nearest" => Rounding::Nearest,
        "floor" => Rounding::Floor,
        "stochastic" => Rounding::Stochastic,
        other => return Err(format!("`{other}` is no rounding")),
    };
    Ok(([whole(before, 1, 24)?, whole(after, 0, 24)?], rounding))
}

/// The levels, and the scale, which is 1.
fn quantise(
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
        Rounding::Stochastic => (value + Hash::new(seed).nth(i as u64).uniform()).floor(),
    };
    let values: Vec<f64> = weights.iter().map(|w| w * one).collect();
    let mut steps: Vec<f64> = values
        .iter()
        .enumerate()
        .map(|(i, value)| round(i, *value).clamp(low, high))
        .collect();
    // A rule for each weight leaves no freedom for a sum.
    let free = sum == Sum::Free || sum == Sum::Kept && rounding != Rounding::Nearest;
    if sum == Sum::Zero && rounding != Rounding::Nearest {
        return Err(QuantiseError::RoundedSum { quantiser });
    }
    if !free {
        let exact = match sum {
            Sum::Kept => values.iter().sum::<f64>(),
            Sum::Zero | Sum::Free => 0.0,
        };
        let (asked, n) = (exact.round_ties_even(), weights.len() as f64);
        // As near as the format reaches, which is the same kernel's up to half of its weights: what
        // is farther would draw all others after those that are clipped.
        let near = asked.clamp(n * low, n * high);
        let half = values.iter().map(|value| value.abs()).sum::<f64>() / 2.0;
        let settled = ((near - asked).abs() <= half)
            .then(|| total::settle(&values, &mut steps, (low, high), near))
            .flatten();
        settled.ok_or(QuantiseError::Sum {
            quantiser,
            sum: asked / one,
            weights: weights.len(),
        })?;
    }
    Ok((steps.iter().map(|step| step / one).collect(), 1.0))
}
