//! `exec --dump`: every register as numbers and as a picture.

use std::path::{Path, PathBuf};

use crate::{
    array::{Array, Register},
    isa::Device,
    npy,
    picture::{panel, png},
    plane::Plane,
    save::{SaveError, Together, TogetherError},
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

/// Writes every register, as numbers and as a picture: all of them before the first has its name.
pub fn dump(chip: &dyn Array, folder: &Path) -> Result<(), TogetherError> {
    let mut files = Together::new();
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
            add(&mut files, &array, &values.mapv(|bit| bit as u8))?;
        } else {
            add(&mut files, &array, &values)?;
        }
        let picture = png(&panel::frame(&values, black, white));
        files.add(&shown, |out| out.write_all(&picture))?;
    }
    files.keep()
}

fn add<T: npy::Element>(
    files: &mut Together,
    path: &Path,
    plane: &Plane<T>,
) -> Result<(), SaveError> {
    let (height, width) = plane.dim();
    files.add(path, |out| {
        npy::write(out, &[height, width], plane.iter().copied())
    })
}
