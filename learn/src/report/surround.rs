//! Whether a delta became a centre with a surround.

use crate::record::KernelAt;

/// 97.5 % points of Student's distribution, from one degree of freedom on.
const STUDENT: [f64; 10] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
];

/// Digits behind the point with which it is told.
pub(super) const DIGITS: usize = 3;

/// Half of the last of them: what is nearer to 0 is told as 0.
const LEAST: f64 = 0.000_5;

/// All weights round the centre, as a part of the centre's.
#[derive(Clone, Debug, PartialEq)]
pub struct Surround {
    /// For each seed, the mean over its targets.
    pub seeds: Vec<f64>,
    /// Their mean.
    pub mean: f64,
    /// Where the mean of all seeds lies with 95 % (Student's distribution over the seeds); all
    /// numbers where there is one seed.
    pub interval: [f64; 2],
}

impl Surround {
    /// Of the last kernels of an arm.
    pub(super) fn new(kernels: &[KernelAt], arm: &str) -> Option<Self> {
        let own: Vec<&KernelAt> = kernels.iter().filter(|one| one.arm == arm).collect();
        let last = own.iter().map(|one| one.step).max()?;
        let mut seeds: Vec<u64> = own.iter().map(|one| one.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        let of_seed = |seed: &u64| {
            let all: Vec<f64> = { own.iter() }
                .filter(|one| one.seed == *seed && one.step == last)
                .filter_map(|one| one.kernels.first().and_then(|kernel| part(kernel)))
                .collect();
            (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
        };
        let seeds: Vec<f64> = seeds.iter().filter_map(of_seed).collect();
        let count = seeds.len() as f64;
        if seeds.is_empty() {
            return None;
        }
        let mean = seeds.iter().sum::<f64>() / count;
        let square: f64 = seeds.iter().map(|own| (own - mean).powi(2)).sum();
        let half = match seeds.len() {
            1 => f64::INFINITY,
            n => STUDENT[(n - 2).min(STUDENT.len() - 1)] * (square / (count - 1.0) / count).sqrt(),
        };
        Some(Self {
            mean,
            interval: [mean - half, mean + half],
            seeds,
        })
    }

    /// The answer.
    #[must_use]
    pub fn answer(&self) -> &'static str {
        if self.interval[1] < -LEAST {
            "yes: a centre with a surround of the other sign"
        } else if self.interval[0] > LEAST {
            "no: its surround has the centre's sign"
        } else {
            "not shown"
        }
    }
}

/// The weights round the centre, as a part of the centre's.
fn part(kernel: &[Vec<f64>]) -> Option<f64> {
    let centre = *kernel.get(kernel.len() / 2)?.get(kernel.len() / 2)?;
    let sum: f64 = kernel.iter().flatten().sum();
    (centre != 0.0).then(|| (sum - centre) / centre)
}
