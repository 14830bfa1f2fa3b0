//! Noise: what disturbs a cell. Each is off by default; each is a hash of
//! (seed, reason, channel, pixel, pair), so the same seed gives the same events in any order
//! of work.
//!
//! | key of `[noise]` | unit | what it does | rate on a still scene |
//! |---|---|---|---|
//! | `leak-hz` | events/s | the memory falls by `leak-hz θ_on` each second (junction leakage of the reset switch; Nozaki & Delbruck, IEEE TED 64:3239, 2017) | `leak-hz` ON events per cell |
//! | `leak-spread` | decades | each cell's own leak: log-normal with this standard deviation, median `leak-hz` | `leak-hz exp((ln 10 leak-spread)² / 2)` |
//! | `shot-hz` | events/s | noise events in the dark, half ON half OFF, a Poisson process in each cell | `shot-hz` |
//! | `shot-at-white` | - | the share of it that is left at light 255; a straight line between, constant above | `shot-hz (1 + (shot-at-white - 1) I / 255)` |
//! | `hot-fraction`, `hot-hz` | -, events/s | this share of the cells fires ON at this rate instead, a Poisson process, whatever it sees | `hot-fraction hot-hz` per cell |
//! | `jitter-us` | us | the events of a cell in a pair move together by a normal draw, reflected at the pair's frames | |
//! | `cutoff-hz` | Hz | the photoreceptor is a first-order low-pass whose bandwidth grows with light, `cutoff-hz (I + 20) / 275` (v2e's law) | |
//!
//! The threshold's own mismatch is `sigma` of a channel's `threshold`.
//!
//! **Leak.** Cells do not start in step: each has leaked for a part of its first interval
//! already, uniformly drawn, as in a sensor that has been on for long. The mean count in a
//! time `T` is then exactly `leak-hz T`.
//!
//! **Shot noise and hot pixels** leave the memory alone. Under a dead time a cell is deaf to
//! them for that time after each of its events, and they give way to an event of the scene
//! that follows within it in the same pair of frames.
//!
//! **Low-pass.** The light of a frame is held since the frame before, so a step is followed as
//! `1 - exp(-2π f t)` at any frame rate. It starts settled.
//!
//! v2e's rules are known to be faulty in places, and are not copied: its shot events reset the
//! memory to the photoreceptor's value even where the memory holds something else, come at
//! most once a frame and are stamped with the frame's end; its leak starts in step in all
//! cells; its low-pass is an Euler step that has to be clipped.

use std::ops::Range;

use ndarray::ArrayView1;
use serde::Deserialize;

use crate::{
    elementary,
    number::Real,
    plane::{Plane, Size},
    scene::Frame,
    sensor::SensorError,
};

use super::{
    description::{Description, MemoryRule, RefractoryRule, Threshold},
    hash::{Place, Why},
    train::Train,
};

/// What disturbs the cells of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Noise {
    /// ON events a second that leakage makes in a cell.
    pub leak_hz: f64,
    /// Standard deviation of the cells' leak rates, in decades.
    pub leak_spread: f64,
    /// Shot noise events a second in a cell in the dark, ON and OFF together.
    pub shot_hz: f64,
    /// The share of them that is left at light 255, 0 to 1.
    pub shot_at_white: f64,
    /// Share of cells that are hot, 0 to 1.
    pub hot_fraction: f64,
    /// Events a second of a hot cell.
    pub hot_hz: f64,
    /// Standard deviation of the events' times, in microseconds.
    pub jitter_us: f64,
    /// Bandwidth of the photoreceptor at light 255, in hertz; 0 for no limit.
    pub cutoff_hz: f64,
}

/// A key of `[noise]` that cannot have its value.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) key: &'static str,
    pub(super) message: String,
    pub(super) advice: String,
}

impl Default for Noise {
    fn default() -> Self {
        Self::NONE
    }
}

/// The light at which `shot-at-white` holds: white in 8-bit video.
const WHITE: f64 = 255.0;

/// A cell that fires more often than once a microsecond has no times.
const FASTEST: f64 = 1e6;

impl Noise {
    /// No noise.
    pub const NONE: Self = Self {
        leak_hz: 0.0,
        leak_spread: 0.0,
        shot_hz: 0.0,
        shot_at_white: 1.0,
        hot_fraction: 0.0,
        hot_hz: 0.0,
        jitter_us: 0.0,
        cutoff_hz: 0.0,
    };

    /// Says what is wrong with these values under these rules.
    pub(super) fn check(self, memory: MemoryRule, refractory: RefractoryRule) -> Result<(), Fault> {
        let anything = f64::INFINITY;
        let all = [
            ("leak-hz", self.leak_hz, FASTEST),
            ("leak-spread", self.leak_spread, 3.0),
            ("shot-hz", self.shot_hz, FASTEST),
            ("shot-at-white", self.shot_at_white, 1.0),
            ("hot-fraction", self.hot_fraction, 1.0),
            ("hot-hz", self.hot_hz, FASTEST),
            ("jitter-us", self.jitter_us, anything),
            ("cutoff-hz", self.cutoff_hz, anything),
        ];
        for (name, value, most) in all {
            if !(value >= 0.0 && value <= most && value.is_finite()) {
                let range = if most == anything {
                    "zero or a positive number".to_owned()
                } else {
                    format!("a number from 0 to {most}")
                };
                return Err(Fault {
                    key: name,
                    message: format!("noise.{name} is {value}"),
                    advice: format!("give {range}; docs/reference.md has its unit"),
                });
            }
        }
        let leaks = self.leak_hz > 0.0;
        let fault = |message: &str, advice: &str| Fault {
            key: "leak-hz",
            message: message.to_owned(),
            advice: advice.to_owned(),
        };
        let pixels = matches!(memory, MemoryRule::RawSnap | MemoryRule::AuthorsPixelStep);
        if pixels && leaks {
            return Err(fault(
                "noise.leak-hz counts thresholds of the filtered signal, and this memory holds pixels",
                "use memory = \"filtered-snap\" or \"filtered-step\", or leave the leak out",
            ));
        }
        if refractory == RefractoryRule::Authors && leaks {
            return Err(fault(
                "noise.leak-hz moves the memory between frames, which the authors' refractory rule does not know",
                "use rule = \"dead-time\", or leave the leak out",
            ));
        }
        Ok(())
    }

    /// Whether cells fire for other reasons than what they see.
    #[must_use]
    pub fn fires(&self) -> bool {
        self.shot_hz > 0.0 || (self.hot_hz > 0.0 && self.hot_fraction > 0.0)
    }

    /// How far the memory of a cell falls in a second, in the unit of its threshold.
    pub(super) fn leak(&self, place: Place, threshold: f64) -> f64 {
        let spread = if self.leak_spread > 0.0 {
            elementary::pow(10f64, self.leak_spread * place.normal(Why::LeakRate, 0))
        } else {
            1.0
        };
        self.leak_hz * spread * threshold
    }

    /// How much of a threshold a cell has leaked before its first frame.
    pub(super) fn leaked(place: Place) -> f64 {
        place.uniform(Why::LeakPhase, 0)
    }

    /// The share of shot noise that is left in this light, 0 to 1; linear up to light 255.
    #[must_use]
    pub fn shot_share(&self, light: f64) -> f64 {
        1.0 + (self.shot_at_white - 1.0) * (light / WHITE).clamp(0.0, 1.0)
    }

    /// Moves a train by the cell's jitter, reflected so that it stays within the pair.
    pub(super) fn jitter(&self, train: Train, place: Place, pair: u64, dt: f64) -> Train {
        let shift = self.jitter_us * 1e-6 / dt * place.normal(Why::Jitter, pair);
        let room = 1.0 - (train.last() - train.first);
        let first = if room > 0.0 {
            let folded = (train.first + shift).rem_euclid(2.0 * room);
            folded.min(2.0 * room - folded)
        } else {
            0.0
        };
        Train { first, ..train }
    }

    /// How much of the way to its input a photoreceptor goes in `dt` seconds, 0 to 1: the exact
    /// first-order low-pass with v2e's bandwidth, `cutoff-hz (light + 20) / 275`.
    #[must_use]
    pub fn low_pass(&self, light: f64, dt: f64) -> f64 {
        let bandwidth = self.cutoff_hz * (light.max(0.0) + 20.0) / 275.0;
        -elementary::exp_m1(-std::f64::consts::TAU * bandwidth * dt)
    }
}

/// Photoreceptors that take their time: a first-order low-pass for each pixel, settled at the
/// first frame.
#[derive(Clone, Debug)]
pub(super) struct LowPass {
    state: Plane<f64>,
}

impl LowPass {
    pub(super) fn new(size: Size) -> Self {
        Self {
            state: Plane::zeros(size.shape()),
        }
    }

    /// Moves towards the response to `frame`, `dt` seconds after the last (infinite at first).
    pub(super) fn see(
        &mut self,
        description: &Description,
        frame: &Frame,
        dt: f64,
    ) -> Result<(), SensorError> {
        for ((y, x), state) in self.state.indexed_iter_mut() {
            let light = frame.light[[y, x]];
            let index = frame.index;
            let signal = description.response.apply(light);
            let signal = signal.map_err(|cause| SensorError::Light { index, y, x, cause })?;
            *state += description.noise.low_pass(light, dt) * (signal - *state);
        }
        Ok(())
    }

    /// Row `y` of the filtered signal.
    pub(super) fn row(&self, y: usize) -> ArrayView1<'_, f64> {
        self.state.row(y)
    }
}

/// The thresholds of one channel: the nominal ones, and what silicon made of them.
///
/// A fixed pattern: each pixel keeps its own as long as the sensor lives (the released
/// simulator draws anew for each clip). No threshold falls below a twentieth of its nominal
/// value, the released simulator's 0.01 at its 0.2.
#[derive(Clone, Debug)]
pub(super) struct Thresholds<R> {
    on: Vec<R>,
    off: Vec<R>,
    /// One by each.
    inverse: (Vec<R>, Vec<R>),
    width: usize,
    /// How many different rows there are: 1, 2 for a 2x2 pattern, or all.
    rows: usize,
    pub(super) equal: bool,
}

impl<R: Real> Thresholds<R> {
    pub(super) fn new(nominal: &[Threshold], size: Size, seed: u64, channel: usize) -> Self {
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
            let place = Place {
                seed,
                channel,
                y,
                x,
            };
            let draw =
                |why, value: f64| (value + mean.sigma * place.normal(why, 0)).max(value / 20.0);
            if mean.sigma > 0.0 {
                (
                    R::from_f64(draw(Why::ThresholdOn, mean.on)),
                    R::from_f64(draw(Why::ThresholdOff, mean.off)),
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
    pub(super) fn row(&self, y: usize) -> (&[R], &[R]) {
        let row = self.place(y);
        (&self.on[row.clone()], &self.off[row])
    }

    /// One by each of them.
    pub(super) fn inverse(&self, y: usize) -> (&[R], &[R]) {
        let row = self.place(y);
        (&self.inverse.0[row.clone()], &self.inverse.1[row])
    }

    fn place(&self, y: usize) -> Range<usize> {
        let start = y % self.rows * self.width;
        start..start + self.width
    }
}
