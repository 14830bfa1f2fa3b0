//! Two stores of the bus at once: what the first puts into a cell goes on to the second by way
//! of the machine's own registers, and never into the cell.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::Range;

use super::{
    RowOps, Share,
    band::Band,
    field::{Field, Stretch, WIRES},
    runs::RUN,
    store::{limit, store_few},
    wire::{Pair, Wire},
};

/// Does both in these rows, where FLAG is 1 in all pixels and nothing comes from above or below
/// the array. `room` is for [`ROOM`](super::store::ROOM) cells.
#[inline(always)]
pub(super) fn pair<D: RowOps>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    clip: bool,
    rows: Range<usize>,
    room: &mut [D::Cell],
) {
    if rows.is_empty() {
        return;
    }
    let one = &wires[pair.first.wires.clone()];
    match one.len() {
        0 => by_way::<D, 0>(domain, field, one, pair, clip, &rows, room),
        1 => by_way::<D, 1>(domain, field, one, pair, clip, &rows, room),
        _ => by_way::<D, 2>(domain, field, one, pair, clip, &rows, room),
    }
    columns(domain, field, one, pair, clip, &rows, room);
}

/// The same in [level](super::wire::Store::is_level) rows.
#[inline(always)]
pub(super) fn pair_level<D: RowOps>(
    domain: &D,
    band: &mut Band<'_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    rows: &Range<usize>,
) {
    let (mut field, _) = band.field();
    let target = usize::from(pair.second.register.0);
    match *wires {
        [_] if pair.own => level(domain, &mut field, [], pair, rows),
        [a] => level(domain, &mut field, [a], pair, rows),
        [a, b] if pair.own => {
            let other = if a.plane == target { b } else { a };
            level(domain, &mut field, [other], pair, rows);
        }
        [a, b] => level(domain, &mut field, [a, b], pair, rows),
        _ => {}
    }
    if pair.first.border.left + pair.first.border.right > 0 {
        columns_of(domain, band, wires, pair, rows);
    }
}

/// The cells at the left and right border, in a band: what is called sees no field that loops
/// keep in the machine's registers.
#[inline(never)]
fn columns_of<D: RowOps>(
    domain: &D,
    band: &mut Band<'_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    rows: &Range<usize>,
) {
    let (mut field, room) = band.field();
    columns(domain, &mut field, wires, pair, false, rows, room);
}

/// With `N` wires, besides the cell itself.
#[inline(always)]
fn level<D: RowOps, const N: usize>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: [Wire; N],
    pair: &Pair,
    rows: &Range<usize>,
) {
    let cells = field.take(pair.second.register);
    let (at, n) = (field.cell(rows.start, 0), rows.len() * field.size.width);
    let starts = field.starts(&wires, at, pair.first.beside);
    let operands = &field.sources(&wires, &starts, 0, n);
    let extra = extra(field, pair, &[at], 0, n);
    let new = &mut cells[at..][..n];
    domain.store_pair(operands, pair.own, pair.first.share.by, extra, new);
    field.put(pair.second.register, cells);
}

/// The cells of these rows at the left and right border.
#[inline(always)]
fn columns<D: RowOps>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    clip: bool,
    rows: &Range<usize>,
    room: &mut [D::Cell],
) {
    let width = field.size.width;
    let border = pair.first.border;
    for x in (0..border.left).chain(width - border.right..width) {
        column(domain, field, wires, pair, clip, rows, x, room);
    }
}

/// The cells of these rows in one of those columns.
#[allow(clippy::too_many_arguments)]
#[inline(never)]
fn column<D: RowOps>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    clip: bool,
    rows: &Range<usize>,
    x: usize,
    room: &mut [D::Cell],
) {
    let (down, right) = pair.first.beside;
    let from_x = x.wrapping_add_signed(-right);
    let off = |wire: &Wire| from_x.wrapping_add_signed(wire.beside.1) >= field.size.width;
    if pair.extra.is_none() && wires.iter().all(off) {
        // The same all along.
        let y = rows.start.wrapping_add_signed(-down);
        let place = field.place(&pair.first, rows.start, x);
        let sum = field.sum(domain, wires, y, from_x);
        let between = domain.limited(domain.store(&sum, pair.first.share, place), clip);
        let place = field.place(&pair.second, rows.start, x);
        let sum = domain.sum(&[&[between]], 0);
        let new = domain.limited(domain.store(&sum, UNDIVIDED, place), clip);
        field.fill_column(pair.second.register, rows, x, &new);
        return;
    }
    for top in rows.clone().step_by(COLUMN) {
        let n = (rows.end - top).min(COLUMN);
        let (between, room) = room.split_at_mut(COLUMN);
        let (new, room) = room.split_at_mut(COLUMN);
        let (more, room) = room.split_at_mut(COLUMN);
        let (between, new, more) = (&mut between[..n], &mut new[..n], &mut more[..n]);
        let mut sources: [&[D::Cell]; WIRES] = [&[]; WIRES];
        let blocks = room.chunks_exact_mut(COLUMN).zip(wires);
        for (source, (block, wire)) in sources.iter_mut().zip(blocks) {
            let (y, x) = (
                top.wrapping_add_signed(-down),
                x.wrapping_add_signed(-right),
            );
            field.column(*wire, y, x, &mut block[..n]);
            *source = &block[..n];
        }
        let sources = &sources[..wires.len()];
        let place = field.place(&pair.first, top, x);
        store_few(domain, sources, pair.first.share, place, clip, between);
        let mut sources: [&[D::Cell]; 2] = [between, &[]];
        if let Some(extra) = pair.extra {
            field.column(extra, top, x, more);
            sources[1] = more;
        }
        let sources = &sources[..=usize::from(pair.extra.is_some())];
        let place = field.place(&pair.second, top, x);
        store_few(domain, sources, UNDIVIDED, place, clip, new);
        field.put_column(pair.second.register, top, x, new);
    }
}

/// Cells of a column that are worked on at once.
const COLUMN: usize = 64;

/// What else is on the second bus.
#[inline(always)]
fn extra<'b, C>(
    field: &'b Field<'_, '_, C>,
    pair: &Pair,
    starts: &[usize; 1],
    after: usize,
    n: usize,
) -> Option<&'b [C]> {
    let [cells] = field.sources(&[pair.extra?], starts, after, n);
    Some(cells)
}

/// By way of a few cells of their own.
#[inline(always)]
fn by_way<D: RowOps, const N: usize>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    clip: bool,
    rows: &Range<usize>,
    room: &mut [D::Cell],
) {
    let wires: [Wire; N] = *wires.as_array().unwrap_or(&[Wire::NONE; N]);
    let Stretch { left, at, n } = field.stretch(&wires, pair.first.beside, pair.first.border, rows);
    let starts = field.starts(&wires, at, pair.first.beside);
    let more = field.starts(&[pair.extra.unwrap_or(Wire::NONE)], at, (0, 0));
    let mut done = 0;
    while done < n {
        let some = (n - done).min(RUN);
        let between = &mut room[..some];
        let operands = &field.sources(&wires, &starts, done, some);
        let place = field.place(&pair.first, rows.start, left + done);
        domain.store_row(operands, pair.first.share, place, between);
        if clip {
            limit(domain, between);
        }
        let cells = field.take(pair.second.register);
        let new = &mut cells[at + done..][..some];
        let place = field.place(&pair.second, rows.start, left + done);
        match extra(field, pair, &more, done, some) {
            None => domain.store_row(&[between], UNDIVIDED, place, new),
            Some(extra) => domain.store_row(&[between, extra], UNDIVIDED, place, new),
        }
        if clip {
            limit(domain, new);
        }
        field.put(pair.second.register, cells);
        done += some;
    }
}

/// A share of a bus that has one target.
const UNDIVIDED: Share = Share { by: 1, part: None };
