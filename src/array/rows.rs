//! The bus along rows: the inner loops of [`semantics`](super::semantics).
//!
//! Everything here is written for vectors: a row of sums is never stored, whole rows without
//! a mask have no branch inside, and each loop is compiled for several vector widths, one of
//! which is taken when the word begins.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use super::{BitPlane, Domain, Place, Share, Undecided};
use crate::{isa::Analog, plane::Size};

/// What one source puts on the bus of every pixel.
pub(super) struct Operand<'a, C> {
    /// Row by row.
    pub(super) cells: &'a [C],
    /// From one row to the next; 0 where all rows are the same.
    pub(super) stride: usize,
    /// Where the cell lies, seen from the pixel whose bus it is.
    pub(super) beside: (isize, isize),
}

/// The bus of every pixel, before anything is stored.
pub(super) struct Bus<'a, C> {
    pub(super) size: Size,
    pub(super) operands: Vec<Operand<'a, C>>,
    /// A row of what lies off the array.
    pub(super) outside: &'a [C],
}

/// A register that stores its share of the bus.
pub(super) struct Store<'a, C> {
    pub(super) cells: &'a mut [C],
    pub(super) register: Analog,
    pub(super) share: Share,
    /// Where the cell lies, seen from the pixel whose bus it stores.
    pub(super) beside: (isize, isize),
}

/// Under which conditions a word stores.
#[derive(Clone, Copy)]
pub(super) struct When<'a> {
    /// Of the pixel whose bus it is.
    pub(super) flag: &'a BitPlane,
    pub(super) clip: bool,
    pub(super) step: u64,
}

impl<C> Bus<'_, C> {
    #[inline(always)]
    fn row(&self, operand: usize, y: usize) -> &[C] {
        let Operand {
            cells,
            stride,
            beside,
        } = &self.operands[operand];
        let y = y.wrapping_add_signed(beside.0);
        if y < self.size.height {
            &cells[y * stride..][..self.size.width]
        } else {
            self.outside
        }
    }

    /// The columns where no operand lies beyond the left or right border.
    fn inside(&self) -> (usize, usize) {
        let any = |dx| self.operands.iter().any(|operand| operand.beside.1 == dx);
        let start = usize::from(any(-1));
        (start, (self.size.width - usize::from(any(1))).max(start))
    }

    /// The bus of one pixel.
    #[inline]
    pub(super) fn sum<D: Domain<Cell = C>>(&self, domain: &D, y: usize, x: usize) -> D::Sum {
        let mut sum = domain.nothing();
        for (k, operand) in self.operands.iter().enumerate() {
            let at = x.wrapping_add_signed(operand.beside.1);
            let cell = self.row(k, y).get(at).unwrap_or_else(|| &self.outside[0]);
            domain.add(&mut sum, cell, 1);
        }
        sum
    }
}

/// Stores the bus of every pixel, where its FLAG is 1.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn store<D: Domain>(
    domain: &D,
    bus: &Bus<'_, D::Cell>,
    stores: &mut [Store<'_, D::Cell>],
    when: When<'_>,
) {
    match bus.operands.len() {
        0 => store_n::<D, 0>(domain, bus, stores, when),
        1 => store_n::<D, 1>(domain, bus, stores, when),
        2 => store_n::<D, 2>(domain, bus, stores, when),
        3 => store_n::<D, 3>(domain, bus, stores, when),
        4 => store_n::<D, 4>(domain, bus, stores, when),
        _ => {
            for y in 0..bus.size.height {
                for store in &mut *stores {
                    for x in 0..bus.size.width {
                        store_one(domain, bus, store, (y, x), when);
                    }
                }
            }
        }
    }
}

/// Of a bus with `N` operands.
#[inline(always)]
fn store_n<D: Domain, const N: usize>(
    domain: &D,
    bus: &Bus<'_, D::Cell>,
    stores: &mut [Store<'_, D::Cell>],
    when: When<'_>,
) {
    let Size { height, width } = bus.size;
    let (start, end) = bus.inside();
    let steps: [isize; N] = std::array::from_fn(|k| bus.operands[k].beside.1);
    let mut spare = vec![domain.hold(0.0); 64];
    for y in 0..height {
        let rows: [&[D::Cell]; N] = std::array::from_fn(|k| bus.row(k, y));
        let flags = when.flag.row(y);
        let whole = when.flag.is_whole(y);
        for store in &mut *stores {
            let to_y = y.wrapping_add_signed(store.beside.0);
            if to_y >= height {
                continue;
            }
            let dx = store.beside.1;
            let row = &mut store.cells[to_y * width..][..width];
            let (start, end) = (
                start.max(usize::from(dx < 0)),
                end.min(width - usize::from(dx > 0)),
            );
            let place = Place {
                y: to_y,
                x: 0,
                register: store.register,
                step: when.step,
            };
            // A row without a mask goes in one run, any other by the words of the mask.
            let runs = if whole { 1 } else { flags.len() };
            for (k, &flags) in flags[..runs].iter().enumerate() {
                let (from, to) = if whole {
                    (start, end)
                } else {
                    ((64 * k).max(start), (64 * k + 64).min(end))
                };
                if from >= to || flags == 0 {
                    continue;
                }
                let n = to - from;
                let operands: [&[D::Cell]; N] =
                    std::array::from_fn(|k| &rows[k][from.wrapping_add_signed(steps[k])..][..n]);
                let first = from.wrapping_add_signed(dx);
                let place = Place { x: first, ..place };
                let row = &mut row[first..][..n];
                if whole {
                    store_cells(domain, operands, row, store.share, place, when.clip);
                } else {
                    let spare = &mut spare[..n];
                    store_cells(domain, operands, spare, store.share, place, when.clip);
                    merge(row, spare, flags >> (from % 64));
                }
            }
            for x in (0..start).chain(end.max(start)..width) {
                store_one(domain, bus, store, (y, x), when);
            }
        }
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

/// One pixel; any number of operands, inside or not.
fn store_one<D: Domain>(
    domain: &D,
    bus: &Bus<'_, D::Cell>,
    store: &mut Store<'_, D::Cell>,
    (y, x): (usize, usize),
    when: When<'_>,
) {
    let to_y = y.wrapping_add_signed(store.beside.0);
    let to_x = x.wrapping_add_signed(store.beside.1);
    if to_y >= bus.size.height || to_x >= bus.size.width || !when.flag.get(y, x) {
        return;
    }
    let place = Place {
        y: to_y,
        x: to_x,
        register: store.register,
        step: when.step,
    };
    let stored = domain.store(&bus.sum(domain, y, x), store.share, place);
    store.cells[to_y * bus.size.width + to_x] = if when.clip {
        domain.limit(stored)
    } else {
        stored
    };
}

/// Sets the bits where the bus is above zero.
///
/// # Errors
/// In domains that have no answer.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn positive<D: Domain>(
    domain: &D,
    bus: &Bus<'_, D::Cell>,
    bits: &mut BitPlane,
) -> Result<(), Undecided> {
    match bus.operands.len() {
        1 => positive_n::<D, 1>(domain, bus, bits),
        2 => positive_n::<D, 2>(domain, bus, bits),
        3 => positive_n::<D, 3>(domain, bus, bits),
        _ => {
            for y in 0..bus.size.height {
                for x in 0..bus.size.width {
                    bits.set(y, x, is_positive(domain, &bus.sum(domain, y, x))?);
                }
            }
            Ok(())
        }
    }
}

#[inline(always)]
fn is_positive<D: Domain>(domain: &D, sum: &D::Sum) -> Result<bool, Undecided> {
    domain.positive(sum).ok_or(Undecided { operation: "where" })
}

#[inline(always)]
fn positive_n<D: Domain, const N: usize>(
    domain: &D,
    bus: &Bus<'_, D::Cell>,
    bits: &mut BitPlane,
) -> Result<(), Undecided> {
    let Size { height, width } = bus.size;
    let (start, end) = bus.inside();
    for y in 0..height {
        let rows: [&[D::Cell]; N] = std::array::from_fn(|k| bus.row(k, y));
        for (k, word) in bits.row_mut(y).iter_mut().enumerate() {
            let (from, to) = ((64 * k).max(start), (64 * k + 64).min(end));
            let n = to.saturating_sub(from);
            *word = 0;
            if n == 0 {
                continue;
            }
            let operands: [&[D::Cell]; N] = std::array::from_fn(|k| {
                &rows[k][from.wrapping_add_signed(bus.operands[k].beside.1)..][..n]
            });
            let mut bytes = [0u8; 64];
            for (i, byte) in bytes[..n].iter_mut().enumerate() {
                let sum = domain.sum(&operands, i);
                *byte = is_positive(domain, &sum)?.into();
            }
            *word = packed(&bytes) << (from % 64);
        }
        for x in (0..start).chain(end..width) {
            bits.set(y, x, is_positive(domain, &bus.sum(domain, y, x))?);
        }
    }
    Ok(())
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
        for n in [1, 15, 16, 17, 40, 64] {
            let flags = 0x9E37_79B9_7F4A_7C15;
            let (mut cells, new) = (vec![0; n], vec![1; n]);
            merge(&mut cells, &new, flags);
            for (i, cell) in cells.iter().enumerate() {
                assert_eq!(*cell, flags >> i & 1);
            }
        }
    }
}
