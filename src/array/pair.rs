//! Two stores of the bus at once: what the first puts into a cell goes on to the second by way
//! of the machine's own registers, and into the cell only where it is read again.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::Range;

use super::{
    Domain, Place, Share,
    field::{Field, PIECE, Stretch},
    runs::RUN,
    wire::{Pair, Wire},
};

/// Does both in these rows, where FLAG is 1 in all pixels and nothing comes from above or below
/// the array. `room` is for [`ROOM`](super::store::ROOM) cells.
#[inline(always)]
pub(super) fn pair<D: Domain>(
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
    if pair.in_place || clip {
        by_way(domain, field, one, pair, clip, &rows, room);
    } else {
        match (one.len(), pair.extra) {
            (0, None) => at_once::<D, 0, 0>(domain, field, one, [], pair, &rows),
            (1, None) => at_once::<D, 1, 0>(domain, field, one, [], pair, &rows),
            (_, None) => at_once::<D, 2, 0>(domain, field, one, [], pair, &rows),
            (0, Some(extra)) => at_once::<D, 0, 1>(domain, field, one, [extra], pair, &rows),
            (1, Some(extra)) => at_once::<D, 1, 1>(domain, field, one, [extra], pair, &rows),
            (_, Some(extra)) => at_once::<D, 2, 1>(domain, field, one, [extra], pair, &rows),
        }
    }
    let width = field.size.width;
    let border = pair.first.border;
    for x in (0..border.left).chain(width - border.right..width) {
        match one.len() {
            0 => column::<D, 0>(domain, field, one, pair, clip, &rows, x, room),
            1 => column::<D, 1>(domain, field, one, pair, clip, &rows, x, room),
            _ => column::<D, 2>(domain, field, one, pair, clip, &rows, x, room),
        }
    }
}

/// The cells of these rows in a column at the left or right border.
#[allow(clippy::too_many_arguments)]
#[inline(never)]
fn column<D: Domain, const N: usize>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    clip: bool,
    rows: &Range<usize>,
    x: usize,
    room: &mut [D::Cell],
) {
    let wires: [Wire; N] = *wires.as_array().unwrap_or(&[Wire::NONE; N]);
    let (down, right) = pair.first.beside;
    for top in rows.clone().step_by(COLUMN) {
        let n = (rows.end - top).min(COLUMN);
        let (between, room) = room.split_at_mut(COLUMN);
        let (new, room) = room.split_at_mut(COLUMN);
        let (more, room) = room.split_at_mut(COLUMN);
        let (between, new, more) = (&mut between[..n], &mut new[..n], &mut more[..n]);
        let mut sources: [&[D::Cell]; N] = [&[]; N];
        let blocks = room.chunks_exact_mut(COLUMN).zip(wires);
        for (source, (block, wire)) in sources.iter_mut().zip(blocks) {
            let (y, x) = (
                top.wrapping_add_signed(-down),
                x.wrapping_add_signed(-right),
            );
            field.column(wire, y, x, &mut block[..n]);
            *source = &block[..n];
        }
        let place = field.place(&pair.first, top, x);
        domain.store_row(sources, pair.first.share, place, clip, between);
        let place = field.place(&pair.second, top, x);
        if let Some(extra) = pair.extra {
            field.column(extra, top, x, more);
            domain.store_row([&*between, more], UNDIVIDED, place, clip, new);
        } else {
            domain.store_row([&*between], UNDIVIDED, place, clip, new);
        }
        if pair.kept {
            field.put_column(pair.first.register, top, x, between);
        }
        field.put_column(pair.second.register, top, x, new);
    }
}

/// Cells of a column that are worked on at once.
const COLUMN: usize = 64;

/// `N` wires on the first bus, `M` more on the second.
#[inline(always)]
fn at_once<D: Domain, const N: usize, const M: usize>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: &[Wire],
    extra: [Wire; M],
    pair: &Pair,
    rows: &Range<usize>,
) {
    let wires: [Wire; N] = *wires.as_array().unwrap_or(&[Wire::NONE; N]);
    let Stretch { at, n, .. } = field.stretch(&wires, pair.first.beside, pair.first.border, rows);
    let starts = field.starts(&wires, at, pair.first.beside);
    let more = field.starts(&extra, at, (0, 0));
    let cells = field.take(pair.second.register);
    let between = if pair.kept {
        field.take(pair.first.register)
    } else {
        &mut []
    };
    let mut done = 0;
    while done < n {
        let some = (n - done).min(PIECE);
        let operands = field.sources(&wires, &starts, done, some);
        let extra = field.sources(&extra, &more, done, some);
        let new = &mut cells[at + done..][..some];
        let between = between.get_mut(at + done..at + done + some);
        // A division by a constant is not a division.
        match pair.first.share.by {
            1 => domain.store_pair(operands, 1, extra, between, new),
            _ => domain.store_pair(operands, 2, extra, between, new),
        }
        done += some;
    }
    if pair.kept {
        field.put(pair.first.register, between);
    }
    field.put(pair.second.register, cells);
}

/// By way of a few cells of their own.
#[inline(always)]
fn by_way<D: Domain>(
    domain: &D,
    field: &mut Field<'_, '_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    clip: bool,
    rows: &Range<usize>,
    room: &mut [D::Cell],
) {
    let Stretch { left, at, n } = field.stretch(wires, pair.first.beside, pair.first.border, rows);
    let mut done = 0;
    while done < n {
        let some = (n - done).min(RUN);
        let between = &mut room[..some];
        let one = field.place(&pair.first, rows.start, left + done);
        let from = at + done;
        match wires.len() {
            0 => first::<D, 0>(domain, field, wires, pair, from, one, clip, between),
            1 => first::<D, 1>(domain, field, wires, pair, from, one, clip, between),
            _ => first::<D, 2>(domain, field, wires, pair, from, one, clip, between),
        }
        if pair.kept {
            let cells = field.take(pair.first.register);
            cells[from..][..some].clone_from_slice(between);
            field.put(pair.first.register, cells);
        }
        let cells = field.take(pair.second.register);
        let new = &mut cells[from..][..some];
        let between = &*between;
        let two = field.place(&pair.second, rows.start, left + done);
        if let Some(extra) = pair.extra {
            let starts = field.starts(&[extra], from, (0, 0));
            let [extra] = field.sources(&[extra], &starts, 0, some);
            domain.store_row([between, extra], UNDIVIDED, two, clip, new);
        } else {
            domain.store_row([between], UNDIVIDED, two, clip, new);
        }
        field.put(pair.second.register, cells);
        done += some;
    }
}

/// A share of a bus that has one target.
const UNDIVIDED: Share = Share { by: 1, part: None };

/// What the first store puts into the cells from `from` on.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
fn first<D: Domain, const N: usize>(
    domain: &D,
    field: &Field<'_, '_, D::Cell>,
    wires: &[Wire],
    pair: &Pair,
    from: usize,
    place: Place,
    clip: bool,
    cells: &mut [D::Cell],
) {
    let wires: [Wire; N] = *wires.as_array().unwrap_or(&[Wire::NONE; N]);
    let starts = field.starts(&wires, from, pair.first.beside);
    let operands = field.sources(&wires, &starts, 0, cells.len());
    domain.store_row(operands, pair.first.share, place, clip, cells);
}
