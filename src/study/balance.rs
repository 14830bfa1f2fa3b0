//! Equal rates of kinds that share a memory: an event of any of them renews it for all, so that the
//! threshold of each moves the rates of all.
//!
//! Rates and thresholds in octaves, the thresholds are the root of (rates less the target): found
//! by Broyden's method (Math. Comp. 19, 1965), which learns how rates answer to thresholds from the
//! shows of the scene that it needs anyway. A show is of three sensors: the whole step, and two
//! shorter ones, as rates of few events do not fall evenly.

use super::rate::{RateError, Share, ThresholdFactor, check, rated, rates};
use crate::{elementary, plane::Plane, reference::Description, scene::Reopen};

/// Shows of the scene, at most.
const SHOWS: usize = 12;

/// Rates within this of each other are equal, in octaves: 3 %.
const EQUAL: f64 = 0.043;

/// How the rate of a kind falls with its threshold, octaves by octave, before it was seen to.
const STEEPNESS: f64 = 2.0;

/// The most that a threshold is moved at a time, in octaves.
const STRIDE: f64 = 2.0;

/// Parts of a step that are tried.
const PARTS: [f64; 3] = [1.0, 0.4, 0.15];

/// By what to multiply the thresholds of each kind for equal rates, `rate` events per pixel and
/// second of all together, from thresholds that are near ([`factors`](super::rate::factors)). They
/// come as near as twelve shows of the scene bring them, the best of these; the rates of all kinds.
///
/// # Errors
/// As [`factor`](super::rate::factor).
pub fn balanced(
    description: &Description,
    rate: f64,
    seed: u64,
    open: &Reopen<'_>,
) -> Result<Vec<ThresholdFactor>, RateError> {
    check(rate)?;
    let kinds = description.channels.len();
    let target = rate / kinds as f64;
    let tried = |all: &[Vec<f64>]| -> Result<Vec<Tried>, RateError> {
        let shown = rates(description, (all, Share::Each), seed, open)?;
        let tried = all.iter().zip(shown);
        Ok(tried
            .map(|(octaves, rates)| Tried::new(octaves, rates, target))
            .collect())
    };
    let start = tried(&[vec![0.0; kinds]])?;
    let mut best = start.into_iter().next().ok_or(RateError::Still)?;
    let mut answers = Answers::new(kinds);
    for _ in 1..SHOWS {
        if best.apart() < EQUAL {
            break;
        }
        let step = answers.step(&best.beyond);
        let moved = PARTS.map(|part| -> Vec<f64> {
            let own = best.octaves.iter().zip(&step);
            own.map(|(octave, step)| octave + part * step).collect()
        });
        let mut shown = tried(&moved)?;
        // What lies farthest is learned last: it says most of the way that is left.
        for tried in shown.iter().rev() {
            answers.learn(&best, tried);
        }
        shown.push(best.clone());
        let nearest = shown
            .into_iter()
            .min_by(|a, b| a.apart().total_cmp(&b.apart()));
        let Some(nearest) = nearest else { break };
        best = nearest;
    }
    Ok(rated(&best.octaves, &best.rates))
}

/// Thresholds that were tried.
#[derive(Clone)]
struct Tried {
    /// Of each kind, from its own.
    octaves: Vec<f64>,
    rates: Vec<f64>,
    /// Octaves of each rate above the target.
    beyond: Vec<f64>,
}

impl Tried {
    fn new(octaves: &[f64], rates: Vec<f64>, target: f64) -> Self {
        let beyond = rates.iter().map(|rate| {
            if *rate > 0.0 {
                elementary::log2(rate / target)
            } else {
                -STRIDE * STEEPNESS
            }
        });
        Self {
            octaves: octaves.to_vec(),
            beyond: beyond.collect(),
            rates,
        }
    }

    /// The rate that is farthest off, in octaves.
    fn apart(&self) -> f64 {
        self.beyond.iter().map(|it| it.abs()).fold(0.0, f64::max)
    }
}

/// How thresholds answer to rates, both in octaves: the inverse of the slopes.
struct Answers(Plane<f64>);

impl Answers {
    fn new(kinds: usize) -> Self {
        Self(Plane::eye(kinds) / -STEEPNESS)
    }

    /// What leads to the target, by all that was learned.
    fn step(&self, beyond: &[f64]) -> Vec<f64> {
        let step = product(&self.0, beyond);
        step.into_iter()
            .map(|it| (-it).clamp(-STRIDE, STRIDE))
            .collect()
    }

    /// Broyden's update: the least change that is true of these two.
    fn learn(&mut self, from: &Tried, to: &Tried) {
        let less =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let moved = less(&to.octaves, &from.octaves);
        let changed = less(&to.beyond, &from.beyond);
        let guessed = product(&self.0, &changed);
        let along: f64 = moved.iter().zip(&guessed).map(|(a, b)| a * b).sum();
        if along.abs() < 1e-9 {
            return;
        }
        let row = product(&self.0.t().to_owned(), &moved);
        let missed = less(&moved, &guessed);
        for ((y, x), answer) in self.0.indexed_iter_mut() {
            *answer += missed[y] * row[x] / along;
        }
    }
}

fn product(matrix: &Plane<f64>, vector: &[f64]) -> Vec<f64> {
    let row = |row: ndarray::ArrayView1<'_, f64>| row.iter().zip(vector).map(|(a, b)| a * b).sum();
    matrix.rows().into_iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scene::{OpenOptions, open},
        study::rate::factors,
    };

    /// Kinds that look at one memory, of kernels of different size, from the thresholds that each needs
    /// alone; from equal ones, which some of them never cross; of light that comes in leaps.
    #[test]
    fn kinds_of_one_memory_have_equal_rates() {
        let text = "response = { linear = 255 }\nmemory = \"raw-snap\"\nshared = true\n".to_owned()
            + &["dvs", "csdvs-5", "sobel-x", "laplacian"]
                .map(|kernel| {
                    format!("[[channel]]\nkernel = \"{kernel}\"\nthreshold = {{ on = 0.2, off = 0.2 }}\n")
                })
                .concat();
        let sensor = Description::parse("s.toml", &text, &|_| unreachable!()).unwrap();
        let each = 2.0;
        for pattern in [
            "pattern:noise?width=48&height=40&frames=20&fps=100&speed=60",
            "pattern:noise?width=48&height=40&frames=20&fps=25&speed=200",
        ] {
            let scene = || open(pattern, &OpenOptions::default());
            let alone = factors(&sensor, each, 3, &scene).unwrap();
            let mut near = sensor.clone();
            for (channel, rated) in near.channels.iter_mut().zip(&alone) {
                channel.thresholds[0].on *= rated.factor;
                channel.thresholds[0].off *= rated.factor;
            }
            for start in [&sensor, &near] {
                let found = balanced(start, 4.0 * each, 3, &scene).unwrap();
                for one in &found {
                    assert!((one.rate / each - 1.0).abs() < 0.1, "{pattern}: {found:?}");
                }
            }
        }
        let wrong = balanced(&sensor, -1.0, 3, &|| unreachable!());
        assert!(matches!(wrong, Err(RateError::Rate(_))), "{wrong:?}");
    }
}
