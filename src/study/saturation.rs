//! Tells of the registers of a chip that are at the end of their range, after a run or after any frame
//! of it, and of light that they cannot hold.

use super::stores::{self, Stores};
use crate::{
    array::{Arithmetic, Array, AtEnd, Settings, Unheld, claim::MOST_EFFORT, effort, taps},
    isa::Device,
    number::Format,
    photoreceptor::{Curve, Response},
    program::Step,
    rig::{
        Overflow,
        guard::{Guard, Warning},
    },
};

/// Warns of a chip whose registers hold numbers between these ends, if they have any.
pub fn warn(guard: &mut Guard, subject: &str, chip: &dyn Array, ends: Option<[f64; 2]>) {
    let all = ends.map_or(Vec::new(), |ends| AtEnd::registers(chip, ends));
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

/// Registers at the end of their range after any frame of a run; or, in an arithmetic that has no end,
/// beyond that of the chip.
pub struct Saturation {
    ends: [f64; 2],
    /// Whether registers hold what lies beyond these ends.
    held: bool,
    frames: u64,
    worst: Vec<Saturated>,
    /// What was seen between the words of some frames.
    stores: Stores,
}

/// A register, and the frame after which it was worst.
struct Saturated {
    worst: AtEnd,
    frame: u64,
}

impl Saturation {
    /// Nothing seen yet of a chip of these cells.
    #[must_use]
    pub fn new(cells: Arithmetic, device: &Device, settings: &Settings) -> Self {
        let ends = cells.ends(device, settings);
        Self {
            ends: ends.unwrap_or(device.register_range().into()),
            held: ends.is_none(),
            frames: 0,
            worst: Vec::new(),
            stores: Stores::default(),
        }
    }

    /// Looks at what these steps store on the way, if the frame that comes is one of those that are
    /// looked at. They run aside: the array is then as it was, and they are still to be run.
    pub fn before(&mut self, chip: &mut dyn Array, steps: &[Step]) {
        let range = (self.ends, self.held);
        self.stores.frame(self.frames, chip, steps, range);
    }

    /// Looks at the registers after a frame.
    pub fn frame(&mut self, chip: &dyn Array) {
        let found = if self.held {
            AtEnd::beyond(chip, self.ends)
        } else {
            AtEnd::registers(chip, self.ends)
        };
        let frame = self.frames;
        for worst in found {
            let mut all = self.worst.iter_mut();
            match all.find(|it| it.worst.register == worst.register) {
                // Of equal ones the last.
                Some(it) if it.worst.pixels > worst.pixels => {}
                Some(it) => *it = Saturated { worst, frame },
                None => self.worst.push(Saturated { worst, frame }),
            }
        }
        self.frames += 1;
    }

    /// Warns of what was seen of a program; `loads` says which registers hold a constant that it
    /// loads.
    pub fn warn(self, guard: &mut Guard, program: &str, loads: impl Fn(&str) -> bool) {
        let warning = if self.held {
            Warning::beyond
        } else {
            Warning::saturation
        };
        for it in self.worst {
            let at = it.worst;
            if at.alike && loads(&at.register) {
                continue;
            }
            let counted = (at.pixels, at.of);
            let after = if it.frame + 1 == self.frames {
                "the last frame".to_owned()
            } else {
                format!("frame {}", it.frame)
            };
            let place = format!("{} after {after}", at.register);
            guard.warn(warning(program, &place, counted, at.ends));
        }
        // Where registers at a frame's end were told of, the guard has no second warning of it.
        if let Some((at, place)) = self.stores.found() {
            guard.warn(warning(program, &place, (at.pixels, at.of), at.ends));
        }
    }
}

/// Whether steps have words whose stores are looked at one by one.
#[must_use]
pub fn looks(codes: &[&[Step]], device: &Device) -> bool {
    codes.iter().any(|steps| stores::looks(steps, device))
}

/// Whether a register holds a constant that these steps load, whatever the light is.
#[must_use]
pub fn loads(steps: &[Step], device: &Device, settings: Settings, register: &str) -> bool {
    if effort(steps, device).is_none_or(|it| it > MOST_EFFORT) {
        return true;
    }
    let all = taps::read_all(steps, device, settings);
    let at = device.value_of(register).and_then(|it| it.analog());
    match (all, at) {
        (Ok(all), Some(at)) => {
            let read = all.get(usize::from(at.0));
            read.is_none_or(|it| matches!(it, Ok(taps) if taps.taps.is_empty()))
        }
        _ => true,
    }
}
