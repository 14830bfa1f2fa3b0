//! Noise: what disturbs a cell. Each is off by default, and each is a hash of
//! (seed, kind, channel, pixel, step), so the same seed gives the same events in any order
//! of work.

use serde::Deserialize;

use crate::plane::{Plane, Size};

use super::description::{Memory, RefractoryRule, Threshold};

/// What disturbs the cells of a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Noise {}

impl Noise {
    /// No noise.
    pub const NONE: Self = Self {};

    /// Says what is wrong with these values under these rules.
    pub(super) fn check(self, _: Memory, _: RefractoryRule) -> Result<(), String> {
        Ok(())
    }
}

/// Kinds of draws, so that no two share their numbers.
#[derive(Clone, Copy)]
enum Kind {
    ThresholdOn = 1,
    ThresholdOff = 2,
}

/// A uniform number in [0, 1) from where and why it is drawn.
fn uniform(seed: u64, kind: Kind, channel: usize, y: usize, x: usize, step: u64) -> f64 {
    let place = ((channel as u64) << 48) | ((y as u64) << 24) | x as u64;
    let mut h = seed;
    for part in [kind as u64, place, step] {
        h = mix(h ^ mix(part.wrapping_add(0x9E37_79B9_7F4A_7C15)));
    }
    (h >> 11) as f64 / (1u64 << 53) as f64
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A standard normal number, by Box and Muller.
fn normal(seed: u64, kind: Kind, channel: usize, y: usize, x: usize, step: u64) -> f64 {
    let u = 1.0 - uniform(seed, kind, channel, y, x, 2 * step);
    let v = uniform(seed, kind, channel, y, x, 2 * step + 1);
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// The thresholds of one channel: the nominal ones, and what silicon made of them.
///
/// A fixed pattern: each pixel keeps its own as long as the sensor lives (the released
/// simulator draws anew for each clip). No threshold falls below a twentieth of its nominal
/// value, the released simulator's 0.01 at its 0.2.
#[derive(Clone, Debug)]
pub(super) struct Mismatch {
    nominal: Vec<Threshold>,
    own: Option<Plane<Threshold>>,
}

impl Mismatch {
    pub(super) fn new(nominal: &[Threshold], size: Size, seed: u64, channel: usize) -> Self {
        let nominal = nominal.to_vec();
        let own = nominal.iter().any(|t| t.sigma > 0.0).then(|| {
            Plane::from_shape_fn(size.shape(), |(y, x)| {
                let mean = pick(&nominal, y, x);
                let drawn = |kind, value: f64| {
                    (value + mean.sigma * normal(seed, kind, channel, y, x, 0)).max(value / 20.0)
                };
                Threshold {
                    on: drawn(Kind::ThresholdOn, mean.on),
                    off: drawn(Kind::ThresholdOff, mean.off),
                    sigma: mean.sigma,
                }
            })
        });
        Self { nominal, own }
    }

    /// The thresholds of one cell.
    pub(super) fn at(&self, y: usize, x: usize) -> Threshold {
        match &self.own {
            Some(own) => own[[y, x]],
            None => pick(&self.nominal, y, x),
        }
    }
}

fn pick(nominal: &[Threshold], y: usize, x: usize) -> Threshold {
    match nominal {
        [one] => *one,
        four => four[2 * (y % 2) + x % 2],
    }
}
