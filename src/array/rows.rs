//! The bus along rows: the inner loops of [`semantics`](super::semantics).
//!
//! Everything here is written for vectors: cells are worked on in long runs or, under a mask,
//! in blocks of the 64 pixels of one word of bits; each loop is compiled for several vector
//! widths, one of which is taken when the word begins. Sources and target are never the same
//! plane.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::Range;

use multiversion::multiversion;

use super::{Domain, Place, Share, Undecided};
use crate::{isa::Analog, plane::Size};

/// What one source puts on the bus of every pixel.
pub(super) struct Operand<'a, C> {
    /// Row by row.
    pub(super) cells: &'a [C],
    /// The row of the array that comes first.
    pub(super) top: usize,
    /// From one row to the next; 0 where all rows are the same.
    pub(super) stride: usize,
    /// Where the cell lies, seen from the pixel whose bus it is.
    pub(super) beside: (isize, isize),
}

impl<C> Clone for Operand<'_, C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<C> Copy for Operand<'_, C> {}

impl<'a, C> Operand<'a, C> {
    /// Some rows, beside each other in memory.
    #[inline(always)]
    fn rows(&self, from: usize, cells: usize) -> &'a [C] {
        let start = if self.stride == 0 {
            0
        } else {
            (from - self.top) * self.stride
        };
        &self.cells[start..][..cells]
    }
}

/// The bus of every pixel, before anything is stored.
pub(super) struct Bus<'a, C> {
    pub(super) size: Size,
    pub(super) operands: &'a [Operand<'a, C>],
    /// A row of what lies off the array.
    pub(super) outside: &'a [C],
}

impl<C> Clone for Bus<'_, C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<C> Copy for Bus<'_, C> {}

impl<C> Bus<'_, C> {
    /// The bus of one pixel, which may lie off the array.
    #[inline]
    pub(super) fn sum<D: Domain<Cell = C>>(&self, domain: &D, y: usize, x: usize) -> D::Sum {
        let Size { height, width } = self.size;
        let mut sum = domain.nothing();
        for operand in self.operands {
            let (to_y, to_x) = (
                y.wrapping_add_signed(operand.beside.0),
                x.wrapping_add_signed(operand.beside.1),
            );
            let inside = y < height && x < width && to_y < height && to_x < width;
            let cell = if inside {
                &operand.rows(to_y, width)[to_x]
            } else {
                &self.outside[0]
            };
            domain.add(&mut sum, cell, 1);
        }
        sum
    }

    /// The columns where no operand lies beyond the left or right border.
    fn inside(&self) -> (usize, usize) {
        let any = |dx| self.operands.iter().any(|operand| operand.beside.1 == dx);
        let start = usize::from(any(-1));
        (start, (self.size.width - usize::from(any(1))).max(start))
    }
}

/// A register that stores its share of the bus.
pub(super) struct Store<'a, C> {
    pub(super) cells: &'a mut [C],
    /// FLAG, of the pixels whose bus it is.
    pub(super) flag: &'a [u64],
    /// The row of the array that comes first in both.
    pub(super) top: usize,
    pub(super) register: Analog,
    pub(super) share: Share,
    /// Where the cell lies, seen from the pixel whose bus it stores.
    pub(super) beside: (isize, isize),
    pub(super) clip: bool,
    pub(super) step: u64,
}

impl<C> Store<'_, C> {
    /// FLAG of the pixel at (y, x) of the array.
    fn flagged(&self, size: Size, y: usize, x: usize) -> bool {
        let words = size.width.div_ceil(64);
        self.flag[(y - self.top) * words + x / 64] >> (x % 64) & 1 == 1
    }

    /// One cell; any number of operands, driven from on the array or from off it.
    fn one<D: Domain<Cell = C>>(&mut self, domain: &D, bus: &Bus<'_, C>, y: usize, x: usize) {
        let Size { height, width } = bus.size;
        let (from_y, from_x) = (
            y.wrapping_add_signed(-self.beside.0),
            x.wrapping_add_signed(-self.beside.1),
        );
        // Pixels off the array have FLAG 1.
        let inside = from_y < height && from_x < width;
        if inside && !self.flagged(bus.size, from_y, from_x) {
            return;
        }
        let place = Place {
            y,
            x,
            register: self.register,
            step: self.step,
        };
        let stored = domain.store(&bus.sum(domain, from_y, from_x), self.share, place);
        self.cells[(y - self.top) * width + x] = if self.clip {
            domain.limit(stored)
        } else {
            stored
        };
    }
}

/// Stores the bus in these rows, where the FLAG of the pixel whose bus it is is 1. `block` has
/// room for 64 cells.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn store<D: Domain>(
    domain: &D,
    bus: Bus<'_, D::Cell>,
    store: &mut Store<'_, D::Cell>,
    rows: Range<usize>,
    block: &mut [D::Cell],
) {
    match bus.operands.len() {
        0 => store_n::<D, 0>(domain, bus, store, rows, block),
        1 => store_n::<D, 1>(domain, bus, store, rows, block),
        2 => store_n::<D, 2>(domain, bus, store, rows, block),
        3 => store_n::<D, 3>(domain, bus, store, rows, block),
        4 => store_n::<D, 4>(domain, bus, store, rows, block),
        _ => {
            for y in rows {
                for x in 0..bus.size.width {
                    store.one(domain, &bus, y, x);
                }
            }
        }
    }
}

/// Of a bus with `N` operands.
#[inline(always)]
fn store_n<D: Domain, const N: usize>(
    domain: &D,
    bus: Bus<'_, D::Cell>,
    store: &mut Store<'_, D::Cell>,
    rows: Range<usize>,
    block: &mut [D::Cell],
) {
    let Size { height, width } = bus.size;
    let (down, right) = store.beside;
    let operands: [Operand<'_, D::Cell>; N] = std::array::from_fn(|k| bus.operands[k]);
    // The pixels whose bus has all its operands, and its target, on the array.
    let (mut clear, mut start, mut end) = (rows.clone(), 0, width);
    let plain = operands.iter().map(|operand| operand.beside);
    for (dy, dx) in plain.chain([(0, 0), (down, right)]) {
        // As seen from the target's row, but from the driver's column.
        let up = dy - down;
        clear.start = clear.start.max((-up).max(0) as usize);
        clear.end = clear.end.min(height.saturating_sub(up.max(0) as usize));
        start = start.max((-dx).max(0) as usize);
        end = end.min(width.saturating_sub(dx.max(0) as usize));
    }
    if end <= start {
        // Every pixel lies at a border.
        clear = rows.end..rows.end;
    }
    let first = clear.start.min(rows.end);
    let last = clear.end.clamp(first, rows.end);
    for y in (rows.start..first).chain(last..rows.end) {
        for x in 0..width {
            store.one(domain, &bus, y, x);
        }
    }
    // Rows that follow each other in memory, the words of their bits too, are one long row.
    let level = start == 0
        && end == width
        && right == 0
        && width.is_multiple_of(64)
        && operands.iter().all(|operand| operand.stride == width);
    let words = width.div_ceil(64);
    let mut y = first;
    while y < last {
        let run = if level { last - y } else { 1 };
        let from = y.wrapping_add_signed(-down);
        let n = run * width - (width - (end - start));
        let sources: [&[D::Cell]; N] = std::array::from_fn(|k| {
            let (dy, dx) = operands[k].beside;
            let row = operands[k].rows(from.wrapping_add_signed(dy), run * width);
            &row[start.wrapping_add_signed(dx).min(row.len())..][..n]
        });
        let top = store.top;
        let flags = &store.flag[(from - top) * words..][..run * words];
        let x = start.wrapping_add_signed(right);
        let cells = &mut store.cells[(y - top) * width + x..][..n];
        let place = Place {
            y,
            x,
            register: store.register,
            step: store.step,
        };
        masked(cells, flags, start, block, |i, cells| {
            let place = Place {
                x: place.x + i,
                ..place
            };
            let sources = sources.map(|source| &source[i..][..cells.len()]);
            store_cells(domain, sources, cells, store.share, place, store.clip);
        });
        if n < run * width {
            for x in (0..x).chain(x + n..width) {
                store.one(domain, &bus, y, x);
            }
        }
        y += run;
    }
}

/// Lets `fill` set the cells where FLAG is 1: whole runs at once, else by way of `block`. The
/// bit of the first cell is `offset` (under 64); `fill` gets the number of its first cell.
#[inline(always)]
fn masked<C: Clone>(
    cells: &mut [C],
    flags: &[u64],
    offset: usize,
    block: &mut [C],
    mut fill: impl FnMut(usize, &mut [C]),
) {
    let n = cells.len();
    let flags = |i: usize| {
        let low = flags[i / 64] >> offset;
        let high = flags.get(i / 64 + 1).unwrap_or(&0);
        let word = if offset == 0 {
            low
        } else {
            low | high << (64 - offset)
        };
        // Beyond the end nothing is stored in any case.
        let rest = n - i;
        if rest < 64 { word | !0 << rest } else { word }
    };
    let mut i = 0;
    while i < n {
        let mut to = i;
        while to < n && flags(to) == !0 {
            to += 64;
        }
        let whole = to > i;
        let word = if whole { !0 } else { flags(i) };
        let to = if whole { to } else { i + 64 }.min(n);
        if word != 0 {
            let target = if whole {
                &mut cells[i..to]
            } else {
                &mut block[..to - i]
            };
            fill(i, target);
            if !whole {
                merge(&mut cells[i..to], &block[..to - i], word);
            }
        }
        i = to;
    }
}

/// A run of cells, all operands inside the array.
#[inline(always)]
fn store_cells<D: Domain, const N: usize>(
    domain: &D,
    operands: [&[D::Cell]; N],
    cells: &mut [D::Cell],
    share: Share,
    place: Place,
    clip: bool,
) {
    // A division by a constant is not a division.
    match share.by {
        1 => domain.store_row(operands, Share { by: 1, ..share }, place, clip, cells),
        2 => domain.store_row(operands, Share { by: 2, ..share }, place, clip, cells),
        _ => domain.store_row(operands, share, place, clip, cells),
    }
}

/// Takes `new` where the bit is 1.
#[inline(always)]
fn merge<C: Clone>(cells: &mut [C], new: &[C], flags: u64) {
    let (cells, rest) = cells.as_chunks_mut::<16>();
    let (blocks, new_rest) = new.as_chunks::<16>();
    let mut flags = flags;
    for (cells, new) in cells.iter_mut().zip(blocks) {
        let some = flags as u16;
        for i in 0..16 {
            // One bit of its own for each: no shift by a variable.
            cells[i] = if some & 1 << i == 0 {
                cells[i].clone()
            } else {
                new[i].clone()
            };
        }
        flags = flags.unbounded_shr(16);
    }
    for (i, (cell, new)) in rest.iter_mut().zip(new_rest).enumerate() {
        if flags >> i & 1 == 1 {
            cell.clone_from(new);
        }
    }
}

/// Sets the bits of these rows where the bus is above zero; `top` is the first row of `bits`.
///
/// # Errors
/// In domains that have no answer.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn positive<D: Domain>(
    domain: &D,
    bus: Bus<'_, D::Cell>,
    bits: &mut [u64],
    top: usize,
    rows: Range<usize>,
) -> Result<(), Undecided> {
    let decided = match bus.operands.len() {
        1 => positive_n::<D, 1>(domain, bus, bits, top, rows),
        2 => positive_n::<D, 2>(domain, bus, bits, top, rows),
        3 => positive_n::<D, 3>(domain, bus, bits, top, rows),
        _ => {
            let width = bus.size.width;
            let mut decided = true;
            for y in rows {
                let row = &mut bits[(y - top) * width.div_ceil(64)..];
                for x in 0..width {
                    decided &= positive_one(domain, bus, row, y, x);
                }
            }
            decided
        }
    };
    if decided {
        Ok(())
    } else {
        Err(Undecided { operation: "where" })
    }
}

/// One pixel; whether the domain has an answer.
#[inline(always)]
fn positive_one<D: Domain>(
    domain: &D,
    bus: Bus<'_, D::Cell>,
    row: &mut [u64],
    y: usize,
    x: usize,
) -> bool {
    let answer = domain.positive(&bus.sum(domain, y, x));
    let mask = 1 << (x % 64);
    let word = &mut row[x / 64];
    *word = if answer == Some(true) {
        *word | mask
    } else {
        *word & !mask
    };
    answer.is_some()
}

#[inline(always)]
fn positive_n<D: Domain, const N: usize>(
    domain: &D,
    bus: Bus<'_, D::Cell>,
    bits: &mut [u64],
    top: usize,
    rows: Range<usize>,
) -> bool {
    let Size { height, width } = bus.size;
    let (start, end) = bus.inside();
    let words = width.div_ceil(64);
    let mut decided = true;
    for y in rows {
        let row = &mut bits[(y - top) * words..][..words];
        let sources: [&[D::Cell]; N] = std::array::from_fn(|k| {
            let operand = &bus.operands[k];
            let y = y.wrapping_add_signed(operand.beside.0);
            if y < height {
                operand.rows(y, width)
            } else {
                bus.outside
            }
        });
        for (k, word) in row.iter_mut().enumerate() {
            let (from, to) = ((64 * k).max(start), (64 * k + 64).min(end));
            let n = to.saturating_sub(from);
            *word = 0;
            if n == 0 {
                continue;
            }
            let sources: [&[D::Cell]; N] = std::array::from_fn(|k| {
                &sources[k][from.wrapping_add_signed(bus.operands[k].beside.1)..][..n]
            });
            let mut bytes = [0u8; 64];
            // No early way out: an answer is there for all pixels, or it does not matter.
            let mut set = |i: usize, byte: &mut u8| {
                let answer = domain.positive(&domain.sum(&sources, i));
                decided &= answer.is_some();
                *byte = (answer == Some(true)).into();
            };
            if n == 64 {
                for (i, byte) in bytes.iter_mut().enumerate() {
                    set(i, byte);
                }
            } else {
                for (i, byte) in bytes[..n].iter_mut().enumerate() {
                    set(i, byte);
                }
            }
            *word = packed(&bytes) << (from % 64);
        }
        for x in (0..start).chain(end..width) {
            decided &= positive_one(domain, bus, row, y, x);
        }
    }
    decided
}

/// The lowest bit of each byte.
#[inline(always)]
fn packed(bytes: &[u8; 64]) -> u64 {
    let (eights, _) = bytes.as_chunks::<8>();
    let mut word = 0;
    for (k, eight) in eights.iter().enumerate() {
        // The product brings bit 8i to bit 56 + i, and nothing else there.
        let top = u64::from_le_bytes(*eight).wrapping_mul(0x0102_0408_1020_4080) >> 56;
        word |= top << (8 * k);
    }
    word
}

/// Stores `gain` times the square of the bus in these rows, where FLAG is 1.
///
/// # Errors
/// In domains that have no answer.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn square<D: Domain>(
    domain: &D,
    bus: Bus<'_, D::Cell>,
    store: &mut Store<'_, D::Cell>,
    gain: f64,
    rows: Range<usize>,
) -> Result<(), Undecided> {
    let width = bus.size.width;
    for y in rows {
        for x in 0..width {
            let place = Place {
                y,
                x,
                register: store.register,
                step: store.step,
            };
            let square = domain.square(&bus.sum(domain, y, x), gain, place);
            let cell = square.ok_or(Undecided { operation: "sq" })?;
            if store.flagged(bus.size, y, x) {
                store.cells[(y - store.top) * width + x] =
                    if store.clip { domain.limit(cell) } else { cell };
            }
        }
    }
    Ok(())
}

/// A row of the diffusion network.
pub(super) struct Links<'a, C> {
    /// What each pixel holds, and what its neighbours hold, in the order of the directions;
    /// beyond the border anything.
    pub(super) own: &'a [C],
    pub(super) beside: [&'a [C]; 4],
    /// Where the link to each neighbour conducts.
    pub(super) linked: [&'a [u64]; 4],
    /// A pixel's own cell against one link.
    pub(super) parts: i32,
}

/// Stores one step of diffusion along the row `place`, where FLAG is 1.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn diffuse<D: Domain>(
    domain: &D,
    links: &Links<'_, D::Cell>,
    flags: &[u64],
    place: Place,
    clip: bool,
    cells: &mut [D::Cell],
    block: &mut [D::Cell],
) {
    let share = Share {
        by: links.parts as u32,
        part: None,
    };
    let width = cells.len();
    masked(cells, flags, 0, block, |first, cells| {
        for (i, cell) in (first..).zip(cells) {
            let mut sum = domain.nothing();
            let mut own = links.parts;
            for (k, linked) in links.linked.iter().enumerate() {
                if linked[i / 64] >> (i % 64) & 1 == 1 {
                    // East and west are rows that begin one later or earlier.
                    let at = match k {
                        1 => (i + 1).min(width - 1),
                        3 => i.saturating_sub(1),
                        _ => i,
                    };
                    domain.add(&mut sum, &links.beside[k][at], 1);
                    own -= 1;
                }
            }
            domain.add(&mut sum, &links.own[i], own);
            let stored = domain.store(&sum, share, Place { x: i, ..place });
            *cell = if clip { domain.limit(stored) } else { stored };
        }
    });
}

/// Sets pixels from light, as one exposure does.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn expose<D: Domain>(
    domain: &D,
    reset_level: f64,
    gain: f64,
    light: &[f64],
    cells: &mut [D::Cell],
) {
    for (cell, light) in cells.iter_mut().zip(light) {
        *cell = domain.hold(reset_level + gain * light);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_bits() {
        for word in [0, 1, !0, 0x8000_0000_0000_0001, 0x0123_4567_89AB_CDEF] {
            let bytes = std::array::from_fn(|i| (word >> i & 1) as u8);
            assert_eq!(packed(&bytes), word);
        }
    }

    #[test]
    fn only_flagged_cells_change() {
        let flags = [0x9E37_79B9_7F4A_7C15, !0, !0, 0, 0xF0F0_F0F0_F0F0_F0F0, !0];
        for n in [1usize, 15, 16, 17, 40, 64, 65, 130, 200, 300] {
            for offset in [0, 1] {
                let mut cells = vec![0; n];
                masked(&mut cells, &flags, offset, &mut [0; 64], |first, cells| {
                    for (i, cell) in cells.iter_mut().enumerate() {
                        *cell = 1 + first + i;
                    }
                });
                for (i, cell) in cells.iter().enumerate() {
                    let bit = i + offset;
                    let on = flags[bit / 64] >> (bit % 64) & 1 == 1;
                    assert_eq!(*cell, if on { i + 1 } else { 0 });
                }
            }
        }
    }
}
