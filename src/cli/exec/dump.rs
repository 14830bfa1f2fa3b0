//! `exec --dump`: every register as numbers and as a picture.

use std::path::{Path, PathBuf};

use super::super::npy;
use crate::{
    array::{Array, Register},
    isa::Device,
    picture::{panel, write_png},
};

/// The files that a dump writes.
pub fn files(device: &Device, folder: &Path) -> Vec<PathBuf> {
    let all = Register::all(device).into_iter();
    all.flat_map(|register| pair(folder, &register.name(device)))
        .collect()
}

/// The files of a register that is dumped.
fn pair(folder: &Path, register: &str) -> [PathBuf; 2] {
    ["npy", "png"].map(|ending| folder.join(format!("{register}.{ending}")))
}

/// Writes every register, as numbers and as a picture.
pub fn dump(chip: &dyn Array, folder: &Path) -> miette::Result<()> {
    let (low, high) = chip.device().register_range();
    for register in Register::all(chip.device()) {
        let name = register.name(chip.device());
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
