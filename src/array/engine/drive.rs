//! NEWS cells that several pixels drive, one by one.

use std::ops::Range;

use super::{
    super::{Place, RowOps, Share},
    operation::BusInput,
    slab::Slab,
};

/// Each holds the sum of what the pixels put in whose FLAG is 1. `driven`: where it lies, seen
/// from each of them, and its share.
#[inline(never)]
pub(super) fn drive<D: RowOps>(
    domain: &D,
    slab: &mut Slab<'_, D::Cell>,
    bus_inputs: &[BusInput],
    driven: &[((isize, isize), Share)],
    step: u64,
    clip: Option<(f64, f64)>,
    rows: Range<usize>,
) {
    let (register, step) = (slab.layout.news, slab.first() + step);
    let cells = slab.take(register);
    let (view, _) = slab.view();
    let width = view.size.width;
    for (y, x) in rows.flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mut total = domain.nothing();
        let mut any = None;
        for ((dy, dx), share) in driven {
            let (y, x) = (y.wrapping_add_signed(-dy), x.wrapping_add_signed(-dx));
            if view.flagged(y, x) {
                domain.join(&mut total, &view.sum(domain, bus_inputs, y, x));
                any = Some(*share);
            }
        }
        if let Some(share) = any {
            let place = Place {
                y,
                x,
                register,
                step,
            };
            let stored = domain.store(&total, share, place);
            cells[view.cell(y, x)] = domain.limited(stored, clip);
        }
    }
    slab.put(register, cells);
}
