//! `exec --dump`: every register as numbers and as a picture.

use std::path::{Path, PathBuf};

use super::super::{npy, registers::Register};
use crate::{
    array::Array,
    isa::{Analog, Device, Digital, Figure},
    picture::{panel, write_png},
};

/// The files that a dump writes.
pub fn files(device: &Device, folder: &Path) -> Vec<PathBuf> {
    let all = registers(device).into_iter();
    all.flat_map(|(_, name)| pair(folder, &name)).collect()
}

/// The registers that are dumped, with their names.
fn registers(device: &Device) -> Vec<(Register, String)> {
    let registers = device.registers();
    let analog = (0..)
        .zip(&registers.analog)
        .map(|(i, _)| Register::Analog(Analog(i)));
    let digital = (0..)
        .zip(&registers.digital)
        .map(|(i, _)| Register::Digital(Digital(i)));
    let all = analog.chain(digital).chain([Register::Flag]);
    all.map(|register| (register, register.name(device)))
        .collect()
}

/// The files of a register that is dumped.
fn pair(folder: &Path, register: &str) -> [PathBuf; 2] {
    ["npy", "png"].map(|ending| folder.join(format!("{register}.{ending}")))
}

/// Writes every register, as numbers and as a picture.
pub fn dump(chip: &dyn Array, folder: &Path) -> miette::Result<()> {
    let (low, high) = (
        chip.device().value(Figure::Lowest),
        chip.device().value(Figure::Highest),
    );
    for (register, name) in registers(chip.device()) {
        let values = register.values(chip);
        let (black, white) = if register.is_bit() {
            (0.0, 1.0)
        } else {
            (low, high)
        };
        let [array, shown] = pair(folder, &name);
        if register.is_bit() {
            npy::write(&array, &values.mapv(|bit| bit as u8))?;
        } else {
            npy::write(&array, &values)?;
        }
        write_png(&shown, &panel::frame(&values, black, white))?;
    }
    Ok(())
}
