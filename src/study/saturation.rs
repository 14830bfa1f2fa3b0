//! Tells of the registers of a chip that end a run at the end of their range, and of light that they
//! cannot hold.

use crate::{
    array::{Arithmetic, Array, AtBorder, Settings, Unheld},
    number::Format,
    photoreceptor::{Curve, Response},
    rig::{
        Overflow,
        guard::{Guard, Warning},
    },
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

/// Warns of numbers that a program's format does not hold; whatever else its registers and events
/// say of range and threshold comes from that.
pub fn warn_unheld(guard: &mut Guard, subject: &str, unheld: &Unheld) {
    let (seen, why) = (unheld.to_string(), unheld.why());
    guard.warn(Warning::unheld(subject, seen, why, unheld.change()));
}

/// Counts the light that cells cannot hold; analogue ones hold all that the chip's converters give.
#[must_use]
pub fn of_light(cells: Arithmetic, settings: &Settings) -> Overflow {
    let format = match cells {
        Arithmetic::Number(format) => format,
        Arithmetic::Silicon { .. } => Format::F64,
    };
    let curve = Curve::Linear {
        white: 1.0 / settings.gain,
    };
    let round_f32 = false;
    Overflow::new(format, Response { curve, round_f32 })
}
