//! Cost: what running a model takes, from times that were measured once and are kept as data.

use serde::Deserialize;

use crate::{number::Format, reference::Description};

use super::{
    bounds::{Bounds, Choice},
    effect::Effect,
};

/// Measured times.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Costs {
    /// How they were measured, and on what.
    pub source: String,
    /// How well they are known.
    pub evidence: String,
    /// Of all of them.
    pub unit: String,
    low_pass: f64,
    cell: ByFormat,
    tap: ByFormat,
    refractory: f64,
    mismatch: f64,
    strays: f64,
    jitter: f64,
    sheet: f64,
    settling: f64,
    sheet_noise: f64,
    event: f64,
    readout: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct ByFormat {
    f64: f64,
    f32: f64,
    other: f64,
}

impl ByFormat {
    const fn of(self, format: Format) -> f64 {
        match format {
            Format::F64 => self.f64,
            Format::F32 => self.f32,
            Format::F16 | Format::Bf16 | Format::Fixed(_) => self.other,
        }
    }
}

impl Costs {
    /// Those that come with the program.
    ///
    /// # Errors
    /// When the file that was built in is not what it should be.
    pub fn shipped() -> Result<Self, toml::de::Error> {
        toml::from_str(include_str!("costs.toml"))
    }

    /// Seconds that one core needs for a model, about.
    #[must_use]
    pub fn seconds(&self, bounds: &Bounds, choice: &Choice) -> f64 {
        let has = |present: bool, effect: Effect| present && !choice.leaves_out(effect);
        let present = bounds.present;
        let light = &bounds.light;
        let frames = if bounds.upsampled && choice.leaves_out(Effect::Upsampling) {
            light.frames as f64
        } else {
            light.upsampled
        };
        let pixels = match bounds.window() {
            Some((rows, columns)) if choice.leaves_out(Effect::Surroundings) => {
                rows.len() * columns.len()
            }
            _ => light.size.pixels(),
        };
        let mut pixel = 0.0;
        if has(present.low_pass, Effect::LowPass) {
            pixel += self.low_pass;
        }
        for channel in &bounds.description.channels {
            pixel += self.cell.of(choice.format);
            if let Some(surrounds) = &channel.surrounds {
                for sheet in &surrounds.sheets {
                    pixel += self.sheet;
                    if has(sheet.tau > 0.0, Effect::Settling) {
                        pixel += self.settling;
                    }
                    if has(sheet.noise > 0.0, Effect::SheetNoise) {
                        pixel += self.sheet_noise;
                    }
                }
            } else {
                let taps = channel.kernels.iter().map(|k| k.weights().len());
                pixel += self.tap.of(choice.format) * taps.max().unwrap_or(1) as f64;
            }
            for (present, effect, cost) in [
                (present.dead_time, Effect::Refractory, self.refractory),
                (present.mismatch, Effect::Mismatch, self.mismatch),
                (present.strays, Effect::Strays, self.strays),
                (present.jitter, Effect::Jitter, self.jitter),
            ] {
                if has(present, effect) {
                    pixel += cost;
                }
            }
        }
        let mut event = self.event;
        if has(bounds.readout.is_some(), Effect::Readout) {
            event += self.readout;
        }
        let pairs = (frames - 1.0).max(0.0);
        1e-9 * (pixel * pixels as f64 * pairs + event * bounds.events())
    }
}

/// A description without what a choice does without; the format and the scene are others' work.
#[must_use]
pub fn plainer(description: &Description, choice: &Choice) -> Description {
    let mut plain = description.clone();
    for effect in &choice.without {
        match effect {
            Effect::Strays => {
                (plain.noise.shot_hz, plain.noise.hot_hz) = (0.0, 0.0);
                plain.noise.hot_fraction = 0.0;
            }
            Effect::Jitter => plain.noise.jitter_us = 0.0,
            Effect::Refractory => plain.refractory.us = 0.0,
            Effect::LowPass => plain.noise.cutoff_hz = 0.0,
            Effect::Settling => {
                let channels = plain.channels.iter_mut();
                let surrounds = channels.filter_map(|c| c.surrounds.as_mut());
                for sheet in surrounds.flat_map(|s| &mut s.sheets) {
                    sheet.tau = 0.0;
                }
            }
            Effect::SheetNoise => {
                let channels = plain.channels.iter_mut();
                let surrounds = channels.filter_map(|c| c.surrounds.as_mut());
                for sheet in surrounds.flat_map(|s| &mut s.sheets) {
                    sheet.noise = 0.0;
                }
            }
            Effect::Mismatch => {
                let channels = plain.channels.iter_mut();
                for threshold in channels.flat_map(|c| &mut c.thresholds) {
                    threshold.sigma = 0.0;
                }
            }
            Effect::Surroundings | Effect::Readout | Effect::Upsampling => {}
        }
    }
    plain
}
