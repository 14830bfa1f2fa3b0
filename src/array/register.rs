//! The registers of a chip by name, and what they hold.

use std::collections::BTreeSet;

use super::Array;
use crate::{
    isa::{Analog, Bit, Cell, Device, Digital, Source, Value},
    plane::Plane,
    program::{CellEffect, Step},
};

/// Something that every pixel has one of, in the order of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Register {
    /// The photodiode.
    Pix,
    /// An analogue register.
    Analog(Analog),
    /// A one-bit register.
    Digital(Digital),
    /// The one-bit register that masks stores.
    Flag,
}

impl From<Cell> for Register {
    fn from(cell: Cell) -> Self {
        match cell {
            Cell::Analog(register) => Self::Analog(register),
            Cell::Digital(register) => Self::Digital(register),
            Cell::Flag => Self::Flag,
        }
    }
}

/// A name that is none of a chip's registers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{name}: no such register")]
#[diagnostic(help("{device} has {known}"))]
pub struct UnknownRegister {
    /// What was given.
    pub name: String,
    /// The chip's name.
    pub device: String,
    /// Those that can be meant.
    pub known: String,
}

impl Register {
    /// The register of this name, to be looked at.
    ///
    /// # Errors
    /// When the chip has none.
    pub fn named(device: &Device, name: &str) -> Result<Self, UnknownRegister> {
        Self::among(device, name, ", FLAG and PIX")
    }

    /// The register of this name, to be set; [`Pix`](Self::Pix) takes light instead.
    ///
    /// # Errors
    /// When the chip has none.
    pub fn named_to_set(device: &Device, name: &str) -> Result<Self, UnknownRegister> {
        Self::among(device, name, " and FLAG")
    }

    /// The register of this name; an error lists these beside the ones that the chip names.
    fn among(device: &Device, name: &str, others: &str) -> Result<Self, UnknownRegister> {
        Ok(match device.value_of(name) {
            Some(Value::Source(Source::Register(register))) => Self::Analog(register),
            Some(Value::Bit(Bit::Register(register))) => Self::Digital(register),
            Some(Value::Bit(Bit::Flag)) => Self::Flag,
            Some(Value::Source(Source::Pix)) => Self::Pix,
            _ => {
                let registers = device.registers();
                let names = registers.analog.iter().chain(&registers.digital);
                let names: Vec<_> = names.map(String::as_str).collect();
                return Err(UnknownRegister {
                    name: name.to_owned(),
                    device: device.name().to_owned(),
                    known: names.join(" ") + others,
                });
            }
        })
    }

    /// All that a chip keeps from frame to frame: analogue registers, one-bit registers, FLAG.
    #[must_use]
    pub fn all(device: &Device) -> Vec<Self> {
        let registers = device.registers();
        let analog = (0..).zip(&registers.analog);
        let digital = (0..).zip(&registers.digital);
        analog
            .map(|(i, _)| Self::Analog(Analog(i)))
            .chain(digital.map(|(i, _)| Self::Digital(Digital(i))))
            .chain([Self::Flag])
            .collect()
    }

    /// All that the parts of a program write, in the order of the chip, FLAG last.
    #[must_use]
    pub fn written(parts: &[&[Step]], device: &Device) -> Vec<Self> {
        let each = parts
            .iter()
            .map(|steps| CellEffect::of(steps, device).writes);
        let cells: BTreeSet<_> = each.flatten().collect();
        cells.into_iter().map(Self::from).collect()
    }

    /// Its name on a chip.
    #[must_use]
    pub fn name(self, device: &Device) -> String {
        match self {
            Self::Analog(register) => device.analog_name(register),
            Self::Digital(register) => device.digital_name(register),
            Self::Flag => "FLAG".to_owned(),
            Self::Pix => "PIX".to_owned(),
        }
    }

    /// Whether it holds bits.
    #[must_use]
    pub const fn is_bit(self) -> bool {
        matches!(self, Self::Digital(_) | Self::Flag)
    }

    /// What it holds: LSB, or 0 and 1.
    #[must_use]
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
