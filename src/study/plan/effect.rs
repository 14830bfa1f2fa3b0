//! Effect: what can be left out of a model, and what has to go with it.

use std::fmt;

use crate::{
    photoreceptor::Curve,
    reference::{Description, MemoryRule, RefractoryRule, SheetRule},
};

/// What can be left out, besides the digits of a number format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// The rows and columns in which nothing ever changes.
    Surroundings,
    /// The readout between the cells and the packet.
    Readout,
    /// Shot noise and hot pixels.
    Strays,
    /// The jitter of event times.
    Jitter,
    /// The dead time after an event.
    Refractory,
    /// The frames inserted between those of the scene.
    Upsampling,
    /// The photoreceptors' bandwidth.
    LowPass,
    /// The time that resistor sheets take to settle.
    Settling,
    /// The noise of the resistor sheets.
    SheetNoise,
    /// The mismatch of the thresholds.
    Mismatch,
}

impl Effect {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Surroundings,
        Self::Readout,
        Self::Strays,
        Self::Jitter,
        Self::Refractory,
        Self::Upsampling,
        Self::LowPass,
        Self::Settling,
        Self::SheetNoise,
        Self::Mismatch,
    ];

    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Surroundings => "still surroundings",
            Self::Readout => "readout",
            Self::Strays => "shot noise, hot pixels",
            Self::Jitter => "jitter",
            Self::Refractory => "dead time",
            Self::Upsampling => "inserted frames",
            Self::LowPass => "bandwidth",
            Self::Settling => "settling of the mesh",
            Self::SheetNoise => "noise of the mesh",
            Self::Mismatch => "threshold mismatch",
        }
    }

    /// Whether it moves drives or thresholds a little, and nothing else.
    #[must_use]
    pub const fn perturbs(self) -> bool {
        match self {
            Self::Upsampling
            | Self::LowPass
            | Self::Settling
            | Self::SheetNoise
            | Self::Mismatch => true,
            Self::Surroundings | Self::Readout | Self::Strays | Self::Jitter | Self::Refractory => {
                false
            }
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a sensor file and a way to run it have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is there or not, whatever the others are"
)]
pub struct Present {
    /// Shot noise or hot pixels.
    pub strays: bool,
    /// Jitter.
    pub jitter: bool,
    /// A dead time.
    pub dead_time: bool,
    /// A photoreceptor of finite bandwidth.
    pub low_pass: bool,
    /// Leaking memories.
    pub leak: bool,
    /// Thresholds with a mismatch.
    pub mismatch: bool,
    /// Resistor sheets.
    pub sheets: bool,
    /// Sheets that take their time.
    pub settling: bool,
    /// Sheets with noise.
    pub sheet_noise: bool,
    /// A memory whose cells can be followed: it holds the filtered signal and steps, and what a
    /// dead time takes does not come back.
    pub followed: bool,
    /// Light that a straight line in time makes a straight line of drive: a sheet's noise is
    /// drawn anew for each frame.
    pub straight: bool,
    /// v2e's sheets, which stop early.
    pub v2e: bool,
}

impl Present {
    /// What a sensor file has.
    #[must_use]
    pub fn of(description: &Description) -> Self {
        let noise = description.noise;
        let channels = &description.channels;
        let sheets = || {
            let surrounds = channels.iter().filter_map(|c| c.surrounds.as_ref());
            surrounds.flat_map(|s| s.sheets.iter().map(move |sheet| (s.rule, sheet)))
        };
        let thresholds = || channels.iter().flat_map(|c| &c.thresholds);
        let response = description.response;
        let straight = matches!(response.curve, Curve::Identity | Curve::Linear { .. })
            && !response.round_f32
            && channels.iter().all(|c| !c.log_temporal)
            && sheets().all(|(_, sheet)| sheet.tau <= 0.0 && sheet.noise <= 0.0)
            && noise.cutoff_hz <= 0.0;
        Self {
            strays: noise.fires(),
            jitter: noise.jitter_us > 0.0,
            dead_time: description.refractory.us > 0.0,
            low_pass: noise.cutoff_hz > 0.0,
            leak: noise.leak_hz > 0.0,
            mismatch: thresholds().any(|t| t.sigma > 0.0),
            sheets: sheets().next().is_some(),
            settling: sheets().any(|(_, sheet)| sheet.tau > 0.0),
            sheet_noise: sheets().any(|(_, sheet)| sheet.noise > 0.0),
            followed: description.memory == MemoryRule::FilteredStep
                && description.refractory.rule == RefractoryRule::DeadTime,
            straight,
            v2e: sheets().any(|(rule, _)| rule == SheetRule::V2e),
        }
    }

    /// What has to be left out as well, if `effect` is (a format other than f64 for `None`).
    ///
    /// Stray events and scene events silence each other in a dead time, and shot noise sees the
    /// signal. Jitter moves the events of a cell and pair as one train, so that one event more
    /// moves all. What is drawn at random is drawn at a pixel's place.
    #[must_use]
    pub fn needs(&self, effect: Option<Effect>) -> Vec<Effect> {
        let with = |all: &[(bool, Effect)]| {
            let needed = all.iter().filter(|(present, _)| *present);
            needed.map(|(_, effect)| *effect).collect()
        };
        match effect {
            Some(Effect::Readout | Effect::Strays) => Vec::new(),
            Some(Effect::Jitter) => with(&[(self.strays && self.dead_time, Effect::Strays)]),
            Some(Effect::Surroundings) => with(&[
                (self.strays, Effect::Strays),
                (self.jitter, Effect::Jitter),
                (self.mismatch, Effect::Mismatch),
            ]),
            // A sheet's noise goes with its time constant.
            Some(Effect::Settling) => with(&[
                (self.strays, Effect::Strays),
                (self.jitter, Effect::Jitter),
                (self.sheet_noise, Effect::SheetNoise),
            ]),
            Some(
                Effect::Refractory
                | Effect::Upsampling
                | Effect::LowPass
                | Effect::SheetNoise
                | Effect::Mismatch,
            )
            | None => with(&[(self.strays, Effect::Strays), (self.jitter, Effect::Jitter)]),
        }
    }
}
