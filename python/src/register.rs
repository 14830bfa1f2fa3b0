//! The registers of a chip by name, and what they hold.

use amacrine::{
    array::Array,
    isa::{Analog, Device, Digital},
    plane::Plane,
};
use pyo3::prelude::*;

use crate::error::refused;

/// Something that every pixel has one of.
#[derive(Clone, Copy)]
pub enum Register {
    Analog(Analog),
    Digital(Digital),
    Flag,
}

impl Register {
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
        }
    }
}

/// The registers of a chip with their names, FLAG last.
pub fn registers(device: &Device) -> Vec<(String, Register)> {
    let all = device.registers();
    let analog = (0..).zip(&all.analog);
    let digital = (0..).zip(&all.digital);
    let analog = analog.map(|(i, _)| {
        let register = Analog(i);
        (device.analog_name(register), Register::Analog(register))
    });
    let digital = digital.map(|(i, _)| {
        let register = Digital(i);
        (device.digital_name(register), Register::Digital(register))
    });
    let flag = ("FLAG".to_owned(), Register::Flag);
    analog.chain(digital).chain([flag]).collect()
}

/// The registers of these names.
pub fn named(
    all: &[(String, Register)],
    names: Vec<String>,
    device: &Device,
) -> PyResult<Vec<(String, Register)>> {
    let find = |name: String| {
        let found = all.iter().find(|(known, _)| *known == name).cloned();
        found.ok_or_else(|| {
            let known: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
            refused(
                format!("{name}: no such register"),
                format!("{} has {}", device.name(), known.join(" ")),
            )
        })
    };
    names.into_iter().map(find).collect()
}
