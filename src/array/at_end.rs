//! Registers at the end of their range: what was to be held there was larger.

use super::{Arithmetic, Array, Settings};
use crate::isa::{Analog, Device, Errors};

/// A register with values at the end of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct AtEnd {
    /// Its name.
    pub register: String,
    /// Pixels at the end.
    pub pixels: u64,
    /// All pixels.
    pub of: u64,
    /// The ends.
    pub ends: [f64; 2],
    /// Whether all pixels hold the same: a constant that was loaded, or a picture of which nothing
    /// is left.
    pub alike: bool,
}

/// Nearer than this part of the range a value is at its end: the chip's errors move it after the
/// store. Half an LSB of the chip's 256.
const NEAR: f64 = 0.5 / 256.0;

/// The smallest share of the pixels that is told of.
const SHARE: f64 = 0.05;

impl Arithmetic {
    /// The least and the most that a register holds, in LSB; none where it holds any number.
    #[must_use]
    pub fn ends(self, device: &Device, settings: &Settings) -> Option<[f64; 2]> {
        let chip: [f64; 2] = device.register_range().into();
        match self {
            // Headroom included: cells saturate there, wherever the converter does.
            Self::Silicon { .. } => Some(Errors::from_device(device).range.into()),
            Self::Number(format) => {
                let held = format.ends().map(|_| <[f64; 2]>::from(format.limits()));
                match (held, settings.clip.then_some(chip)) {
                    // Whichever comes first.
                    (Some(held), Some(clip)) => Some([held[0].max(clip[0]), held[1].min(clip[1])]),
                    (held, clip) => held.or(clip),
                }
            }
        }
    }
}

impl AtEnd {
    /// The registers of a chip that hold a picture of which at least a twentieth is at an end of
    /// the range, and those of which every pixel is at the same end.
    #[must_use]
    pub fn registers(chip: &dyn Array, ends: [f64; 2]) -> Vec<Self> {
        Self::all(chip, ends, false)
    }

    /// The registers of a chip that hold a picture of which at least a twentieth lies beyond these
    /// ends, in an arithmetic that has none.
    #[must_use]
    pub fn beyond(chip: &dyn Array, ends: [f64; 2]) -> Vec<Self> {
        Self::all(chip, ends, true)
    }

    fn all(chip: &dyn Array, ends: [f64; 2], beyond: bool) -> Vec<Self> {
        let registers = (0..chip.layout().analog).map(Analog);
        registers
            .filter_map(|register| Self::of(chip, register, ends, beyond))
            .collect()
    }

    /// The same of one register, by either rule: beyond these ends, or at them.
    #[must_use]
    pub fn of(chip: &dyn Array, register: Analog, ends: [f64; 2], beyond: bool) -> Option<Self> {
        let [low, high] = ends;
        if beyond {
            Self::in_register(chip, register, ends, &|value| value < low || value > high)
        } else {
            let near = NEAR * (high - low);
            Self::in_register(chip, register, ends, &|value| {
                value <= low + near || value >= high - near
            })
        }
    }

    fn in_register(
        chip: &dyn Array,
        register: Analog,
        ends: [f64; 2],
        lies: &impl Fn(f64) -> bool,
    ) -> Option<Self> {
        let values = chip.analog(register);
        let first = values.first().copied()?;
        let alike = values.iter().all(|value| *value == first);
        let pixels = values.iter().filter(|value| lies(**value)).count();
        let is_much = pixels as f64 >= SHARE * values.len() as f64;
        is_much.then(|| Self {
            register: chip.device().analog_name(register),
            pixels: pixels as u64,
            of: values.len() as u64,
            ends,
            alike,
        })
    }
}
