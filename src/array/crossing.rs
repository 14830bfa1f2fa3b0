//! Whether a program fires where its `[computes]` says: where the drive has moved by more than the
//! threshold since the cell's last event, here the first frame.

use ndarray::Array2;

use super::{Array as _, Chip, Exact, Settings};
use crate::{
    event::{Packet, Polarity},
    isa::Device,
    plane::{Plane, Size},
    program::Code,
    rng::Hash,
    unit::Micros,
};

/// Side of the array, in pixels.
const SIDE: usize = 40;

/// Pixels beside a kernel's own that a program may spoil at the border.
const SPOILT: usize = 6;

/// Distances from the threshold below which a rounding could decide, as a part of it.
const NEAR: f64 = 1e-6;

/// A pixel at which a program does otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parting {
    /// By how much the drive moved, in LSB.
    pub moved: f64,
    /// Events there: 1 ON, -1 OFF.
    pub fired: i8,
}

/// Shows two random pictures in exact arithmetic; where it does not fire as is stated, if it does
/// not somewhere. `kernel` is in LSB for each unit of light. What has no slot, and a sign that is
/// not read out at all, is not looked at.
///
/// # Errors
/// When the program cannot be run.
pub(super) fn parts(
    kernel: &Plane<f64>,
    threshold: f64,
    code: &Code,
    device: &Device,
    settings: Settings,
) -> Result<Option<Parting>, String> {
    let size = Size::new(SIDE, SIDE);
    let chip = Chip::new("computes", Exact, code, device, size, settings);
    let mut chip = chip.map_err(|why| why.to_string())?;
    let mut packet = Packet::new(size, 1);
    // So bright that about half of all cells fire.
    let power: f64 = kernel.iter().map(|weight| weight * weight).sum();
    let brightest = 4.0 * threshold / power.sqrt().max(f64::MIN_POSITIVE);
    let pictures = [0, 1].map(|n| {
        let value = |place| brightest * Hash::new(n).with(place as u64).uniform();
        Plane::from_shape_fn(size.shape(), |(y, x)| value(y * SIDE + x))
    });
    chip.expose(&pictures[0]).map_err(|why| why.to_string())?;
    let ran = chip.run_init(Micros(0), &mut packet);
    ran.map_err(|why| why.to_string())?;
    packet.events.clear();
    chip.expose(&pictures[1]).map_err(|why| why.to_string())?;
    let ran = chip.run_frame(Micros(1), &mut packet);
    ran.map_err(|why| why.to_string())?;
    if packet.dropped.total() > 0 {
        return Ok(None);
    }
    let mut fired = Array2::<i8>::zeros(size.shape());
    for event in &packet.events {
        let sign = if event.polarity == Polarity::On {
            1
        } else {
            -1
        };
        fired[(event.y.into(), event.x.into())] = sign;
    }
    let reads = [-1, 1].map(|sign| fired.iter().any(|it| *it == sign));
    let step = &pictures[1] - &pictures[0];
    let rim = kernel.nrows().max(kernel.ncols()) / 2 + SPOILT;
    for y in rim..SIDE.saturating_sub(rim) {
        for x in rim..SIDE.saturating_sub(rim) {
            let moved = moved(kernel, &step, (y, x));
            let near = (moved.abs() - threshold).abs() <= NEAR * threshold;
            let stated = match moved {
                _ if moved > threshold && reads[1] => 1,
                _ if -moved > threshold && reads[0] => -1,
                _ => 0,
            };
            let fired = fired[(y, x)];
            if !near && fired != stated {
                return Ok(Some(Parting { moved, fired }));
            }
        }
    }
    Ok(None)
}

/// What a change of the light changes the drive by.
fn moved(kernel: &Plane<f64>, step: &Plane<f64>, (y, x): (usize, usize)) -> f64 {
    let (down, right) = (kernel.nrows() / 2, kernel.ncols() / 2);
    let terms = kernel.indexed_iter();
    terms
        .map(|((i, j), weight)| weight * step[(y + i - down, x + j - right)])
        .sum()
}
