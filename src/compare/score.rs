//! Scores: every metric with its value for baselines, so that a number means something.
//!
//! A score holds four values of one metric: that of the judged packet, that of the reference judged
//! against itself, and those of a [redraw](super::baseline) and a [permutation](super::baseline) of
//! the reference. A metric whose redraw scores like the identical packet is blind to when, one
//! whose permutation does is blind to where.
//!
//! A redraw of few events is itself random, so small packets are drawn several times and the mean
//! is given: as often as 200 000 events allow, at most 16 times.

use super::{
    Pair, baseline,
    metric::{ENTRIES, Measured, Metric, Scale},
    voxel::Bins,
    window::Redraws,
};
use crate::{stop::Stop, unit::Micros};

/// The scales at which to measure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scales {
    /// Windows of matches.
    pub within: Vec<Micros>,
    /// Time constants of van Rossum's distance.
    pub van_rossum: Vec<Micros>,
    /// Shifts that cost as much as an event added, in Victor and Purpura's distance.
    pub victor_purpura: Vec<Micros>,
    /// Bins of the voxel grids.
    pub bins: usize,
    /// Seed of the redraw and the permutation.
    pub seed: u64,
    /// Whether to end early: metrics that are left then have no value.
    pub stop: Stop,
}

impl Scales {
    /// Every metric at each of its scales: scale by scale, where several metrics share them.
    fn metrics(&self) -> Vec<Metric> {
        let mut all = Vec::new();
        for alike in ENTRIES.chunk_by(|a, b| a.scale == b.scale) {
            let scales = match alike.first().map(|entry| entry.scale) {
                Some(Scale::Window) => &self.within,
                Some(Scale::TimeConstant) => &self.van_rossum,
                Some(Scale::Shift) => &self.victor_purpura,
                Some(Scale::None) | None => {
                    all.extend(alike.iter().flat_map(|entry| entry.metrics(&[])));
                    continue;
                }
            };
            for at in scales {
                all.extend(alike.iter().map(|entry| entry.at(*at)));
            }
        }
        all
    }
}

impl Default for Scales {
    /// Windows of 1 us, 100 us, 1 ms, 10 ms; distances at 5 ms and 50 ms (for Victor and
    /// Purpura 200 and 20 per second); 8 bins; seed 0.
    fn default() -> Self {
        Self {
            within: [1, 100, 1_000, 10_000].map(Micros).to_vec(),
            van_rossum: [5_000, 50_000].map(Micros).to_vec(),
            victor_purpura: [5_000, 50_000].map(Micros).to_vec(),
            bins: 8,
            seed: 0,
            stop: Stop::NEVER,
        }
    }
}

/// One metric: its value, and its values for packets whose answer is known. None where the metric
/// has no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// The metric.
    pub metric: Metric,
    /// For the judged packet.
    pub value: Option<f64>,
    /// For the reference against itself.
    pub identical: Option<f64>,
    /// For redraws of the reference: right places, times by chance.
    pub redraw: Option<f64>,
    /// For permutations of the reference: right times, wrong places.
    pub permuted: Option<f64>,
}

impl Score {
    /// The position of the value between that of the identical packet, 0, and that of the redraw,
    /// 1. None where the metric cannot tell these apart.
    #[must_use]
    pub fn lost(&self) -> Option<f64> {
        let (from, to) = (self.identical?, self.redraw?);
        let lost = (self.value? - from) / (to - from);
        (self.metric.entry().knows_a_redraw && to != from).then_some(lost)
    }
}

/// Scores every metric.
#[must_use]
pub fn scores(pair: &Pair, scales: &Scales) -> Vec<Score> {
    scores_beside(pair, scales, &Redraws::new(pair, scales.seed))
}

/// As [`scores`], with redraws of the reference that are there already; of the seed of the
/// scales.
#[must_use]
pub fn scores_beside(pair: &Pair, scales: &Scales, redraws: &Redraws) -> Vec<Score> {
    let bins = Bins::over(pair, scales.bins);
    let measured = |pair: &Pair| measure(pair, scales, bins, redraws);
    let (value, identical) = (measured(pair), measured(&pair.identical()));
    let mean = |all: Vec<Vec<(Metric, Option<f64>)>>| {
        move |i: usize| {
            let sum: Option<f64> = all.iter().map(|draw| draw.get(i)?.1).sum();
            sum.map(|sum| sum / all.len() as f64)
        }
    };
    let redraw = mean(redraws.pairs().iter().map(measured).collect());
    let permutations = 0..Redraws::number(pair);
    let permute = |k| measured(&baseline::permute(pair, scales.seed.wrapping_add(k)));
    let permuted = mean(permutations.map(permute).collect());
    value
        .into_iter()
        .zip(identical)
        .enumerate()
        .map(|(i, ((metric, value), (_, identical)))| Score {
            metric,
            value,
            identical,
            redraw: redraw(i),
            permuted: permuted(i),
        })
        .collect()
}

/// Every metric of one pair, always in the same order, beside redraws of its reference.
#[must_use]
pub fn measure(
    pair: &Pair,
    scales: &Scales,
    bins: Bins,
    redraws: &Redraws,
) -> Vec<(Metric, Option<f64>)> {
    let measured = Measured::new(pair, bins, redraws);
    { scales.metrics().into_iter() }
        .map(|metric| {
            let goes_on = !scales.stop.is_asked();
            (metric, goes_on.then(|| metric.value(&measured)).flatten())
        })
        .collect()
}
