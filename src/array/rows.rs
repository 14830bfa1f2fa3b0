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
use crate::{
    bits::{packed, spread},
    isa::Analog,
    plane::Size,
};

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
        self.cells[(y - self.top) * width + x] = domain.limited(stored, self.clip);
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
        let mut runs = Runs::new(flags, start, n);
        while let Some(Run { from, to, some }) = runs.next() {
            let place = Place {
                x: place.x + from,
                ..place
            };
            let sources: [&[D::Cell]; N] = std::array::from_fn(|k| &sources[k][from..to]);
            let cells = &mut cells[from..to];
            let new = if some.is_some() {
                &mut block[..to - from]
            } else {
                &mut *cells
            };
            store_cells(domain, sources, new, store.share, place, store.clip);
            if let Some(some) = some {
                merge(domain, cells, &block[..to - from], some);
            }
        }
        if n < run * width {
            for x in (0..x).chain(x + n..width) {
                store.one(domain, &bus, y, x);
            }
        }
        y += run;
    }
}

/// Cells under a mask, in runs: whole ones, and blocks of the pixels of one word of bits.
struct Runs<'a> {
    flags: &'a [u64],
    /// The bit of the first cell, under 64.
    offset: usize,
    cells: usize,
    next: usize,
    /// Whether all bits are 1.
    whole: bool,
}

/// Some cells beside each other.
struct Run {
    from: usize,
    to: usize,
    /// Which of at most 64; none where it is all of any number.
    some: Option<u64>,
}

impl<'a> Runs<'a> {
    #[inline(always)]
    fn new(flags: &'a [u64], offset: usize, cells: usize) -> Self {
        Self {
            flags,
            offset,
            cells,
            next: 0,
            whole: flags.iter().fold(!0, |all, word| all & word) == !0,
        }
    }

    /// The bits of 64 cells; beyond the last all 1.
    #[inline(always)]
    fn word(&self, i: usize) -> u64 {
        let bit = self.offset + i;
        let low = self.flags[bit / 64] >> (bit % 64);
        let word = if bit.is_multiple_of(64) {
            low
        } else {
            low | self.flags.get(bit / 64 + 1).unwrap_or(&0) << (64 - bit % 64)
        };
        let rest = self.cells - i;
        if rest < 64 { word | !0 << rest } else { word }
    }

    /// The next cells of which at least one is to be stored.
    #[inline(always)]
    fn next(&mut self) -> Option<Run> {
        let mut from = self.next;
        if self.whole && from < self.cells {
            self.next = self.cells;
            return Some(Run {
                from,
                to: self.cells,
                some: None,
            });
        }
        while from < self.cells {
            let mut to = from + 64;
            if to > self.cells && self.cells >= 64 {
                // The last block may be in part the same as the one before it: what is stored
                // twice is stored alike.
                from = self.cells - 64;
                to = self.cells;
            }
            let word = self.word(from);
            if word == !0 {
                while to < self.cells && self.word(to) == !0 {
                    to += 64;
                }
            }
            let to = to.min(self.cells);
            let rest = to - from;
            // What lies beyond the end is none of the cells.
            let none = if rest < 64 { !0 << rest } else { 0 };
            if word != none {
                self.next = to;
                let some = (word != !0).then_some(word);
                return Some(Run { from, to, some });
            }
            from = to;
        }
        None
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

/// A word of a chain: one bus of one or two registers into one register of the same pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) target: Analog,
    /// Into one or two parts.
    pub(super) share: Share,
    pub(super) sources: [Analog; 2],
    /// Whether there is a second source.
    pub(super) two: bool,
    pub(super) step: u64,
}

/// Bytes of a register that go through a chain at once: those of all registers fit into the
/// cache next to a core.
const PIECE: usize = 4096;

/// Runs words one after the other, a piece of the cells at a time, where FLAG is 1 in all of
/// them. They begin at `place`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn chain<D: Domain>(
    domain: &D,
    planes: &mut [&mut [D::Cell]],
    links: &[Link],
    cells: Range<usize>,
    place: Place,
    clip: bool,
) {
    let piece = PIECE / size_of::<D::Cell>().clamp(1, PIECE);
    let mut from = cells.start;
    while from < cells.end {
        let to = (from + piece).min(cells.end);
        let x = place.x + from - cells.start;
        for link in links {
            let place = Place {
                x,
                register: link.target,
                step: link.step,
                ..place
            };
            let target = std::mem::take(&mut planes[usize::from(link.target.0)]);
            let [one, two] = link.sources.map(|source| usize::from(source.0));
            let new = &mut target[from..to];
            if link.two {
                let operands = [&planes[one][from..to], &planes[two][from..to]];
                link_cells(domain, operands, new, link.share, place, clip);
            } else {
                link_cells(
                    domain,
                    [&planes[one][from..to]],
                    new,
                    link.share,
                    place,
                    clip,
                );
            }
            planes[usize::from(link.target.0)] = target;
        }
        from = to;
    }
}

/// As [`store_cells`], of a share that a chain may have.
#[inline(always)]
fn link_cells<D: Domain, const N: usize>(
    domain: &D,
    operands: [&[D::Cell]; N],
    cells: &mut [D::Cell],
    share: Share,
    place: Place,
    clip: bool,
) {
    if share.by == 1 {
        domain.store_row(operands, Share { by: 1, ..share }, place, clip, cells);
    } else {
        domain.store_row(operands, Share { by: 2, ..share }, place, clip, cells);
    }
}

/// Takes `new` where the bit is 1; of at most 64 cells.
#[inline(always)]
fn merge<D: Domain>(domain: &D, cells: &mut [D::Cell], new: &[D::Cell], flags: u64) {
    let ones = spread(flags);
    if let (Some(cells), Some(new)) = (cells.as_mut_array::<64>(), new.as_array::<64>()) {
        // By value: nothing that is read can be what was just written.
        let (old, new) = (cells.clone(), new.clone());
        for (i, cell) in cells.iter_mut().enumerate() {
            *cell = domain.choose(&old[i], &new[i], ones[i]);
        }
    } else {
        for ((cell, new), one) in cells.iter_mut().zip(new).zip(ones) {
            if one == 1 {
                cell.clone_from(new);
            }
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
    let bits = &mut bits[(rows.start - top) * words..(rows.end - top) * words];
    // Some blocks at once: bytes that were just written are slow to read in another width.
    let mut bytes = [[0u8; 64]; 8];
    let (mut y, mut k) = (rows.start, 0);
    for batch in bits.chunks_mut(bytes.len()) {
        for bytes in &mut bytes[..batch.len()] {
            let (from, to) = ((64 * k).max(start), (64 * k + 64).min(end));
            let n = to.saturating_sub(from);
            let sources: [&[D::Cell]; N] = std::array::from_fn(|k| {
                let operand = &bus.operands[k];
                let y = y.wrapping_add_signed(operand.beside.0);
                let row = if y < height {
                    operand.rows(y, width)
                } else {
                    bus.outside
                };
                let from = from.wrapping_add_signed(operand.beside.1).min(width);
                &row[from..][..n]
            });
            decided &= if n == 64 {
                domain.positives(sources, bytes)
            } else {
                bytes.fill(0);
                domain.positives(sources, &mut bytes[from % 64..][..n])
            };
            k += 1;
            if k == words {
                (y, k) = (y + 1, 0);
            }
        }
        for (word, bytes) in batch.iter_mut().zip(&bytes) {
            *word = packed(bytes);
        }
    }
    if start > 0 || end < width {
        for (y, row) in rows.zip(bits.chunks_mut(words)) {
            for x in (0..start).chain(end..width) {
                decided &= positive_one(domain, bus, row, y, x);
            }
        }
    }
    decided
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
                store.cells[(y - store.top) * width + x] = domain.limited(cell, store.clip);
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
    let mut runs = Runs::new(flags, 0, width);
    while let Some(Run { from, to, some }) = runs.next() {
        let cells = &mut cells[from..to];
        let new = if some.is_some() {
            &mut block[..to - from]
        } else {
            &mut *cells
        };
        for (i, cell) in (from..).zip(new) {
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
            *cell = domain.limited(stored, clip);
        }
        if let Some(some) = some {
            merge(domain, cells, &block[..to - from], some);
        }
    }
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
    use crate::array::Exact;

    #[test]
    fn only_flagged_cells_change() {
        let flags = [0x9E37_79B9_7F4A_7C15, !0, !0, 0, 0xF0F0_F0F0_F0F0_F0F0, !0];
        for n in [1usize, 15, 16, 17, 40, 64, 65, 130, 200, 300] {
            for offset in [0, 1] {
                let mut cells = vec![0.0; n];
                let mut runs = Runs::new(&flags, offset, n);
                while let Some(Run { from, to, some }) = runs.next() {
                    let new: Vec<_> = (from + 1..=to).map(|i| i as f64).collect();
                    match some {
                        Some(some) => merge(&Exact, &mut cells[from..to], &new, some),
                        None => cells[from..to].clone_from_slice(&new),
                    }
                }
                for (i, cell) in cells.iter().enumerate() {
                    let bit = i + offset;
                    let on = flags[bit / 64] >> (bit % 64) & 1 == 1;
                    assert_eq!(*cell, if on { (i + 1) as f64 } else { 0.0 });
                }
            }
        }
    }
}
