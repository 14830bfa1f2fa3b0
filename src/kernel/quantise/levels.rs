//! Few levels and a free scale: least squares, exactly.
//!
//! For levels `l` the best scale is `<w, l> / <l, l>`, and the squared residual is then
//! `|w|² - <w, l>² / <l, l>`. For a given scale, the best levels are the nearest. As the scale
//! grows from 0, a weight changes its level only where it lies midway between two; between two such
//! breakpoints no level changes, so one evaluation between each pair of them finds the global
//! optimum.

use super::{Chosen, Entry, Parameters, QuantiseError, Quantiser, Sum, error::affordable, total};
use crate::{
    limit::{QUANTISER_STEPS, QUANTISER_TABLE},
    number::greatest_common_divisor,
    order::Order,
};

/// `binary`
pub static BINARY: Entry = Entry {
    form: "binary",
    numbers: "",
    parameters: Parameters::None,
    levels: "±1",
    scale: "mean magnitude",
    quality: "the exact least-squares optimum",
    quantise: |quantiser, weights, sum, _| free(quantiser, &[1], weights, sum),
};

/// `ternary`
pub static TERNARY: Entry = Entry {
    form: "ternary",
    numbers: "",
    parameters: Parameters::None,
    levels: "-1, 0, 1",
    scale: "free",
    quality: "the exact least-squares optimum, by sorting",
    quantise: |quantiser, weights, sum, _| {
        if sum == Sum::Zero {
            Ok(balanced(weights))
        } else {
            free(quantiser, &[0, 1], weights, sum)
        }
    },
};

/// `ternary-0.7`
pub static TERNARY_07: Entry = Entry {
    form: "ternary-0.7",
    numbers: "",
    parameters: Parameters::None,
    levels: "-1, 0, 1",
    scale: "mean magnitude of those kept",
    quality: "zero below 0.7 of the mean magnitude (Li & Liu, arXiv 1605.04711)",
    quantise: |quantiser, weights, sum, _| rule_of_07(quantiser, weights, sum),
};

/// `ternary-split`
pub static TERNARY_SPLIT: Entry = Entry {
    form: "ternary-split",
    numbers: "",
    parameters: Parameters::None,
    levels: "-r, 0, 1",
    scale: "free",
    quality: "the exact optimum with a scale for each sign (r is their ratio)",
    quantise: |_, weights, sum, _| {
        if sum == Sum::Free {
            Ok(split(weights))
        } else {
            Err(QuantiseError::SplitSum)
        }
    },
};

/// `po2-N`: N exponents.
pub static POWERS_OF_TWO: Entry = Entry {
    form: "po2-N",
    numbers: "1 to 8 exponents",
    parameters: Parameters::One(1, 8),
    levels: "0, ±1, ±2 … ±2^(N-1)",
    scale: "free",
    quality: "the exact least-squares optimum",
    quantise: |quantiser, weights, sum, _| {
        let exponents = 0..quantiser.numbers[0];
        let powers = exponents.map(|e| 1 << e);
        let magnitudes: Vec<i64> = std::iter::once(0).chain(powers).collect();
        free(quantiser, &magnitudes, weights, sum)
    },
};

/// `int-B`: B bits, sign included.
pub static WHOLE: Entry = Entry {
    form: "int-B",
    numbers: "2 to 12 bits",
    parameters: Parameters::One(2, 12),
    levels: "whole numbers of B bits, symmetric",
    scale: "free",
    quality: "the exact least-squares optimum",
    quantise: |quantiser, weights, sum, _| {
        let bits = quantiser.numbers[0];
        let magnitudes: Vec<i64> = (0..1 << (bits - 1)).collect();
        free(quantiser, &magnitudes, weights, sum)
    },
};

/// The nearest level.
fn nearest(magnitudes: &[i64], value: f64) -> f64 {
    let far = |level: i64| (level as f64 - value.abs()).abs();
    let above = magnitudes.partition_point(|level| (*level as f64) < value.abs());
    let below = magnitudes[above.saturating_sub(1)];
    let above = magnitudes[above.min(magnitudes.len() - 1)];
    let level = if far(above) < far(below) {
        above
    } else {
        below
    };
    if value < 0.0 {
        -(level as f64)
    } else {
        level as f64
    }
}

/// The globally best levels and scale. `magnitudes` are the levels that are not negative, in order;
/// each stands for its negative as well.
fn free(
    quantiser: Quantiser,
    magnitudes: &[i64],
    weights: &[f64],
    sum: Sum,
) -> Result<Chosen, QuantiseError> {
    // One evaluation between each two breakpoints.
    let size = weights.len() as f64;
    let steps = size * size * (magnitudes.len() - 1) as f64;
    affordable(
        quantiser,
        weights.len(),
        steps,
        QUANTISER_STEPS,
        "steps of search",
    )?;
    let mut changes: Vec<f64> = magnitudes
        .windows(2)
        .flat_map(|pair| {
            let middle = (pair[0] + pair[1]) as f64 / 2.0;
            weights.iter().map(move |w| w.abs() / middle)
        })
        // A scale that is not a normal number would make weights infinite.
        .filter(|scale| *scale > 4.0 * f64::MIN_POSITIVE)
        .collect();
    changes.sort_by(f64::total_cmp);
    changes.dedup();
    let last = changes.last().map_or(1.0, |last| 2.0 * last);
    let between = changes.iter().scan(0.0, |before, change| {
        let scale = f64::midpoint(*before, *change);
        *before = *change;
        Some(scale)
    });
    let mut best: Option<(f64, Chosen)> = None;
    for scale in between.chain([last]) {
        let levels: Vec<f64> = weights
            .iter()
            .map(|w| nearest(magnitudes, w / scale))
            .collect();
        if levels.iter().all(|level| *level == 0.0) {
            continue;
        }
        let scale = best_scale(weights, &levels);
        let gain = scale * scale * levels.iter().map(|l| l * l).sum::<f64>();
        if best.as_ref().is_none_or(|(most, _)| gain > *most) {
            best = Some((gain, (levels, scale)));
        }
    }
    // The kernel is not all 0, so the smallest scale leaves a level.
    let (_, (levels, scale)) = best.ok_or(QuantiseError::Nothing)?;
    let chosen = with_sum(quantiser, magnitudes, weights, (levels, scale), sum)?;
    Ok(without_common_factor(chosen))
}

/// The smallest levels of the same shape: a common factor takes words of a program, and range.
fn without_common_factor((levels, scale): Chosen) -> Chosen {
    let divisor = levels.iter().fold(0, |divisor, level| {
        greatest_common_divisor(divisor, *level as i64)
    });
    if divisor < 2 {
        return (levels, scale);
    }
    let factor = divisor as f64;
    let smaller = levels.iter().map(|level| level / factor).collect();
    (smaller, scale * factor)
}

/// Zero below 0.7 of the mean magnitude.
fn rule_of_07(quantiser: Quantiser, weights: &[f64], sum: Sum) -> Result<Chosen, QuantiseError> {
    let mean = weights.iter().map(|w| w.abs()).sum::<f64>() / weights.len() as f64;
    let kept = |w: &f64| {
        if w.abs() > 0.7 * mean {
            w.signum()
        } else {
            0.0
        }
    };
    let levels: Vec<f64> = weights.iter().map(kept).collect();
    let scale = best_scale(weights, &levels);
    with_sum(quantiser, &[0, 1], weights, (levels, scale), sum)
}

/// As many +1 as -1, for a sum of 0.
///
/// For a given number k, the best levels are +1 at the k largest weights and -1 at the k smallest,
/// and the squared residual falls by `(sum of the largest - sum of the smallest)² / 2k`. The best k
/// is tried out.
fn balanced(weights: &[f64]) -> Chosen {
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.order_by(|a, b| weights[*b].total_cmp(&weights[*a]));
    let (mut best, mut apart) = ((0.0, 0), 0.0);
    for k in 1..=weights.len() / 2 {
        apart += weights[order[k - 1]] - weights[order[weights.len() - k]];
        let gain = apart * apart / (2 * k) as f64;
        if gain > best.0 {
            best = (gain, k);
        }
    }
    let mut levels = vec![0.0; weights.len()];
    for i in 0..best.1 {
        levels[order[i]] = 1.0;
        levels[order[weights.len() - 1 - i]] = -1.0;
    }
    let scale = if best.1 == 0 {
        1.0
    } else {
        best_scale(weights, &levels)
    };
    (levels, scale)
}

/// A scale for each sign: the positive and the negative weights are independent problems, each
/// solved by sorting.
fn split(weights: &[f64]) -> Chosen {
    let side = |sign: f64| {
        let mut own: Vec<f64> = weights
            .iter()
            .map(|w| w * sign)
            .filter(|w| *w > 0.0)
            .collect();
        own.order_by(|a, b| b.total_cmp(a));
        let mut best = (0.0, f64::INFINITY, 0.0);
        let mut sum = 0.0;
        for (k, w) in (1..).zip(&own) {
            sum += w;
            let k = f64::from(k);
            if sum * sum / k > best.0 {
                best = (sum * sum / k, *w, sum / k);
            }
        }
        (best.1, best.2)
    };
    let ((least_on, on), (least_off, off)) = (side(1.0), side(-1.0));
    // Without a positive side the negative one gives the scale.
    let scale = if on > 0.0 { on } else { off };
    let level = |w: &f64| {
        if *w >= least_on {
            1.0
        } else if -w >= least_off {
            -off / scale
        } else {
            0.0
        }
    };
    (weights.iter().map(level).collect(), scale)
}

/// Alternates between the nearest levels with the required sum at a scale, and the best scale for
/// these levels, until nothing changes.
fn with_sum(
    quantiser: Quantiser,
    magnitudes: &[i64],
    weights: &[f64],
    (mut levels, mut scale): Chosen,
    sum: Sum,
) -> Result<Chosen, QuantiseError> {
    if sum == Sum::Free {
        return Ok((levels, scale));
    }
    // Of consecutive whole numbers a few steps to the next ones settle the sum.
    let consecutive = quantiser.entry.form == WHOLE.form;
    if !consecutive {
        // Each weight can lead to each sum.
        let (size, most) = (
            weights.len() as f64,
            magnitudes[magnitudes.len() - 1] as f64,
        );
        let table = size * (2.0 * size * most + 1.0);
        affordable(
            quantiser,
            weights.len(),
            table,
            QUANTISER_TABLE,
            "entries of a table",
        )?;
    }
    let mut all: Vec<i64> = magnitudes
        .iter()
        .flat_map(|level| [-level, *level])
        .collect();
    all.sort_unstable();
    all.dedup();
    // Each turn is nearer than the last; a bound on them is for rounding.
    for _ in 0..100 {
        let scaled: Vec<f64> = weights.iter().map(|w| w / scale).collect();
        let exact = scaled.iter().sum::<f64>();
        let asked = match sum {
            Sum::Kept => exact.round() as i64,
            Sum::Zero | Sum::Free => 0,
        };
        let most = magnitudes[magnitudes.len() - 1] as f64;
        let far = weights.len() as f64 * most;
        let next = total::as_near_as_can_be(sum, (exact, asked as f64), (-far, far), |asked| {
            if !consecutive {
                return total::nearest(&scaled, &all, asked as i64);
            }
            let near = |value: &f64| value.round().clamp(-most, most);
            let mut steps: Vec<f64> = scaled.iter().map(near).collect();
            total::settle(&scaled, &mut steps, (-most, most), asked).map(|()| steps)
        });
        let next = next.ok_or(QuantiseError::Sum {
            quantiser,
            sum: asked as f64,
            weights: weights.len(),
        })?;
        let settled = next == levels;
        levels = next;
        let better = best_scale(weights, &levels);
        if settled || better <= 0.0 || better.is_nan() || sum == Sum::Kept {
            break;
        }
        scale = better;
    }
    Ok((levels, scale))
}

/// The scale that brings levels nearest to the weights.
pub(super) fn best_scale(weights: &[f64], levels: &[f64]) -> f64 {
    let both: f64 = weights.iter().zip(levels).map(|(w, l)| w * l).sum();
    let own: f64 = levels.iter().map(|l| l * l).sum();
    both / own
}
