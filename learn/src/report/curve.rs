//! Quality over bits.

use amacrine::elementary;

use super::metric::Metric;
use crate::record::{Decoder, Form, Row};

/// One form of an arm over its targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Means over seeds and clips, a point a target, in order of their bits.
    pub points: Vec<Point>,
    /// Means over clips, a point a target and seed.
    pub runs: Vec<Point>,
}

/// Quality at a number of bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Events a pixel and pair that were asked for.
    pub target: f64,
    /// Events a pixel and pair.
    pub events: f64,
    /// Bits a pixel and pair, as address events.
    pub bits: f64,
    /// The mean of the metric.
    pub quality: f64,
}

/// The rows of an arm in one form, and how much each counts.
pub(super) type Weighted<'a> = Vec<(&'a Row, f64)>;

/// An arm in one form with one decoder.
pub(super) type Of<'a> = (&'a str, Form, Decoder);

/// Its rows.
pub(super) fn rows_of<'a>(rows: &'a [Row], (arm, form, decoder): Of<'_>) -> Vec<&'a Row> {
    let own = |row: &&Row| row.arm == arm && row.form == form && row.decoder == decoder;
    rows.iter().filter(own).collect()
}

impl Curve {
    pub(super) fn new(rows: &[Row], of: Of<'_>, metric: Metric) -> Self {
        let own = rows_of(rows, of);
        let all: Weighted<'_> = own.iter().map(|row| (*row, 1.0)).collect();
        let mut seeds: Vec<u64> = own.iter().map(|row| row.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        let of_seed = |seed: &u64| {
            let own: Weighted<'_> = all
                .iter()
                .filter(|(row, _)| row.seed == *seed)
                .copied()
                .collect();
            points(&own, metric)
        };
        Self {
            points: points(&all, metric),
            runs: seeds.iter().flat_map(of_seed).collect(),
        }
    }
}

/// A point for each target, in order of their bits.
pub(super) fn points(rows: &[(&Row, f64)], metric: Metric) -> Vec<Point> {
    let mut targets: Vec<f64> = rows.iter().map(|(row, _)| row.target).collect();
    targets.sort_by(f64::total_cmp);
    targets.dedup();
    let point = |target: f64| {
        let (mut bits, mut events, mut cells) = (0.0, 0.0, 0.0);
        let (mut sum, mut count) = (0.0, 0.0);
        for (row, weight) in rows.iter().filter(|(row, _)| row.target == target) {
            let Some(quality) = metric.of(row) else {
                continue;
            };
            bits += weight * row.bits as f64;
            events += weight * row.events as f64;
            cells += weight * row.cells as f64;
            sum += weight * quality;
            count += weight;
        }
        (count > 0.0 && cells > 0.0).then(|| Point {
            target,
            events: events / cells,
            bits: bits / cells,
            quality: sum / count,
        })
    };
    let mut points: Vec<Point> = targets.into_iter().filter_map(point).collect();
    points.sort_by(|a, b| a.bits.total_cmp(&b.bits));
    points
}

/// The ends of a curve on the logarithm of its bits; `None` without bits.
pub(super) fn ends(points: &[Point]) -> Option<(f64, f64)> {
    let (first, last) = (points.first()?, points.last()?);
    (first.bits > 0.0).then(|| (elementary::log2(first.bits), elementary::log2(last.bits)))
}

/// The quality at the logarithm of a number of bits: linear between points, that of the nearest
/// point beyond them.
pub(super) fn quality(points: &[Point], log_bits: f64) -> f64 {
    let at = |point: &Point| elementary::log2(point.bits);
    let above = points.partition_point(|point| at(point) < log_bits);
    match (
        above.checked_sub(1).map(|below| &points[below]),
        points.get(above),
    ) {
        (Some(low), Some(high)) => {
            let part = (log_bits - at(low)) / (at(high) - at(low));
            low.quality + part * (high.quality - low.quality)
        }
        (Some(one), None) | (None, Some(one)) => one.quality,
        (None, None) => f64::NAN,
    }
}
