//! Differences at equal bits, with what chance leaves open.

use std::collections::BTreeSet;

use amacrine::{elementary, rng::Hash};

use super::{
    RESAMPLES,
    curve::{Of, Weighted, ends, points, quality, rows_of},
    metric::Metric,
};
use crate::record::Row;

/// Places at which two curves are compared, evenly over the bits that they have in common.
const PLACES: usize = 17;

/// How far apart, in log2 of bits, two curves of one point each may be and still count as equal.
const EQUAL: f64 = 0.15;

/// What numbers are drawn for.
const REASON: u64 = 0x6469_6666;

/// How much better one arm is than another at equal bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The mean over the bits that both have in common, in the metric's unit; above 0 where the
    /// first arm's metric is larger, whether that is better or not.
    pub mean: f64,
    /// Of 95 in 100 resamplings of photographs and seeds; all numbers where there is one of each,
    /// since one alone says nothing of others.
    pub interval: [f64; 2],
    /// The bits a pixel and pair from which to which they are compared.
    pub bits: [f64; 2],
    /// Photographs that are resampled.
    pub photographs: usize,
    /// Seeds that are resampled.
    pub seeds: usize,
}

impl Difference {
    /// Whether chance alone does not make it: the interval is on one side of 0 in the digits that a
    /// metric is told with, and is one over several photographs and several seeds.
    #[must_use]
    pub fn shown(&self, metric: Metric) -> bool {
        // Half of the last digit: what is nearer to 0 is told as 0.
        let least = 0.5 * elementary::pow(10.0, -(metric.digits() as f64));
        let beyond_zero = self.interval[0] > least || self.interval[1] < -least;
        self.photographs > 1 && self.seeds > 1 && beyond_zero
    }

    /// Of two arms in two forms; `None` where they have no bits in common.
    pub(super) fn new<'r>(
        rows: &'r [Row],
        (a, b): (Of<'_>, Of<'_>),
        metric: Metric,
    ) -> Option<Self> {
        let own = [a, b].map(|of| rows_of(rows, of));
        // Of two forms one may have been shown fewer clips: only those of both are compared.
        let shown = own.each_ref().map(|rows| -> BTreeSet<(&str, u64)> {
            let clip = |row: &&'r Row| (row.photograph.as_str(), row.clip);
            rows.iter().map(clip).collect()
        });
        let both = |row: &&Row| {
            let clip = (row.photograph.as_str(), row.clip);
            shown.iter().all(|shown| shown.contains(&clip))
        };
        let own = own.map(|rows| rows.into_iter().filter(both).collect::<Vec<_>>());
        let all = || own.iter().flatten();
        let mut photographs: Vec<&str> = all().map(|row| row.photograph.as_str()).collect();
        photographs.sort_unstable();
        photographs.dedup();
        let mut seeds: Vec<u64> = all().map(|row| row.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        // Each row with the number of its photograph and of its seed.
        let numbered = own.map(|rows| -> Vec<(&Row, usize, usize)> {
            let number = |row: &&Row| {
                let photograph = photographs.binary_search(&row.photograph.as_str());
                let seed = seeds.binary_search(&row.seed);
                (photograph.unwrap_or(0), seed.unwrap_or(0))
            };
            rows.iter()
                .map(|row| {
                    let (photograph, seed) = number(row);
                    (*row, photograph, seed)
                })
                .collect()
        });
        let curves = |weight: &dyn Fn(usize, usize) -> f64| {
            numbered.each_ref().map(|rows| {
                let weighted: Weighted<'_> = { rows.iter() }
                    .map(|(row, photograph, seed)| (*row, weight(*photograph, *seed)))
                    .filter(|(_, weight)| *weight > 0.0)
                    .collect();
                points(&weighted, metric)
            })
        };
        let [a, b] = curves(&|_, _| 1.0);
        let ((low_a, high_a), (low_b, high_b)) = (ends(&a)?, ends(&b)?);
        let (mut low, mut high) = (low_a.max(low_b), high_a.min(high_b));
        if low > high {
            if low - high > EQUAL {
                return None;
            }
            (low, high) = (high, low);
        }
        let between = |a: &[_], b: &[_]| {
            let place = |n: usize| low + (high - low) * n as f64 / (PLACES - 1) as f64;
            let far = |n| quality(a, place(n)) - quality(b, place(n));
            (0..PLACES).map(far).sum::<f64>() / PLACES as f64
        };
        let mean = between(&a, &b);
        let (count, of_seeds) = (photographs.len(), seeds.len());
        let told = |interval| Self {
            mean,
            interval,
            bits: [low, high].map(|log| elementary::pow(2.0, log)),
            photographs: count,
            seeds: of_seeds,
        };
        if count < 2 && of_seeds < 2 {
            return Some(told([f64::NEG_INFINITY, f64::INFINITY]));
        }
        let mut resampled: Vec<f64> = (0..RESAMPLES)
            .filter_map(|turn| {
                let hash = Hash::new(REASON).with(turn);
                let counts = |what: u64, count: usize| {
                    let mut counts = vec![0.0; count];
                    for n in 0..count {
                        let draw = hash.with(what).with(n as u64).uniform();
                        counts[((draw * count as f64) as usize).min(count - 1)] += 1.0;
                    }
                    counts
                };
                let (of_photograph, of_seed) =
                    (counts(0, photographs.len()), counts(1, seeds.len()));
                let [a, b] = curves(&|photograph, seed| of_photograph[photograph] * of_seed[seed]);
                let own = between(&a, &b);
                own.is_finite().then_some(own)
            })
            .collect();
        resampled.sort_by(f64::total_cmp);
        let at = |part: f64| {
            let place = (part * (resampled.len().saturating_sub(1)) as f64).round();
            resampled.get(place as usize).copied().unwrap_or(f64::NAN)
        };
        Some(told([at(0.025), at(0.975)]))
    }
}
