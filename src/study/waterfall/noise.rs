//! What noise alone does, and what a designer can do about it.
//!
//! A memory that snaps takes what a noisy drive was when the cell fired. Each frame is one more
//! chance that noise carries the drive past the threshold, so the more frames a second, the more
//! events a second noise makes, while the scene makes no more than before. Two things help: a
//! threshold of more sigmas of the noise, and fewer decisions a second.

use serde::Serialize;

use super::Fall;
use crate::{compile::FilterNoise, elementary};

/// Noise events for each of the float sensor's that a design should stay below.
pub(super) const LIMIT: f64 = 0.1;

/// Noise alone at one frame rate: measured on a still picture, with no other error of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NoiseAtRate {
    /// Events a second of the whole sensor.
    pub events_per_second: f64,
    /// For each event of the float sensor on the scene.
    pub share: f64,
}

/// The threshold in sigmas of the noise, and what would help.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Noise {
    /// Noise of a result from frame to frame, LSB: the compiler's prediction, to first order.
    pub temporal_lsb: f64,
    /// The threshold, LSB.
    pub threshold_lsb: f64,
    /// The threshold over the noise of a difference of two results; none without noise.
    pub sigmas: Option<f64>,
    /// Noise events for each of the float sensor's that a design should stay below.
    pub limit: f64,
    /// The frame rate up to which it does; none where it does at all rates that were shown.
    pub fps_below: Option<f64>,
    /// The threshold, in kernel times light, at which it would at the fastest rate that was
    /// shown; none where none is needed, or none can be told.
    pub threshold_for_fastest: Option<f64>,
}

impl Noise {
    /// Of what was measured: frames a second and events a second, of slow to fast.
    pub(super) fn new(
        fall: &Fall<'_>,
        measured: &[(f64, f64)],
        reference_per_second: f64,
        pixels: usize,
    ) -> Self {
        let device = &fall.program().expanded.device;
        let filter = fall.kinds.filter(fall.kind);
        let noise = filter.noise(device, FilterNoise::MIDDLE);
        let own = fall.kind.min(noise.len().saturating_sub(1));
        let temporal = noise.get(own).map_or(0.0, |noise| noise.temporal);
        let threshold_lsb = fall.threshold_lsb();
        let most = LIMIT * reference_per_second;
        let threshold = fall.question.design.threshold;
        Self {
            temporal_lsb: temporal,
            threshold_lsb,
            // A decision takes the difference of two results.
            sigmas: (temporal > 0.0).then(|| threshold_lsb / (2_f64.sqrt() * temporal)),
            limit: LIMIT,
            fps_below: below(measured, most),
            threshold_for_fastest: { measured.last() }
                .filter(|(_, events)| *events > most)
                .and_then(|(fps, events)| {
                    let decisions = fps * pixels as f64;
                    let (now, then) = (sigmas(events / decisions)?, sigmas(most / decisions)?);
                    Some(threshold * then / now)
                }),
        }
    }
}

/// Up to which rate there are at most so many events a second; none where there are at all.
/// Below the slowest rate they are taken to be as many for each frame as there.
fn below(measured: &[(f64, f64)], most: f64) -> Option<f64> {
    let above = measured.iter().position(|(_, events)| *events > most)?;
    let (fps, events) = *measured.get(above)?;
    let (slower, fewer) = match above.checked_sub(1).and_then(|i| measured.get(i)) {
        Some(before) => *before,
        None => (0.0, 0.0),
    };
    Some(slower + (fps - slower) * (most - fewer) / (events - fewer))
}

/// How many sigmas a normal number is from its mean, to either side, with this probability; none
/// where that is no distance. Within 0.0005 (Abramowitz and Stegun 26.2.23).
fn sigmas(probability: f64) -> Option<f64> {
    if !(probability > 0.0 && probability < 0.9) {
        return None;
    }
    let t = (-2.0 * elementary::ln(probability / 2.0)).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    Some(t - above / below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sigmas_are_those_of_the_tables() {
        for (k, outside) in [(1.0, 0.317_311), (2.0, 0.045_500), (3.0, 0.002_700)] {
            let found = sigmas(outside).unwrap();
            assert!((found - k).abs() < 1e-3, "{found} for {k}");
        }
        assert_eq!([sigmas(0.0), sigmas(1.0)], [None, None]);
    }

    #[test]
    fn the_rate_below_a_limit_lies_between_those_on_both_sides() {
        let measured = [(10.0, 100.0), (20.0, 300.0), (40.0, 900.0)];
        assert_eq!(below(&measured, 200.0), Some(15.0));
        assert_eq!(below(&measured, 50.0), Some(5.0));
        assert_eq!(below(&measured, 300.0), Some(20.0));
        assert_eq!(below(&measured, 900.0), None);
    }
}
