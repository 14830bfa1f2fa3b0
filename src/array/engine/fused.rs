//! Two stores of the bus at once: what the first puts into a cell goes on to the second by way
//! of the machine's own registers, and never into the cell.

use std::ops::Range;

use super::{
    super::{RowOps, Share},
    operation::{BusInput, FusedStore},
    runs::RUN,
    slab::Slab,
    store::{limit, store_few},
    view::{BUS_INPUTS, Stretch, View},
};

/// Does both in these rows, where FLAG is 1 in all pixels and nothing comes from above or below
/// the array. `room` is for [`ROOM`](super::runs::ROOM) cells.
#[inline]
pub(super) fn fused<D: RowOps>(
    domain: &D,
    view: &mut View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &FusedStore,
    clip: Option<(f64, f64)>,
    rows: Range<usize>,
    room: &mut [D::Cell],
) {
    if rows.is_empty() {
        return;
    }
    let one = &bus_inputs[store.first.bus_inputs.clone()];
    match one.len() {
        0 => by_way::<D, 0>(domain, view, one, store, clip, &rows, room),
        1 => by_way::<D, 1>(domain, view, one, store, clip, &rows, room),
        _ => by_way::<D, 2>(domain, view, one, store, clip, &rows, room),
    }
    columns(domain, view, one, store, clip, &rows, room);
}

/// The same in [interior](super::operation::Store::is_interior) rows.
#[inline]
pub(super) fn fused_interior<D: RowOps>(
    domain: &D,
    slab: &mut Slab<'_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &FusedStore,
    rows: &Range<usize>,
) {
    let (mut view, _) = slab.view();
    let target = usize::from(store.second.register.0);
    match *bus_inputs {
        [_] if store.own => interior(domain, &mut view, [], store, rows),
        [a] => interior(domain, &mut view, [a], store, rows),
        [a, b] if store.own => {
            let other = if a.plane == target { b } else { a };
            interior(domain, &mut view, [other], store, rows);
        }
        [a, b] => interior(domain, &mut view, [a, b], store, rows),
        _ => {}
    }
    if store.first.border.left + store.first.border.right > 0 {
        columns_of(domain, slab, bus_inputs, store, rows);
    }
}

/// The cells at the left and right border, in a slab: what is called sees no view that loops
/// keep in the machine's registers.
#[inline(never)]
fn columns_of<D: RowOps>(
    domain: &D,
    slab: &mut Slab<'_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &FusedStore,
    rows: &Range<usize>,
) {
    let (mut view, room) = slab.view();
    columns(domain, &mut view, bus_inputs, store, None, rows, room);
}

/// With `N` bus inputs, besides the cell itself.
#[inline]
fn interior<D: RowOps, const N: usize>(
    domain: &D,
    view: &mut View<'_, '_, D::Cell>,
    bus_inputs: [BusInput; N],
    store: &FusedStore,
    rows: &Range<usize>,
) {
    let cells = view.take(store.second.register);
    let (at, n) = (view.cell(rows.start, 0), rows.len() * view.size.width);
    let starts = view.starts(&bus_inputs, at, store.first.beside);
    let operands = &view.sources(&bus_inputs, &starts, 0, n);
    let extra = extra(view, store, [at], 0, n);
    let new = &mut cells[at..][..n];
    domain.store_fused(operands, store.own, store.first.share.by, extra, new);
    view.put(store.second.register, cells);
}

/// The cells of these rows at the left and right border.
#[inline]
fn columns<D: RowOps>(
    domain: &D,
    view: &mut View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &FusedStore,
    clip: Option<(f64, f64)>,
    rows: &Range<usize>,
    room: &mut [D::Cell],
) {
    let width = view.size.width;
    let border = store.first.border;
    for x in (0..border.left).chain(width - border.right..width) {
        column(domain, view, bus_inputs, store, clip, rows, x, room);
    }
}

/// The cells of these rows in one of those columns.
#[allow(clippy::too_many_arguments)]
#[inline(never)]
fn column<D: RowOps>(
    domain: &D,
    view: &mut View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &FusedStore,
    clip: Option<(f64, f64)>,
    rows: &Range<usize>,
    x: usize,
    room: &mut [D::Cell],
) {
    let (down, right) = store.first.beside;
    let from_x = x.wrapping_add_signed(-right);
    let off =
        |bus_input: &BusInput| from_x.wrapping_add_signed(bus_input.beside.1) >= view.size.width;
    if store.extra.is_none() && bus_inputs.iter().all(off) {
        // The same all along.
        let y = rows.start.wrapping_add_signed(-down);
        let place = view.place(&store.first, rows.start, x);
        let sum = view.sum(domain, bus_inputs, y, from_x);
        let between = domain.limited(domain.store(&sum, store.first.share, place), clip);
        let place = view.place(&store.second, rows.start, x);
        let sum = domain.sum(&[&[between]], 0);
        let new = domain.limited(domain.store(&sum, UNDIVIDED, place), clip);
        view.fill_column(store.second.register, rows, x, &new);
        return;
    }
    for top in rows.clone().step_by(COLUMN) {
        let n = (rows.end - top).min(COLUMN);
        let (between, room) = room.split_at_mut(COLUMN);
        let (new, room) = room.split_at_mut(COLUMN);
        let (more, room) = room.split_at_mut(COLUMN);
        let (between, new, more) = (&mut between[..n], &mut new[..n], &mut more[..n]);
        let mut sources: [&[D::Cell]; BUS_INPUTS] = [&[]; BUS_INPUTS];
        let blocks = room.chunks_exact_mut(COLUMN).zip(bus_inputs);
        for (source, (block, bus_input)) in sources.iter_mut().zip(blocks) {
            let (y, x) = (
                top.wrapping_add_signed(-down),
                x.wrapping_add_signed(-right),
            );
            view.column(*bus_input, y, x, &mut block[..n]);
            *source = &block[..n];
        }
        let sources = &sources[..bus_inputs.len()];
        let place = view.place(&store.first, top, x);
        store_few(domain, sources, store.first.share, place, clip, between);
        let mut sources: [&[D::Cell]; 2] = [between, &[]];
        if let Some(extra) = store.extra {
            view.column(extra, top, x, more);
            sources[1] = more;
        }
        let sources = &sources[..=usize::from(store.extra.is_some())];
        let place = view.place(&store.second, top, x);
        store_few(domain, sources, UNDIVIDED, place, clip, new);
        view.put_column(store.second.register, top, x, new);
    }
}

/// Cells of a column that are worked on at once.
const COLUMN: usize = 64;

/// What else is on the second bus.
#[inline]
fn extra<'b, C>(
    view: &'b View<'_, '_, C>,
    store: &FusedStore,
    starts: [usize; 1],
    after: usize,
    n: usize,
) -> Option<&'b [C]> {
    let [cells] = view.sources(&[store.extra?], &starts, after, n);
    Some(cells)
}

/// By way of a few cells of their own.
#[inline]
fn by_way<D: RowOps, const N: usize>(
    domain: &D,
    view: &mut View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &FusedStore,
    clip: Option<(f64, f64)>,
    rows: &Range<usize>,
    room: &mut [D::Cell],
) {
    let bus_inputs: [BusInput; N] = *bus_inputs.as_array().unwrap_or(&[BusInput::NONE; N]);
    let Stretch { left, at, n } =
        view.stretch(&bus_inputs, store.first.beside, store.first.border, rows);
    let starts = view.starts(&bus_inputs, at, store.first.beside);
    let more = view.starts(&[store.extra.unwrap_or(BusInput::NONE)], at, (0, 0));
    let mut done = 0;
    while done < n {
        let some = (n - done).min(RUN);
        let between = &mut room[..some];
        let operands = &view.sources(&bus_inputs, &starts, done, some);
        let place = view.place(&store.first, rows.start, left + done);
        domain.store_row(operands, store.first.share, place, between);
        if let Some(limits) = clip {
            limit(domain, between, limits);
        }
        let cells = view.take(store.second.register);
        let new = &mut cells[at + done..][..some];
        let place = view.place(&store.second, rows.start, left + done);
        match extra(view, store, more, done, some) {
            None => domain.store_row(&[between], UNDIVIDED, place, new),
            Some(extra) => domain.store_row(&[between, extra], UNDIVIDED, place, new),
        }
        if let Some(limits) = clip {
            limit(domain, new, limits);
        }
        view.put(store.second.register, cells);
        done += some;
    }
}

/// A share of a bus that has one target.
const UNDIVIDED: Share = Share { by: 1, part: None };
