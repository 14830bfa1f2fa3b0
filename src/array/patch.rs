//! A part of the array on its own: a window and a margin as wide as a body reaches, whose own
//! values come out wrong.

use std::{collections::BTreeSet, ops::Range};

use super::{
    BitPlane, State,
    tiles::{TILE, Tiles},
    window::Window,
};
use crate::{
    aligned::Aligned,
    isa::{Analog, Digital},
    plane::Size,
    program::Cell,
};

/// A part of the array, on its own.
pub(super) struct Patch<C> {
    /// The pixels that come out right.
    inner: Window,
    /// Those of the copy.
    outer: Window,
    pub(super) copy: State<C>,
}

impl<C: Clone + PartialEq> Patch<C> {
    /// Of the pixels `outer`; `copy` has their size.
    pub(super) const fn new(inner: Window, outer: Window, copy: State<C>) -> Self {
        Self { inner, outer, copy }
    }

    /// Brings the photodiodes, the masks, and these registers from the array.
    pub(super) fn cut<'a>(
        &mut self,
        state: &State<C>,
        light: &[C],
        registers: impl IntoIterator<Item = &'a Cell>,
    ) {
        let (outer, copy, width) = (&self.outer, &mut self.copy, state.layout.size.width);
        copy.input = state.input.clone();
        cut_cells(outer, width, light, &mut copy.pix);
        cut_bits(outer, &state.flag, &mut copy.flag);
        cut_bits(outer, &state.select, &mut copy.select);
        cut_bits(outer, &state.rect, &mut copy.rect);
        for cell in registers {
            match *cell {
                Cell::Analog(register) => {
                    let to = copy.analog_mut(register);
                    cut_cells(outer, width, state.analog(register), to);
                }
                Cell::Digital(register) => {
                    cut_bits(outer, state.digital(register), copy.digital_mut(register));
                }
                Cell::Flag => {}
            }
        }
    }

    /// Brings the inner part of a plane of the copy to the array; pixels that differed are
    /// marked, if that is asked for.
    pub(super) fn cells(&self, new: &[C], old: &mut [C], size: Size, marks: Option<&mut Tiles>) {
        let x = &self.inner.x;
        let rows = |y: usize| {
            let new = &new[(y - self.outer.y.start) * self.outer.x.len()..];
            (
                &new[x.start - self.outer.x.start..][..x.len()],
                y * size.width,
            )
        };
        if let Some(tiles) = marks {
            for band in self.bands() {
                let mut columns = vec![false; x.len()];
                let mut differing = None;
                for y in band {
                    let (new, at) = rows(y);
                    if differ(new, &old[at..][x.clone()], &mut columns) {
                        extend(&mut differing, y);
                    }
                }
                let Some(y) = differing else { continue };
                let lead = x.start % TILE;
                for left in (0..lead + x.len()).step_by(TILE) {
                    let tile = left.saturating_sub(lead)..(left + TILE - lead).min(x.len());
                    let mut set = tile.filter(|x| columns[*x]).map(|at| x.start + at);
                    if let Some(first) = set.next() {
                        let last = set.next_back().unwrap_or(first);
                        let x = first..last + 1;
                        tiles.mark(Window { y: y.clone(), x });
                    }
                }
            }
        }
        for y in self.inner.y.clone() {
            let (new, at) = rows(y);
            old[at..][x.clone()].clone_from_slice(new);
        }
    }

    /// The same of bits.
    pub(super) fn bits(&self, new: &BitPlane, old: &mut BitPlane, mut marks: Option<&mut Tiles>) {
        let x = &self.inner.x;
        for i in x.start / 64..x.end.div_ceil(64) {
            // The bits of the inner window.
            let low = x.start.saturating_sub(64 * i) as u32;
            let high = (64 * i + 64).saturating_sub(x.end) as u32;
            let mask = !0 << low & !0 >> high;
            for band in self.bands() {
                let (mut columns, mut differing) = (0, None);
                for y in band {
                    let from = new.row(y - self.outer.y.start);
                    let to = &mut old.row_mut(y)[i];
                    let differs = (*to ^ bits_from(from, 64 * i, self.outer.x.start)) & mask;
                    *to ^= differs;
                    if differs != 0 {
                        columns |= differs;
                        extend(&mut differing, y);
                    }
                }
                let (Some(tiles), Some(y)) = (marks.as_deref_mut(), differing) else {
                    continue;
                };
                for left in (0..64).step_by(TILE) {
                    let tile = columns >> left & ((1 << TILE) - 1);
                    if tile != 0 {
                        let at = 64 * i + left;
                        let (first, last): (u32, u32) = (tile.trailing_zeros(), tile.ilog2());
                        let x = at + first as usize..at + last as usize + 1;
                        tiles.mark(Window { y: y.clone(), x });
                    }
                }
            }
        }
    }

    /// The rows of the inner window, by tiles.
    fn bands(&self) -> impl Iterator<Item = Range<usize>> {
        let Range { start, end } = self.inner.y;
        let first = start / TILE * TILE;
        (first..end)
            .step_by(TILE)
            .map(move |y| y.max(start)..(y + TILE).min(end))
    }
}

/// One more row, below the others.
fn extend(rows: &mut Option<Range<usize>>, y: usize) {
    rows.get_or_insert(y..y).end = y + 1;
}

/// The rows of `from` inside a window.
fn cut_cells<C: Clone>(window: &Window, width: usize, from: &[C], to: &mut [C]) {
    let rows = to.chunks_exact_mut(window.x.len());
    for (y, row) in window.y.clone().zip(rows) {
        row.clone_from_slice(&from[y * width..][window.x.clone()]);
    }
}

/// The same of bits.
fn cut_bits(window: &Window, from: &BitPlane, to: &mut BitPlane) {
    let width = window.x.len();
    let last = !0 >> (width.next_multiple_of(64) - width);
    for (k, y) in window.y.clone().enumerate() {
        let from = from.row(y);
        let row = to.row_mut(k);
        for (x, word) in (window.x.start..).step_by(64).zip(&mut *row) {
            *word = bits_from(from, x, 0);
        }
        if let Some(word) = row.last_mut() {
            *word &= last;
        }
    }
}

/// The sixty-four bits from column `x` on of a row that begins at column `start`; what lies
/// before it is 0.
fn bits_from(row: &[u64], x: usize, start: usize) -> u64 {
    let Some(at) = x.checked_sub(start) else {
        return row[0] << (start - x);
    };
    let low = row[at / 64] >> (at % 64);
    if at.is_multiple_of(64) {
        low
    } else {
        low | row.get(at / 64 + 1).unwrap_or(&0) << (64 - at % 64)
    }
}

/// Where cells are others, and whether any is; without a way out, so that it runs in vectors.
fn differ<C: PartialEq>(new: &[C], old: &[C], columns: &mut [bool]) -> bool {
    let mut any = false;
    for (new, old) in new.iter().zip(old) {
        any |= new != old;
    }
    if any {
        for ((new, old), column) in new.iter().zip(old).zip(columns) {
            *column |= new != old;
        }
    }
    any
}

impl<C: Clone> Patch<C> {
    /// An empty copy of a part of this size; registers that are not among the `used` have no
    /// cells.
    pub(super) fn blank(state: &State<C>, size: Size, used: &BTreeSet<Cell>) -> State<C> {
        let layout = super::Layout {
            size,
            ..state.layout
        };
        let cells = |k: u8| {
            if used.contains(&Cell::Analog(Analog(k))) {
                Aligned::new(k.into(), state.edge.clone(), size.pixels())
            } else {
                Aligned::default()
            }
        };
        let bits = |k: u8| {
            if used.contains(&Cell::Digital(Digital(k))) {
                BitPlane::apart(size, k.into())
            } else {
                BitPlane::zeros(Size::new(0, 0))
            }
        };
        State {
            layout,
            analog: (0..layout.analog).map(cells).collect(),
            pix: Aligned::new(layout.analog.into(), state.edge.clone(), size.pixels()),
            input: state.input.clone(),
            edge: state.edge.clone(),
            digital: (0..layout.digital).map(bits).collect(),
            flag: BitPlane::zeros(size),
            select: BitPlane::zeros(size),
            rect: BitPlane::zeros(size),
        }
    }
}
