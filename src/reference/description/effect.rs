//! Effects of a sensor: what disturbs its cells or moves their events, each of which a run can leave
//! out.

use std::fmt;

use super::{Channel, Description, Refractory};
use crate::{
    config::listed,
    reference::{noise::Noise, surround::Surround},
};

listed! {
/// What can be left out of a run, besides the digits of a number format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// The rows and columns in which nothing ever changes.
    Surroundings = "surroundings",
    /// The frames inserted between those of the scene.
    InsertedFrames = "inserted-frames",
    /// The dead time after an event.
    DeadTime = "dead-time",
    /// Shot noise and hot pixels.
    NoiseEvents = "noise-events",
    /// The jitter of event times.
    Jitter = "jitter",
    /// The photoreceptors' bandwidth.
    Bandwidth = "bandwidth",
    /// The leak of the memories.
    Leak = "leak",
    /// The mismatch of the thresholds.
    Mismatch = "mismatch",
    /// The noise of the resistor sheets.
    MeshNoise = "mesh-noise",
}
}

impl Effect {
    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Surroundings => "still surroundings",
            Self::InsertedFrames => "inserted frames",
            Self::DeadTime => "dead time",
            Self::NoiseEvents => "shot noise, hot pixels",
            Self::Jitter => "jitter",
            Self::Bandwidth => "bandwidth",
            Self::Leak => "leak",
            Self::Mismatch => "threshold mismatch",
            Self::MeshNoise => "mesh noise",
        }
    }

    /// Those of the sensor alone, which any run can do without.
    pub fn of_sensors() -> impl Iterator<Item = Self> + Clone {
        let others = [Self::Surroundings, Self::InsertedFrames];
        Self::ALL
            .iter()
            .copied()
            .filter(move |effect| !others.contains(effect))
    }

    /// Those that `[noise]` states.
    #[must_use]
    pub fn of(noise: &Noise) -> Vec<Self> {
        let Noise {
            // By `fires`; how much of it there is in bright light.
            shot_hz: _,
            shot_at_white: _,
            hot_fraction: _,
            hot_hz: _,
            jitter_us,
            cutoff_hz,
            cutoff_rule: _,
            leak_hz,
            leak_spread: _,
        } = *noise;
        let all = [
            (Self::NoiseEvents, noise.fires()),
            (Self::Jitter, jitter_us > 0.0),
            (Self::Bandwidth, cutoff_hz > 0.0),
            (Self::Leak, leak_hz > 0.0),
        ];
        let there = all.into_iter().filter(|(_, is_there)| *is_there);
        there.map(|(effect, _)| effect).collect()
    }

    /// Whether a sensor has it; `inserts`: whether frames are inserted for it.
    #[must_use]
    pub fn is_in(self, description: &Description, inserts: bool) -> bool {
        match self {
            Self::Surroundings => false,
            Self::InsertedFrames => inserts,
            Self::DeadTime
            | Self::NoiseEvents
            | Self::Jitter
            | Self::Bandwidth
            | Self::Leak
            | Self::Mismatch
            | Self::MeshNoise => description.effects().contains(&self),
        }
    }

    /// Takes it out of a sensor.
    pub fn leave_out(self, plain: &mut Description) {
        match self {
            Self::DeadTime => plain.refractory.us = 0.0,
            Self::NoiseEvents => {
                (plain.noise.shot_hz, plain.noise.hot_hz) = (0.0, 0.0);
                plain.noise.hot_fraction = 0.0;
            }
            Self::Jitter => plain.noise.jitter_us = 0.0,
            Self::Bandwidth => plain.noise.cutoff_hz = 0.0,
            Self::Leak => plain.noise.leak_hz = 0.0,
            Self::Mismatch => {
                let channels = plain.channels.iter_mut();
                for threshold in channels.flat_map(|channel| &mut channel.thresholds) {
                    threshold.sigma = 0.0;
                }
            }
            Self::MeshNoise => {
                let sheets = plain.channels.iter_mut().flat_map(|it| &mut it.surrounds);
                for sheet in sheets.flat_map(|it| &mut it.sheets) {
                    sheet.noise = 0.0;
                }
            }
            // Not the sensor's.
            Self::Surroundings | Self::InsertedFrames => {}
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Description {
    /// The effects that it has, in the order of [`Effect::ALL`].
    #[must_use]
    pub fn effects(&self) -> Vec<Effect> {
        let Self {
            // What the sensor is.
            name: _,
            response: _,
            memory: _,
            shared: _,
            polarity: _,
            border: _,
            refractory,
            noise,
            channels,
        } = self;
        let Refractory { us, rule: _ } = refractory;
        let mut all = Effect::of(noise);
        if *us > 0.0 {
            all.push(Effect::DeadTime);
        }
        for channel in channels {
            let Channel {
                name: _,
                kernels: _,
                surrounds,
                thresholds,
                memory_kernel: _,
                log_temporal: _,
            } = channel;
            if thresholds.iter().any(|it| it.sigma > 0.0) {
                all.push(Effect::Mismatch);
            }
            let mut sheets = surrounds.iter().flat_map(|it| &it.sheets);
            if sheets.any(|Surround { noise, .. }| *noise > 0.0) {
                all.push(Effect::MeshNoise);
            }
        }
        all.sort_unstable();
        all.dedup();
        all
    }
}
