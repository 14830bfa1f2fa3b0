//! Every metric with its floor and ceiling beside it, so that a number means something.
//!
//! A score holds four values of one metric: that of the judged packet, that of the reference
//! judged against itself, and those of a [redraw](super::null) and a
//! [permutation](super::null) of the reference. A metric whose redraw scores like the
//! identical packet is blind to when, one whose permutation does is blind to where.
//!
//! A redraw of few events is itself chance, so small packets are drawn several times and the
//! mean is given: as often as 200 000 events allow, at most 16 times.

use std::fmt;

use super::{
    Pair, counts, intervals,
    matching::{matched, share},
    null, rates, van_rossum, victor_purpura,
    voxel::{self, Bins},
};
use crate::{event::address::AddressWord, unit::Micros};

/// At which scales to measure.
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
        }
    }
}

/// What a metric measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metric {
    /// Matched share of the judged events, within a window.
    Precision(Micros),
    /// Matched share of the reference's events, within a window.
    Recall(Micros),
    /// Harmonic mean of the two, within a window.
    F1(Micros),
    /// Van Rossum's distance per event, at a time constant.
    VanRossum(Micros),
    /// Victor and Purpura's distance per event, at the shift that costs 1.
    VictorPurpura(Micros),
    /// L1 of voxel grids per event, ON less OFF.
    VoxelL1,
    /// L1 of voxel grids per event, ON and OFF apart.
    VoxelL1SignsApart,
    /// Root of the mean square of voxels, in events.
    VoxelRmse,
    /// Pearson of counts, cell by cell.
    CountPearson,
    /// L1 of counts per event, cell by cell.
    CountL1,
    /// Pearson of the map of ON + OFF.
    RatePearson,
    /// L1 of the map of ON + OFF, per event.
    RateL1,
    /// Pearson of the map of ON - OFF.
    SignedRatePearson,
    /// L1 of the map of ON - OFF, per event.
    SignedRateL1,
    /// Divergence of intervals, of the judged packet from the reference, in nats.
    Intervals,
    /// The same the other way round.
    IntervalsBack,
    /// Events of the judged packet for one of the reference.
    Events,
    /// Bits of the judged packet, each event one address word.
    Bits,
}

impl Metric {
    /// Name in files: letters, digits and `_`.
    #[must_use]
    pub fn key(self) -> String {
        match self {
            Self::Precision(t) => format!("precision_{}", Short(t)),
            Self::Recall(t) => format!("recall_{}", Short(t)),
            Self::F1(t) => format!("f1_{}", Short(t)),
            Self::VanRossum(t) => format!("van_rossum_{}", Short(t)),
            Self::VictorPurpura(t) => format!("victor_purpura_{}", Short(t)),
            Self::VoxelL1 => "voxel_l1".into(),
            Self::VoxelL1SignsApart => "voxel_l1_signs_apart".into(),
            Self::VoxelRmse => "voxel_rmse".into(),
            Self::CountPearson => "count_pearson".into(),
            Self::CountL1 => "count_l1".into(),
            Self::RatePearson => "rate_pearson".into(),
            Self::RateL1 => "rate_l1".into(),
            Self::SignedRatePearson => "signed_rate_pearson".into(),
            Self::SignedRateL1 => "signed_rate_l1".into(),
            Self::Intervals => "interval_divergence".into(),
            Self::IntervalsBack => "interval_divergence_back".into(),
            Self::Events => "events_ratio".into(),
            Self::Bits => "bits_sent".into(),
        }
    }

    /// What it cannot see; empty when it sees where, when and which sign.
    #[must_use]
    pub const fn blind_to(self) -> &'static str {
        match self {
            Self::Precision(_)
            | Self::Recall(_)
            | Self::F1(_)
            | Self::VanRossum(_)
            | Self::VictorPurpura(_)
            | Self::VoxelL1SignsApart => "",
            Self::VoxelL1 | Self::VoxelRmse => "ON with OFF in one bin",
            Self::CountPearson | Self::CountL1 => "time",
            Self::RatePearson | Self::RateL1 => "time, sign",
            Self::SignedRatePearson | Self::SignedRateL1 => "time, ON with OFF",
            Self::Intervals | Self::IntervalsBack => "wrong pixels, delay",
            Self::Events | Self::Bits => "all but number",
        }
    }

    /// A redraw of the reference scores worse than the reference, by more than chance.
    const fn knows_a_redraw(self) -> bool {
        match self {
            Self::Precision(_)
            | Self::Recall(_)
            | Self::F1(_)
            | Self::VanRossum(_)
            | Self::VictorPurpura(_)
            | Self::VoxelL1
            | Self::VoxelL1SignsApart
            | Self::VoxelRmse => true,
            Self::CountPearson
            | Self::CountL1
            | Self::RatePearson
            | Self::RateL1
            | Self::SignedRatePearson
            | Self::SignedRateL1
            | Self::Intervals
            | Self::IntervalsBack
            | Self::Events
            | Self::Bits => false,
        }
    }

    /// Its value is the same with the two packets exchanged.
    #[must_use]
    pub const fn symmetric(self) -> bool {
        !matches!(
            self,
            Self::Precision(_)
                | Self::Recall(_)
                | Self::Intervals
                | Self::IntervalsBack
                | Self::Events
                | Self::Bits
        )
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Precision(t) => write!(f, "precision within {}", Short(*t)),
            Self::Recall(t) => write!(f, "recall within {}", Short(*t)),
            Self::F1(t) => write!(f, "F1 within {}", Short(*t)),
            Self::VanRossum(t) => write!(f, "van Rossum, {}", Short(*t)),
            Self::VictorPurpura(t) => write!(f, "Victor-Purpura, {}", Short(*t)),
            Self::VoxelL1 => f.write_str("voxel L1"),
            Self::VoxelL1SignsApart => f.write_str("voxel L1, signs apart"),
            Self::VoxelRmse => f.write_str("voxel RMSE, events"),
            Self::CountPearson => f.write_str("counts, Pearson"),
            Self::CountL1 => f.write_str("counts, L1"),
            Self::RatePearson => f.write_str("rate map, Pearson"),
            Self::RateL1 => f.write_str("rate map, L1"),
            Self::SignedRatePearson => f.write_str("signed map, Pearson"),
            Self::SignedRateL1 => f.write_str("signed map, L1"),
            Self::Intervals => f.write_str("interval divergence"),
            Self::IntervalsBack => f.write_str("  the other way"),
            Self::Events => f.write_str("events, ratio"),
            Self::Bits => f.write_str("bits"),
        }
    }
}

/// A time in the largest unit that keeps it whole: `1us`, `10ms`.
struct Short(Micros);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.0 {
            us if us > 0 && us.is_multiple_of(1_000_000) => write!(f, "{}s", us / 1_000_000),
            us if us > 0 && us.is_multiple_of(1_000) => write!(f, "{}ms", us / 1_000),
            us => write!(f, "{us}us"),
        }
    }
}

/// One metric: its value, and what it would be for packets whose answer is known. None where
/// the metric has no value there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Which.
    pub metric: Metric,
    /// Of the judged packet.
    pub value: Option<f64>,
    /// Of the reference against itself.
    pub identical: Option<f64>,
    /// Of redraws of the reference: right places, times by accident.
    pub redraw: Option<f64>,
    /// Of permutations of the reference: right times, wrong places.
    pub permuted: Option<f64>,
}

impl Score {
    /// How far the value has gone from the identical packet, at 0, to the redraw, at 1. None
    /// where the metric cannot tell these apart.
    #[must_use]
    pub fn lost(&self) -> Option<f64> {
        let (from, to) = (self.identical?, self.redraw?);
        let lost = (self.value? - from) / (to - from);
        (self.metric.knows_a_redraw() && to != from).then_some(lost)
    }
}

/// Scores every metric.
#[must_use]
pub fn scores(pair: &Pair, scales: &Scales) -> Vec<Score> {
    let bins = Bins::over(pair, scales.bins);
    let value = measure(pair, scales, bins);
    let identical = measure(&pair.identical(), scales, bins);
    let draws = (200_000 / pair.events()[0].max(1)).clamp(1, 16);
    let mean = |draw: fn(&Pair, u64) -> Pair| {
        let all: Vec<_> = (0..draws)
            .map(|k| measure(&draw(pair, scales.seed.wrapping_add(k)), scales, bins))
            .collect();
        move |i: usize| {
            let sum: Option<f64> = all.iter().map(|draw| draw.get(i)?.1).sum();
            sum.map(|sum| sum / draws as f64)
        }
    };
    let (redraw, permuted) = (mean(null::redraw), mean(null::permute));
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

/// Every metric of one pair, always in the same order.
#[must_use]
pub fn measure(pair: &Pair, scales: &Scales, bins: Bins) -> Vec<(Metric, Option<f64>)> {
    let [a, b] = pair.events();
    let mut all = Vec::new();
    for &within in &scales.within {
        let matched = matched(pair, within);
        all.push((Metric::F1(within), Some(share(2 * matched, a + b))));
        all.push((Metric::Precision(within), Some(share(matched, b))));
        all.push((Metric::Recall(within), Some(share(matched, a))));
    }
    for &tau in &scales.van_rossum {
        let distance = van_rossum::distance(pair, tau);
        all.push((Metric::VanRossum(tau), Some(distance)));
    }
    for &h in &scales.victor_purpura {
        let distance = victor_purpura::distance(pair, h);
        all.push((Metric::VictorPurpura(h), Some(distance)));
    }
    let voxels = voxel::voxels(pair, bins);
    let cells = counts::cells(pair);
    let rates = rates::rates(pair);
    let intervals = intervals::divergence(pair);
    let word = AddressWord::of(pair.size(), pair.channels());
    all.extend([
        (Metric::VoxelL1, Some(voxels.l1)),
        (Metric::VoxelL1SignsApart, Some(voxels.l1_signs_apart)),
        (Metric::VoxelRmse, Some(voxels.rmse)),
        (Metric::CountPearson, cells.pearson),
        (Metric::CountL1, Some(pair.per_event(cells.l1 as f64 / 2.0))),
        (Metric::RatePearson, rates.unsigned.pearson),
        (Metric::RateL1, Some(rates.unsigned.l1)),
        (Metric::SignedRatePearson, rates.signed.pearson),
        (Metric::SignedRateL1, Some(rates.signed.l1)),
        (Metric::Intervals, intervals.map(|d| d.forward)),
        (Metric::IntervalsBack, intervals.map(|d| d.back)),
        (Metric::Events, (a > 0).then(|| b as f64 / a as f64)),
        (Metric::Bits, Some(b as f64 * f64::from(word.bits()))),
    ]);
    all
}
