//! The squarer, pixel by pixel.

use std::ops::Range;

use super::{
    super::{Place, RowOps, Settings, Undecided},
    operation::BusInput,
    slab::Slab,
};

/// NEWS := gain times the square of the bus, where FLAG is 1.
///
/// # Errors
/// In domains that have no answer.
#[inline(never)]
pub(super) fn square<D: RowOps>(
    domain: &D,
    settings: &Settings,
    slab: &mut Slab<'_, D::Cell>,
    bus_inputs: &[BusInput],
    step: u64,
    rows: Range<usize>,
) -> Result<(), Undecided> {
    let (register, step) = (slab.layout.news, slab.first() + step);
    let cells = slab.take(register);
    let (view, _) = slab.view();
    let width = view.size.width;
    let mut decided = true;
    for (y, x) in rows.flat_map(|y| (0..width).map(move |x| (y, x))) {
        let place = Place {
            y,
            x,
            register,
            step,
        };
        let sum = view.sum(domain, bus_inputs, y, x);
        match domain.square(&sum, settings.square_gain, place) {
            Some(cell) if view.flagged(y, x) => {
                cells[view.cell(y, x)] = domain.limited(cell, settings.limits());
            }
            Some(_) => {}
            None => decided = false,
        }
    }
    slab.put(register, cells);
    if decided {
        Ok(())
    } else {
        Err(Undecided { operation: "sq" })
    }
}
