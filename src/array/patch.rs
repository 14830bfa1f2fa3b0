//! A part of the array on its own: a window and a margin as wide as a body reaches, whose own
//! values come out wrong.

use super::{
    BitPlane, State,
    cells::Cells,
    tiles::{TILE, Tiles},
    window::Window,
};
use crate::{
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

    /// Brings the inner part of a plane of the copy to the array; tiles in which it differed
    /// are marked, if that is asked for.
    pub(super) fn cells(
        &self,
        new: &[C],
        old: &mut [C],
        size: Size,
        mut marks: Option<&mut Tiles>,
    ) {
        let Window { y: rows, x } = &self.inner;
        for y in rows.clone() {
            let new = &new[(y - self.outer.y.start) * self.outer.x.len()..];
            let new = &new[x.start - self.outer.x.start..][..x.len()];
            let old = &mut old[y * size.width..][x.clone()];
            if let Some(tiles) = &mut marks {
                let marks = tiles.row_mut(y);
                for left in (x.start / TILE * TILE..x.end).step_by(TILE) {
                    let tile = left.max(x.start) - x.start..(left + TILE).min(x.end) - x.start;
                    let mark = &mut marks[left / TILE];
                    *mark = *mark || differ(&new[tile.clone()], &old[tile]);
                }
            }
            old.clone_from_slice(new);
        }
    }

    /// The same of bits.
    pub(super) fn bits(&self, new: &BitPlane, old: &mut BitPlane, mut marks: Option<&mut Tiles>) {
        let Window { y: rows, x } = &self.inner;
        for y in rows.clone() {
            let from = new.row(y - self.outer.y.start);
            let row = old.row_mut(y);
            for (i, to) in (0..).zip(row).take(x.end.div_ceil(64)).skip(x.start / 64) {
                // The bits of the inner window.
                let low = x.start.saturating_sub(64 * i) as u32;
                let high = (64 * i + 64).saturating_sub(x.end) as u32;
                let mask = !0 << low & !0 >> high;
                let differs = (*to ^ bits_from(from, 64 * i, self.outer.x.start)) & mask;
                *to ^= differs;
                let Some(tiles) = marks.as_deref_mut().filter(|_| differs != 0) else {
                    continue;
                };
                let marks = tiles.row_mut(y).iter_mut().skip(64 * i / TILE);
                for (mark, tile) in marks.zip((0..64).step_by(TILE)) {
                    *mark |= differs >> tile & ((1 << TILE) - 1) != 0;
                }
            }
        }
    }
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

/// Whether any cell is another; without a way out, so that it runs in vectors.
fn differ<C: PartialEq>(new: &[C], old: &[C]) -> bool {
    let both = new.iter().zip(old);
    both.fold(false, |any, (new, old)| any | (new != old))
}

impl<C: Clone> Patch<C> {
    /// An empty copy of a part of this size; registers that are not among the `used` have no
    /// cells.
    pub(super) fn blank(
        state: &State<C>,
        size: Size,
        used: &std::collections::BTreeSet<Cell>,
    ) -> State<C> {
        let layout = super::Layout {
            size,
            ..state.layout
        };
        let cells = |k: u8| {
            if used.contains(&Cell::Analog(Analog(k))) {
                Cells::new(k.into(), state.edge.clone(), size.pixels())
            } else {
                Cells::default()
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
            pix: Cells::new(layout.analog.into(), state.edge.clone(), size.pixels()),
            input: state.input.clone(),
            edge: state.edge.clone(),
            digital: (0..layout.digital).map(bits).collect(),
            flag: BitPlane::zeros(size),
            select: BitPlane::zeros(size),
            rect: BitPlane::zeros(size),
        }
    }
}
