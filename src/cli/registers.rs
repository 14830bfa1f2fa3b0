//! Registers of a chip by name, and what they hold.

use miette::miette;

use crate::{
    array::Array,
    isa::{Analog, Bit, Device, Digital, Source, Value},
    plane::Plane,
    program::{Cell, Effect, Expansion},
};

/// Something that every pixel has one of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    Analog(Analog),
    Digital(Digital),
    Flag,
    /// The photodiode.
    Pix,
}

impl Register {
    /// The register of this name.
    pub fn named(device: &Device, name: &str) -> miette::Result<Self> {
        Ok(match device.value_of(name) {
            Some(Value::Source(Source::Register(register))) => Self::Analog(register),
            Some(Value::Bit(Bit::Register(register))) => Self::Digital(register),
            Some(Value::Bit(Bit::Flag)) => Self::Flag,
            Some(Value::Source(Source::Pix)) => Self::Pix,
            _ => {
                let registers = device.registers();
                let names = registers.analog.iter().chain(&registers.digital);
                let names: Vec<_> = names.map(String::as_str).collect();
                return Err(miette!(
                    help = format!("{} has {}, FLAG and PIX", device.name(), names.join(" ")),
                    "{name}: no such register"
                ));
            }
        })
    }

    /// All that a program writes, in the order of the chip, FLAG last.
    pub fn written(expansion: &Expansion, device: &Device) -> Vec<Self> {
        let code = &expansion.code;
        let mut cells = Effect::of(&code.init, device).writes;
        cells.extend(Effect::of(&code.frame, device).writes);
        let register = |cell| match cell {
            Cell::Analog(register) => Self::Analog(register),
            Cell::Digital(register) => Self::Digital(register),
            Cell::Flag => Self::Flag,
        };
        cells.into_iter().map(register).collect()
    }

    /// Its name on a chip.
    pub fn name(self, device: &Device) -> String {
        match self {
            Self::Analog(register) => device.analog_name(register),
            Self::Digital(register) => device.digital_name(register),
            Self::Flag => "FLAG".to_owned(),
            Self::Pix => "PIX".to_owned(),
        }
    }

    /// Whether it holds bits.
    pub const fn is_bit(self) -> bool {
        matches!(self, Self::Digital(_) | Self::Flag)
    }

    /// What it holds: LSB, or 0 and 1.
    pub fn values(self, chip: &dyn Array) -> Plane<f64> {
        let numbers = |bits: Plane<bool>| bits.mapv(|bit| f64::from(u8::from(bit)));
        match self {
            Self::Analog(register) => chip.analog(register),
            Self::Digital(register) => numbers(chip.digital(register)),
            Self::Flag => numbers(chip.flag()),
            Self::Pix => chip.pix(),
        }
    }
}
