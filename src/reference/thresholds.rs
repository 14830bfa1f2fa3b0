//! The thresholds of every cell of a channel, with the mismatch of its transistors.

use crate::{
    number::{Number, Real},
    plane::Size,
    sensor::SensorError,
};

use super::{
    description::{Description, Threshold},
    reason::{Place, Reason},
};

/// The least that mismatch leaves of a threshold.
pub(crate) const fn least(nominal: f64) -> f64 {
    nominal / 20.0
}

impl Description {
    /// Whether thresholds can be counted in this format: by their reciprocals, where a memory steps.
    pub(super) fn check_countable<N: Number>(&self, number: &N) -> Result<(), SensorError> {
        if !self.memory.crosses_levels() {
            return Ok(());
        }
        let is_counted = |threshold: f64| {
            let per = N::Real::ONE / N::Real::from_f64(threshold);
            per.to_f64().is_finite()
        };
        // A little more than one over the largest number.
        let is_wide = N::Real::from_f64(1e300).to_f64().is_finite();
        let countable = if is_wide { 6e-309 } else { 3e-39 };
        for (channel, kind) in self.channels.iter().enumerate() {
            for it in &kind.thresholds {
                let threshold = it.on.min(it.off);
                // What mismatch may leave of one.
                let part = if it.sigma > 0.0 { least(1.0) } else { 1.0 };
                if !is_counted(threshold * part) {
                    return Err(SensorError::Threshold {
                        channel,
                        threshold,
                        least: countable / part,
                        format: number.format(),
                    });
                }
            }
        }
        Ok(())
    }
}

/// The thresholds of one channel: the nominal ones and their mismatch.
///
/// The mismatch is a fixed pattern: each pixel keeps its own as long as the sensor lives (the
/// released simulator draws anew for each clip). No threshold falls below a twentieth of its
/// nominal value, the released simulator's 0.01 at its 0.2.
#[derive(Clone, Debug)]
pub(crate) struct Thresholds<R> {
    on: Vec<R>,
    off: Vec<R>,
    /// Their reciprocals.
    inverse: (Vec<R>, Vec<R>),
    width: usize,
    /// Number of different rows: 1, 2 for a 2x2 pattern, or all.
    rows: usize,
    pub(crate) equal: bool,
}

impl<R: Real> Thresholds<R> {
    /// `home` is the place that a cell's numbers are drawn for.
    pub(crate) fn new(
        nominal: &[Threshold],
        size: Size,
        seed: u64,
        (channel, home): (usize, &dyn Fn(usize, usize) -> (usize, usize)),
    ) -> Self {
        let mismatch = nominal.iter().any(|t| t.sigma > 0.0);
        let rows = match nominal {
            _ if mismatch => size.height,
            [_] => 1,
            _ => 2,
        };
        let cells = (0..rows).flat_map(|y| (0..size.width).map(move |x| (y, x)));
        let drawn = |(y, x)| {
            let mean = match nominal {
                [one] => *one,
                four => four[2 * (y % 2) + x % 2],
            };
            let (y, x) = home(y, x);
            let place = Place {
                seed,
                channel,
                y,
                x,
            };
            let draw = |reason, value: f64| {
                (value + mean.sigma * place.normal(reason, 0)).max(least(value))
            };
            if mean.sigma > 0.0 {
                (
                    R::from_f64(draw(Reason::ThresholdOn, mean.on)),
                    R::from_f64(draw(Reason::ThresholdOff, mean.off)),
                )
            } else {
                (R::from_f64(mean.on), R::from_f64(mean.off))
            }
        };
        let (on, off): (Vec<R>, Vec<R>) = cells.map(drawn).unzip();
        let inverse = |of: &[R]| of.iter().map(|threshold| R::ONE / *threshold).collect();
        Self {
            equal: on == off,
            inverse: (inverse(&on), inverse(&off)),
            on,
            off,
            width: size.width,
            rows,
        }
    }

    /// The ON and OFF thresholds of row `y`.
    pub(crate) fn row(&self, y: usize) -> (&[R], &[R]) {
        let row = self.place(y);
        (&self.on[row.clone()], &self.off[row])
    }

    /// The reciprocals of the thresholds of row `y`.
    pub(crate) fn inverse(&self, y: usize) -> (&[R], &[R]) {
        let row = self.place(y);
        (&self.inverse.0[row.clone()], &self.inverse.1[row])
    }

    fn place(&self, y: usize) -> std::ops::Range<usize> {
        let start = y % self.rows * self.width;
        start..start + self.width
    }
}
