//! The bus of many pixels at once, stored.
//!
//! Cells are worked on in long runs, over the ends of rows, or under a mask in blocks of the 64
//! pixels of one word of bits. What comes from off the array is put right afterwards, pixel by
//! pixel or column by column. Sources and target are never the same plane.

use std::ops::Range;

use multiversion::multiversion;

use super::{
    super::{Place, RowOps, Share},
    operation::{BusInput, Store},
    runs::{Run, Runs, merge},
    slab::Slab,
    view::{BUS_INPUTS, Stretch, View},
};

/// Stores the bus in these rows, where the FLAG of the pixel that drives the bus is 1. `room` is
/// for [`ROOM`] cells.
#[inline(never)]
pub(super) fn store<D: RowOps>(
    domain: &D,
    view: &mut View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &Store,
    clip: Option<(f64, f64)>,
    rows: Range<usize>,
    room: &mut [D::Cell],
) {
    let cells = view.take(store.register);
    let (border, width) = (store.border, view.size.width);
    let inner = border.inside(view.size, &rows);
    let edges = border.left + border.right;
    if width <= edges || bus_inputs.len() > BUS_INPUTS {
        all(domain, view, bus_inputs, store, cells, clip, rows);
        view.put(store.register, cells);
        return;
    }
    // One run, over the ends of the rows between, if the words of bits are.
    let joined = store.whole || (edges == 0 && store.beside.1 == 0 && width.is_multiple_of(64));
    let mut y = rows.start;
    while y < rows.end {
        let inside = inner.contains(&y);
        let end = if inside && joined { inner.end } else { y + 1 };
        let rows = (y..end, inside);
        run(domain, view, bus_inputs, store, cells, clip, rows, room);
        y = end;
    }
    if edges > 0 {
        columns(domain, view, bus_inputs, store, cells, clip, &inner, room);
        for y in (rows.start..inner.start).chain(inner.end..rows.end) {
            for x in (0..border.left).chain(width - border.right..width) {
                one(domain, view, bus_inputs, store, cells, clip, y, x);
            }
        }
    }
    view.put(store.register, cells);
}

/// The same in [interior](Store::is_interior) rows.
#[inline]
pub(super) fn store_interior<D: RowOps>(
    domain: &D,
    slab: &mut Slab<'_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &Store,
    rows: &Range<usize>,
) {
    let (mut view, _) = slab.view();
    let cells = view.take(store.register);
    match *bus_inputs {
        [a] => interior(domain, &view, [a], store, cells, rows),
        [a, b] => interior(domain, &view, [a, b], store, cells, rows),
        [a, b, c] => interior(domain, &view, [a, b, c], store, cells, rows),
        _ => {}
    }
    view.put(store.register, cells);
    if store.border.left + store.border.right > 0 {
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
    store: &Store,
    rows: &Range<usize>,
) {
    let (mut view, room) = slab.view();
    let cells = view.take(store.register);
    columns(domain, &view, bus_inputs, store, cells, None, rows, room);
    view.put(store.register, cells);
}

/// With `N` bus inputs.
#[inline]
fn interior<D: RowOps, const N: usize>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: [BusInput; N],
    store: &Store,
    cells: &mut [D::Cell],
    rows: &Range<usize>,
) {
    let (at, n) = (view.cell(rows.start, 0), rows.len() * view.size.width);
    let starts = view.starts(&bus_inputs, at, store.beside);
    let sources = &view.sources(&bus_inputs, &starts, 0, n);
    let place = view.place(store, rows.start, 0);
    domain.store_row(sources, store.share, place, &mut cells[at..][..n]);
}

/// Rows as one run, inside the border or one that is not.
#[allow(clippy::too_many_arguments)]
#[inline]
fn run<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &Store,
    cells: &mut [D::Cell],
    clip: Option<(f64, f64)>,
    (rows, inside): (Range<usize>, bool),
    room: &mut [D::Cell],
) {
    let (down, right) = store.beside;
    let (mut own, wires) = ([BusInput::NONE; BUS_INPUTS], bus_inputs.len());
    own[..wires].copy_from_slice(bus_inputs);
    if !inside {
        own = view.beyond(&own, rows.start.wrapping_add_signed(-down));
    }
    let bus_inputs = &own[..wires];
    let Stretch { left, at, n } = if store.whole && inside {
        view.stretch(bus_inputs, store.beside, store.border, &rows)
    } else {
        view.between(store.border, &rows)
    };
    let starts = view.starts(&own, at, store.beside);
    let driver = rows.start.wrapping_add_signed(-down);
    // Off the array FLAG is 1.
    let mut runs = if store.whole || driver >= view.size.height {
        Runs::all(n)
    } else {
        let flags = view.flags(driver, rows.len());
        Runs::new(flags, left.wrapping_add_signed(-right), n)
    };
    while let Some(Run { from, to, all }) = runs.next() {
        let n = to - from;
        let mut sources: [&[D::Cell]; BUS_INPUTS] = [&[]; BUS_INPUTS];
        for ((source, bus_input), start) in sources.iter_mut().zip(bus_inputs).zip(starts) {
            *source = view.source(*bus_input, start.wrapping_add(from), n);
        }
        let sources = &sources[..wires];
        let old = &mut cells[at + from..][..n];
        let undivided = store.share.by == 1 && clip.is_none();
        if !all && undivided && domain.store_some(sources, runs.words(), old) {
            continue;
        }
        let new = if all { &mut *old } else { &mut room[..n] };
        let place = view.place(store, rows.start, left + from);
        domain.store_row(sources, store.share, place, new);
        if let Some(limits) = clip {
            limit(domain, new, limits);
        }
        if !all {
            merge(domain, old, &mut room[..n], runs.words());
        }
    }
}

/// Limits each cell.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn limit<D: RowOps>(domain: &D, cells: &mut [D::Cell], limits: (f64, f64)) {
    for cell in cells {
        *cell = domain.limit(cell.clone(), limits);
    }
}

/// A few cells that do not lie beside each other in their planes: no wide vectors for them.
#[inline(never)]
pub(super) fn store_few<D: RowOps>(
    domain: &D,
    operands: &[&[D::Cell]],
    share: Share,
    place: Place,
    clip: Option<(f64, f64)>,
    cells: &mut [D::Cell],
) {
    domain.store_row(operands, share, place, cells);
    if let Some(limits) = clip {
        limit(domain, cells, limits);
    }
}

/// Every cell of these rows, one by one.
#[cold]
#[inline(never)]
fn all<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &Store,
    cells: &mut [D::Cell],
    clip: Option<(f64, f64)>,
    rows: Range<usize>,
) {
    for y in rows {
        for x in 0..view.size.width {
            one(domain, view, bus_inputs, store, cells, clip, y, x);
        }
    }
}

/// One cell; any number of bus inputs, driven from on the array or from off it.
#[allow(clippy::too_many_arguments)]
fn one<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &Store,
    cells: &mut [D::Cell],
    clip: Option<(f64, f64)>,
    y: usize,
    x: usize,
) {
    let (down, right) = store.beside;
    let (from_y, from_x) = (y.wrapping_add_signed(-down), x.wrapping_add_signed(-right));
    if !view.flagged(from_y, from_x) {
        return;
    }
    let place = view.place(store, y, x);
    let sum = view.sum(domain, bus_inputs, from_y, from_x);
    let stored = domain.store(&sum, store.share, place);
    cells[view.cell(y, x)] = domain.limited(stored, clip);
}

/// The cells of these rows at the left and right border.
#[allow(clippy::too_many_arguments)]
#[inline(never)]
fn columns<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &Store,
    cells: &mut [D::Cell],
    clip: Option<(f64, f64)>,
    rows: &Range<usize>,
    room: &mut [D::Cell],
) {
    let (border, width) = (store.border, view.size.width);
    for x in (0..border.left).chain(width - border.right..width) {
        // Where the place does not matter, in vectors.
        if domain.is_steady() {
            column(domain, view, bus_inputs, store, cells, clip, rows, x, room);
        } else {
            for y in rows.clone() {
                one(domain, view, bus_inputs, store, cells, clip, y, x);
            }
        }
    }
}

/// A column, in a domain where the place does not matter.
#[allow(clippy::too_many_arguments)]
fn column<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    store: &Store,
    cells: &mut [D::Cell],
    clip: Option<(f64, f64)>,
    rows: &Range<usize>,
    x: usize,
    room: &mut [D::Cell],
) {
    if rows.is_empty() {
        return;
    }
    let (down, right) = store.beside;
    let width = view.size.width;
    let from_x = x.wrapping_add_signed(-right);
    let off = |bus_input: &BusInput| from_x.wrapping_add_signed(bus_input.beside.1) >= width;
    if from_x >= width || bus_inputs.iter().all(off) {
        // The same all along.
        let place = view.place(store, rows.start, x);
        let sum = view.sum(
            domain,
            bus_inputs,
            rows.start.wrapping_add_signed(-down),
            from_x,
        );
        let new = domain.limited(domain.store(&sum, store.share, place), clip);
        let column = cells[view.cell(rows.start, x)..].iter_mut().step_by(width);
        for (y, cell) in rows.clone().zip(column) {
            if store.whole || view.flagged(y.wrapping_add_signed(-down), from_x) {
                cell.clone_from(&new);
            }
        }
        return;
    }
    for top in rows.clone().step_by(64) {
        let n = (rows.end - top).min(64);
        let from_y = top.wrapping_add_signed(-down);
        let (new, room) = room.split_at_mut(64);
        let mut sources: [&[D::Cell]; BUS_INPUTS] = [&[]; BUS_INPUTS];
        let blocks = room.chunks_exact_mut(64).zip(bus_inputs);
        for (source, (block, bus_input)) in sources.iter_mut().zip(blocks) {
            view.column(*bus_input, from_y, from_x, &mut block[..n]);
            *source = &block[..n];
        }
        let place = view.place(store, top, x);
        let new = &mut new[..n];
        let sources = &sources[..bus_inputs.len()];
        store_few(domain, sources, store.share, place, clip, new);
        let column = cells[view.cell(top, x)..].iter_mut().step_by(width);
        for (y, (cell, new)) in (from_y..).zip(column.zip(new)) {
            if store.whole || view.flagged(y, from_x) {
                cell.clone_from(new);
            }
        }
    }
}
