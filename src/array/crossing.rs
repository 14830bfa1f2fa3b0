//! Whether a program fires where its `[computes]` says: where the drive has moved by more than the
//! threshold since the cell's last event, at first the first frame.

use ndarray::Array2;

use super::{Array as _, Chip, Exact, Settings};
use crate::{
    event::{Packet, Polarity},
    isa::Device,
    plane::{Plane, Size},
    program::{Action, Code, Host, Step},
    rng::Hash,
    unit::Micros,
};

/// Side of the array, in pixels, at least.
const SIDE: usize = 40;

/// Pixels along a side that are looked at, at least.
const LOOKED_AT: usize = 16;

/// Pixels beside a kernel's own that a program may spoil at the border.
const SPOILT: usize = 6;

/// Distances from the threshold below which a rounding could decide, as a part of it.
const NEAR: f64 = 1e-6;

/// A pixel at which a program does otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parting {
    /// By how much the drive moved since the cell's last event, in LSB.
    pub moved: f64,
    /// Events there: 1 ON, -1 OFF, [`TWICE`] for several.
    pub fired: i8,
    /// In which frame after `init`, from 1.
    pub frame: usize,
}

/// Several events of a cell in one frame.
pub(super) const TWICE: i8 = 2;

/// Frames that are shown after the first: after the second, memories are those of earlier events.
pub(super) const FRAMES: usize = 4;

/// The brightest light that a picture has.
const WHITE: f64 = 255.0;

/// What a program did on random pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Where it does not fire as is stated, if it does not somewhere.
    pub parting: Option<Parting>,
    /// Whether OFF and ON are read out at all.
    pub reads: [bool; 2],
    /// Whether a drive has moved below minus the threshold and above it.
    pub crossed: [bool; 2],
}

/// Shows random pictures in exact arithmetic. `kernel` is in LSB for each unit of light; `step`: the
/// memory holds the drive in steps of so many LSB, so that half a step may decide. Every event finds
/// a slot; a sign that is not read out at all is not looked at.
///
/// # Errors
/// When the program cannot be run.
pub(super) fn parts(
    kernel: &Plane<f64>,
    (threshold, step): (f64, f64),
    code: &Code,
    device: &Device,
    settings: Settings,
) -> Result<Seen, String> {
    let rim = kernel.nrows().max(kernel.ncols()) / 2 + SPOILT;
    let side = SIDE.max(2 * rim + LOOKED_AT);
    let size = Size::new(side, side);
    let mut code = code.clone();
    let mut seen = Seen::default();
    give_slots(&mut code.init, size, &mut [false; 2]);
    give_slots(&mut code.frame, size, &mut seen.reads);
    let chip = Chip::new("computes", Exact, &code, device, size, settings);
    let mut chip = chip.map_err(|why| why.to_string())?;
    let mut packet = Packet::new(size, 1);
    let light = light(kernel, threshold, step);
    let picture = |n: usize| {
        let value = |place| light(Hash::new(n as u64).with(place as u64).uniform());
        Plane::from_shape_fn(size.shape(), |(y, x)| value(y * side + x))
    };
    let inside = || rim..side - rim;
    let first = picture(0);
    chip.expose(&first).map_err(|why| why.to_string())?;
    let ran = chip.run_init(Micros(0), &mut packet);
    ran.map_err(|why| why.to_string())?;
    // What each cell remembers; not a number where that hangs on a sign that is not read out.
    let mut memory = Plane::zeros(size.shape());
    for (y, x) in inside().flat_map(|y| inside().map(move |x| (y, x))) {
        memory[(y, x)] = drive(kernel, &first, (y, x));
    }
    for frame in 1..=FRAMES {
        packet.events.clear();
        let shown = picture(frame);
        chip.expose(&shown).map_err(|why| why.to_string())?;
        let ran = chip.run_frame(Micros(frame as u64), &mut packet);
        ran.map_err(|why| why.to_string())?;
        let fired = signs(&packet, size);
        for (y, x) in inside().flat_map(|y| inside().map(move |x| (y, x))) {
            let (memory, fired) = (&mut memory[(y, x)], fired[(y, x)]);
            let now = drive(kernel, &shown, (y, x));
            let moved = now - *memory;
            let near = (moved.abs() - threshold).abs() <= NEAR * threshold + step / 2.0;
            let crosses = match moved {
                _ if moved > threshold => 1,
                _ if -moved > threshold => -1,
                _ => 0,
            };
            if crosses != 0 && !near {
                seen.crossed[usize::from(crosses > 0)] = true;
            }
            let is_read = crosses == 0 || seen.reads[usize::from(crosses > 0)];
            let stated = if is_read { crosses } else { 0 };
            if !near && !moved.is_nan() && fired != stated {
                seen.parting = Some(Parting {
                    moved,
                    fired,
                    frame,
                });
                return Ok(seen);
            }
            if fired != 0 {
                *memory = now;
            } else if !is_read {
                *memory = f64::NAN;
            }
        }
    }
    Ok(seen)
}

/// The light of a random number from 0 to 1: so bright that about half of all cells fire. A memory in
/// steps has levels for the light of pictures alone; where that is not bright enough, pictures have
/// more of its two ends.
fn light(kernel: &Plane<f64>, threshold: f64, step: f64) -> impl Fn(f64) -> f64 {
    let power: f64 = kernel.iter().map(|weight| weight * weight).sum();
    let brightest = 4.0 * threshold / power.sqrt().max(f64::MIN_POSITIVE);
    let is_limited = step > 0.0 && brightest > WHITE;
    move |random| {
        if is_limited {
            (WHITE / 2.0 + brightest * (random - 0.5)).clamp(0.0, WHITE)
        } else {
            brightest * random
        }
    }
}

/// Gives scans as many slots as there are pixels, so that no event is lost; `reads`: whether OFF and
/// ON are read out.
fn give_slots(steps: &mut [Step], size: Size, reads: &mut [bool; 2]) {
    for step in steps {
        match &mut step.action {
            Action::Host(Host::ScanEvents {
                slots, polarity, ..
            }) => {
                *slots = size.pixels() as u32;
                reads[usize::from(*polarity == Polarity::On)] = true;
            }
            Action::Host(Host::ScanDigital {
                events: Some((polarity, _)),
                ..
            }) => reads[usize::from(*polarity == Polarity::On)] = true,
            Action::Repeat { body, .. } => give_slots(body, size, reads),
            Action::Host(_) | Action::Word(_) => {}
        }
    }
}

/// The sign of the event of each cell, 0 where there is none.
fn signs(packet: &Packet, size: Size) -> Array2<i8> {
    let mut fired = Array2::<i8>::zeros(size.shape());
    for event in &packet.events {
        let sign = if event.polarity == Polarity::On {
            1
        } else {
            -1
        };
        let fired = &mut fired[(event.y.into(), event.x.into())];
        *fired = if *fired == 0 { sign } else { TWICE };
    }
    fired
}

/// The drive of a cell under a picture.
pub(super) fn drive(kernel: &Plane<f64>, picture: &Plane<f64>, (y, x): (usize, usize)) -> f64 {
    let (down, right) = (kernel.nrows() / 2, kernel.ncols() / 2);
    let terms = kernel.indexed_iter();
    terms
        .map(|((i, j), weight)| weight * picture[(y + i - down, x + j - right)])
        .sum()
}
