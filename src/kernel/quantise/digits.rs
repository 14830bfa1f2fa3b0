//! Canonical signed digits (CSD) under a budget: each weight is a sum of few signed powers of two,
//! with a given number of non-zero digits in the whole kernel.
//!
//! Additions on a chip go by digits that are not 0, wherever in the kernel they are. For every
//! weight the nearest number of 0, 1, 2 … digits is looked up; dynamic programming over
//! the weights then finds how the budget is best shared out.

use super::{Entry, Parameters, QuantiseError, Quantiser, Sum, error::affordable, total};
use crate::{
    elementary,
    limit::{QUANTISER_STEPS, QUANTISER_TABLE},
    number::signed_digits,
};

/// Bits of the levels of `csd-D`, without their sign.
pub const FINEST: u32 = 8;

/// `csd-D`: D digits that are not 0, in the whole kernel.
pub static ENTRY: Entry = Entry {
    form: "csd-D",
    numbers: "1 or more digits in the whole kernel",
    parameters: Parameters::One(1, 100_000),
    levels: "D signed powers of two in the whole kernel",
    scale: "a power of two",
    quality: "the exact optimum for that scale and 8 bits; near it where the sum is asked for",
    quantise: |quantiser, weights, sum, _| quantise(quantiser, weights, quantiser.numbers[0], sum),
};

/// The levels, whole numbers of [`FINEST`] bits, and the scale.
fn quantise(
    quantiser: Quantiser,
    weights: &[f64],
    budget: u32,
    sum: Sum,
) -> Result<(Vec<f64>, f64), QuantiseError> {
    let largest = weights.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
    let top = 1i64 << FINEST;
    let scale = 2f64.powi(elementary::log2(largest).ceil() as i32) / top as f64;
    let values: Vec<f64> = weights.iter().map(|w| w / scale).collect();
    let exact = values.iter().sum::<f64>();
    let asked = match sum {
        Sum::Free => None,
        Sum::Zero => Some(0),
        Sum::Kept => Some(exact.round() as i64),
    };
    let budget = budget.min(weights.len() as u32 * most_digits(top)) as usize;
    let (n, size) = (weights.len(), weights.len() as f64);
    let table = size * (budget + 1) as f64;
    affordable(quantiser, n, table, QUANTISER_TABLE, "entries of a table")?;
    if asked.is_some() {
        // At worst a step for each weight, each of which looks at every level of every weight.
        let steps = size * size * (2 * top) as f64;
        affordable(quantiser, n, steps, QUANTISER_STEPS, "steps of search")?;
    }
    let levels = match asked {
        None => share(&values, budget, None),
        Some(asked) => {
            let far = size * top as f64;
            total::as_near_as_can_be(sum, (exact, asked as f64), (-far, far), |asked| {
                share(&values, budget, Some(asked as i64))
            })
        }
    };
    let levels = levels.ok_or(QuantiseError::Sum {
        quantiser,
        sum: asked.unwrap_or(0) as f64 * scale,
        weights: weights.len(),
    })?;
    Ok((levels, scale))
}

/// The most digits of any number up to `top`.
fn most_digits(top: i64) -> u32 {
    (0..=top).map(signed_digits).max().unwrap_or(0)
}

/// For each number of digits up to `most`: the nearest whole number to `value` that has so many.
fn nearest(value: f64, top: i64, most: u32) -> Vec<i64> {
    let mut best = vec![0i64; most as usize + 1];
    for level in -top..=top {
        let far = |level: i64| (level as f64 - value).abs();
        for best in &mut best[signed_digits(level).min(most) as usize..] {
            if signed_digits(level) <= most && far(level) < far(*best) {
                *best = level;
            }
        }
    }
    best
}

/// The best distribution of the budget over the weights (dynamic programming); with a required sum,
/// levels are then adjusted until it is met, or `None` when the budget does not allow it.
fn share(values: &[f64], budget: usize, asked: Option<i64>) -> Option<Vec<f64>> {
    let top = 1i64 << FINEST;
    let most = most_digits(top).min(budget as u32);
    let choices: Vec<Vec<i64>> = values.iter().map(|v| nearest(*v, top, most)).collect();
    let mut cost = vec![0.0; budget + 1];
    let mut taken = Vec::with_capacity(values.len());
    for (value, choices) in values.iter().zip(&choices) {
        let mut next = vec![f64::INFINITY; budget + 1];
        // A weight has few digits.
        let mut by = vec![0u8; budget + 1];
        for used in 0..=budget {
            for (k, level) in choices.iter().enumerate().take(used + 1) {
                let total = cost[used - k] + (*level as f64 - value).powi(2);
                if total < next[used] {
                    (next[used], by[used]) = (total, k as u8);
                }
            }
        }
        cost = next;
        taken.push(by);
    }
    let mut levels = vec![0i64; values.len()];
    let mut left = budget;
    for ((level, by), choices) in levels.iter_mut().zip(&taken).zip(&choices).rev() {
        let digits = usize::from(by[left]);
        *level = choices[digits];
        left -= digits;
    }
    if let Some(asked) = asked {
        balance(values, &mut levels, budget as u32, asked)?;
    }
    Some(levels.iter().map(|level| *level as f64).collect())
}

/// Adjusts one or two weights at a time, the change of least error first, until the sum is right
/// and the digits are within the budget.
fn balance(values: &[f64], levels: &mut [i64], budget: u32, asked: i64) -> Option<()> {
    let top = 1i64 << FINEST;
    let far = |i: usize, level: i64| (level as f64 - values[i]).powi(2);
    while levels.iter().sum::<i64>() != asked {
        let missing = asked - levels.iter().sum::<i64>();
        let used: u32 = levels.iter().map(|level| signed_digits(*level)).sum();
        let mut best: Option<(f64, usize, i64)> = None;
        for (i, now) in levels.iter().enumerate() {
            // Any step towards the sum, the whole way at most.
            for step in 1..=missing.abs().min(2 * top) {
                let level = now + step * missing.signum();
                if level.abs() > top || used - signed_digits(*now) + signed_digits(level) > budget {
                    continue;
                }
                let hurt = (far(i, level) - far(i, *now)) / step as f64;
                if best.is_none_or(|(least, ..)| hurt < least) {
                    best = Some((hurt, i, level));
                }
            }
        }
        let (_, i, level) = best?;
        levels[i] = level;
    }
    Some(())
}
