//! Tells of the registers of a chip that end a run at the end of their range.

use crate::{
    array::{Array, AtBorder},
    rig::guard::{Guard, Warning},
};

/// Warns of a chip whose registers hold numbers between these ends, if they have any.
pub fn warn(guard: &mut Guard, subject: &str, chip: &dyn Array, ends: Option<[f64; 2]>) {
    let all = ends.map_or(Vec::new(), |ends| AtBorder::registers(chip, ends));
    // What every pixel holds alike is a constant, such as a threshold.
    for at in all.into_iter().filter(|it| !it.alike) {
        let place = format!("{} after the last frame", at.register);
        let counted = (at.pixels, at.of);
        guard.warn(Warning::saturation(subject, &place, counted, at.ends));
    }
}
