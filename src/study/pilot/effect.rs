//! What can be left out of the float model.

use std::fmt;

use crate::{config::listed, number::Format, reference::Description};

listed! {
/// What can be left out, besides the digits of a number format.
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

    /// Whether a sensor has it; `inserts`: whether frames are inserted for it.
    #[must_use]
    pub fn is_in(self, description: &Description, inserts: bool) -> bool {
        let noise = &description.noise;
        let channels = || description.channels.iter();
        let mut thresholds = channels().flat_map(|c| &c.thresholds);
        let mut sheets = channels()
            .flat_map(|c| &c.surrounds)
            .flat_map(|it| &it.sheets);
        match self {
            Self::Surroundings => false,
            Self::InsertedFrames => inserts,
            Self::DeadTime => description.refractory.us > 0.0,
            Self::NoiseEvents => noise.fires(),
            Self::Jitter => noise.jitter_us > 0.0,
            Self::Bandwidth => noise.cutoff_hz > 0.0,
            Self::Leak => noise.leak_hz > 0.0,
            Self::Mismatch => thresholds.any(|threshold| threshold.sigma > 0.0),
            Self::MeshNoise => sheets.any(|sheet| sheet.noise > 0.0),
        }
    }

    /// Takes it out of a sensor.
    fn leave_out(self, plain: &mut Description) {
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

/// What a model leaves out: the digits of its numbers, and effects.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Choice {
    /// The format of signals, weights and memory.
    pub format: Format,
    /// What it does without, in the order of [`Effect::ALL`].
    pub without: Vec<Effect>,
}

impl Choice {
    /// Nothing is left out.
    #[must_use]
    pub const fn full() -> Self {
        Self {
            format: Format::F64,
            without: Vec::new(),
        }
    }

    /// Whether it does without `effect`.
    #[must_use]
    pub fn leaves_out(&self, effect: Effect) -> bool {
        self.without.contains(&effect)
    }

    /// The same, without one effect more.
    #[must_use]
    pub fn and_without(mut self, effect: Effect) -> Self {
        self.without.push(effect);
        self.without.sort_unstable();
        self.without.dedup();
        self
    }

    /// The sensor without what the choice does without; the format and the scene are others' work.
    #[must_use]
    pub fn plainer(&self, description: &Description) -> Description {
        let mut plain = description.clone();
        for effect in &self.without {
            effect.leave_out(&mut plain);
        }
        plain
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let without: Vec<_> = self.without.iter().map(Effect::to_string).collect();
        if *self == Self::full() {
            f.write_str("the full model: nothing is left out")
        } else if without.is_empty() {
            self.format.fmt(f)
        } else {
            write!(f, "{}, without {}", self.format, without.join(", "))
        }
    }
}
