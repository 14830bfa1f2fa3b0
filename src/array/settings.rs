//! What the sources leave open, by name, with a default; and how the work is done.

use std::fmt;

use super::{CodeProblem, Schedule};
use crate::isa::{Device, Figure};

/// How the array behaves where the vendor's sources leave it open.
///
/// Analogue values are on the chip's ADC scale ("LSB"). The last two say how the
/// work is done, which changes no result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What every register of a pixel off the array holds, in LSB. Evidence: modelled, the vendor
    /// does not say; open simulators take 0.
    pub edge: f64,
    /// Whether every analogue store is limited to the range of a register: [`Settings::range`].
    pub clip: bool,
    /// What PIX rises by for one unit of light, in LSB. 0.5 makes 8-bit light fill the half
    /// range that `get_image` gives. Evidence: modelled; the vendor's older simulator has 0.495.
    pub gain: f64,
    /// What PIX holds after a reset, in LSB. Evidence: quoted, "resets to the lowest level":
    /// it reads as +127 through one inverting store.
    pub reset_level: f64,
    /// How far R12 spreads in one PROP.
    pub propagation: Propagation,
    /// The converters between registers and the host.
    pub converters: Converters,
    /// One link of the diffusion network against the pixel's own cell, as one part in so many:
    /// by default `blur` moves 1/8 of the difference to each connected neighbour. At least 4.
    /// Evidence: guess.
    pub diffusion: u8,
    /// NEWS := this times the square of the sum, in 1/LSB. Evidence: guess; the vendor gives no
    /// calibration of the squarer.
    pub square_gain: f64,
    /// In which order rows are worked on; none is the best for the size.
    pub schedule: Option<Schedule>,
    /// On how many threads at most; none is as many as there are.
    pub threads: Option<usize>,
}

/// The ADC that reads registers and the DAC that drives the global input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converters {
    /// What the lowest code stands for, in LSB: the lowest value of a register.
    pub low: f64,
    /// What the ADC's highest code stands for, in LSB: the highest value of a register.
    pub high: f64,
    /// Codes of the ADC, at most 256.
    pub adc_codes: f64,
    /// Codes of the DAC, from `low` on, over the ADC's range and one step more.
    pub dac_codes: f64,
}

impl Converters {
    /// What the ADC makes of a value: the nearest code, halves to even.
    #[must_use]
    pub fn read(&self, value: f64) -> u8 {
        let step = (self.high - self.low) / (self.adc_codes - 1.0);
        let code = ((value - self.low) / step).round_ties_even();
        // `as` saturates, which is what is meant.
        code.clamp(0.0, self.adc_codes - 1.0) as u8
    }

    /// What a code of the DAC stands for, in LSB. Evidence: guess, the real map is calibrated
    /// for each chip.
    #[must_use]
    pub fn drive(&self, code: u16) -> f64 {
        let range = self.high - self.low + 1.0;
        self.low + f64::from(code) * range / self.dac_codes
    }
}

/// How far a bit spreads in one PROP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Propagation {
    /// Until nothing changes.
    Settled,
    /// So many pixels. Real chips differ; SCAMP-5's data say 128, about half the array.
    Steps(u32),
}

impl Settings {
    /// What a chip's data says, no clipping.
    #[must_use]
    pub fn from_device(device: &Device) -> Self {
        let (low, high) = device.register_range();
        Self {
            edge: device.value(Figure::Edge),
            clip: false,
            gain: device.value(Figure::LightScale),
            reset_level: device.value(Figure::LightReset),
            propagation: Propagation::Steps(device.value(Figure::Travel) as u32),
            converters: Converters {
                low,
                high,
                adc_codes: device.value(Figure::AdcCodes),
                dac_codes: device.value(Figure::DacCodes),
            },
            diffusion: device.value(Figure::DiffusionParts) as u8,
            square_gain: device.value(Figure::SquareGain),
            schedule: None,
            threads: None,
        }
    }

    /// Whether an array can be like this.
    ///
    /// # Errors
    /// The first field that cannot be.
    pub fn check(&self) -> Result<(), CodeProblem> {
        let wrong = |field: &'static str, value: &dyn fmt::Display, want: &'static str| {
            Err(CodeProblem::Setting {
                field,
                value: value.to_string(),
                want,
            })
        };
        for (field, value) in [
            ("edge", self.edge),
            ("gain", self.gain),
            ("reset_level", self.reset_level),
            ("square_gain", self.square_gain),
            ("converters.low", self.converters.low),
            ("converters.high", self.converters.high),
        ] {
            if !value.is_finite() {
                return wrong(field, &value, "a finite number");
            }
        }
        let Converters {
            low,
            high,
            adc_codes,
            dac_codes,
        } = self.converters;
        if low >= high {
            return wrong("converters.high", &high, "a number above converters.low");
        }
        let is_whole = |codes: f64| codes.fract() == 0.0;
        if !((2.0..=256.0).contains(&adc_codes) && is_whole(adc_codes)) {
            let want = "a whole number from 2 to 256";
            return wrong("converters.adc_codes", &adc_codes, want);
        }
        if !(dac_codes >= 2.0 && is_whole(dac_codes)) {
            let want = "a whole number of at least 2";
            return wrong("converters.dac_codes", &dac_codes, want);
        }
        if self.diffusion < 4 {
            return wrong(
                "diffusion",
                &self.diffusion,
                "4 or more: a cell has four links",
            );
        }
        Ok(())
    }

    /// The lowest and the highest value of a register, in LSB.
    #[must_use]
    pub const fn range(&self) -> (f64, f64) {
        (self.converters.low, self.converters.high)
    }

    /// What stores are limited to, in LSB; none where they are not.
    #[must_use]
    pub fn limits(&self) -> Option<(f64, f64)> {
        self.clip.then(|| self.range())
    }
}
