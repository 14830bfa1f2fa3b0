//! One readout of the chip: the set pixels of a register, in the order of
//! [`event::readout::scan`](crate::event::readout::scan).

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::RangeInclusive;

use multiversion::multiversion;

use super::BitPlane;
use crate::{
    event::readout::scan::{Address, Order},
    plane::{At, Size},
};

/// One readout of set pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scanned {
    /// The pixels that found a slot, in the chip's order, in image coordinates.
    pub found: Vec<At>,
    /// Set pixels without a slot.
    pub missed: u64,
    /// Whether the pixel at the chip's (0,0) is among those found: a host that takes (0,0) for
    /// the end of the list loses it.
    pub ambiguous: bool,
}

impl Scanned {
    /// Reads `bits` out into `slots`, from the chip's origin, or from the far end of the
    /// columns or rows.
    #[must_use]
    pub fn new(bits: &BitPlane, size: Size, slots: u32, order: Order) -> Self {
        let all = bits.count() as usize;
        let some = all.min(slots as usize);
        let mut found = vec![At { y: 0, x: 0 }; some];
        if order.from_bottom {
            find::<true>(bits, size, order.from_left, &mut found);
        } else {
            find::<false>(bits, size, order.from_left, &mut found);
        }
        Self::of_slots(bits, size, found)
    }

    /// Reads `bits` out into `slots`, row by row.
    #[must_use]
    pub fn by_rows(bits: &BitPlane, size: Size, slots: u32, order: Order) -> Self {
        let pixels =
            { order.rows(size) }.flat_map(|y| order.columns(size).map(move |x| At { y, x }));
        let set = pixels.filter(|at| bits.get(at.y, at.x));
        Self::of_slots(bits, size, set.take(slots as usize).collect())
    }

    /// Those that found a slot, and what follows from it.
    fn of_slots(bits: &BitPlane, size: Size, found: Vec<At>) -> Self {
        let origin = Address::ORIGIN.at(size);
        Self {
            missed: bits.count() - found.len() as u64,
            ambiguous: origin.is_some_and(|at| bits.get(at.y, at.x) && found.contains(&at)),
            found,
        }
    }

    /// All set pixels of some rows, as the host finds them in whole rows of bits: row by row, each
    /// from the right. None is missed, and none is ambiguous.
    #[must_use]
    pub fn of_rows(bits: &BitPlane, size: Size, rows: RangeInclusive<usize>) -> Self {
        let rows = *rows.start()..(*rows.end() + 1).min(size.height);
        let pixels = rows.flat_map(|y| (0..size.width).rev().map(move |x| At { y, x }));
        Self {
            found: pixels.filter(|at| bits.get(at.y, at.x)).collect(),
            missed: 0,
            ambiguous: false,
        }
    }
}

/// The first pixels that are 1, as many as there is room for.
#[multiversion(targets("x86_64+avx2+bmi1+bmi2+lzcnt", "aarch64+neon"))]
fn find<const FROM_BOTTOM: bool>(bits: &BitPlane, size: Size, from_left: bool, found: &mut [At]) {
    let mut free = found.iter_mut();
    let blocks = size.width.div_ceil(64);
    let mut columns = Columns::new(size);
    for k in 0..blocks {
        let left = if from_left { k } else { blocks - 1 - k };
        if free.len() > 0 && columns.turn(bits, left) {
            for x in 0..64 {
                let x = if from_left { x } else { 63 - x };
                columns.each::<FROM_BOTTOM>(x, &mut free);
            }
        }
    }
}

/// Sixty-four columns, each as bits of its own, from the top.
struct Columns {
    height: usize,
    /// The first.
    left: usize,
    /// Words of a column.
    words: usize,
    /// Column by column.
    bits: Vec<u64>,
    /// Which words hold a 1 in any column.
    any: Vec<bool>,
}

impl Columns {
    fn new(size: Size) -> Self {
        let words = size.height.div_ceil(64);
        Self {
            height: size.height,
            left: 0,
            words,
            bits: vec![0; 64 * words],
            any: vec![false; words],
        }
    }

    /// Takes those in word `left` of each row; whether any pixel is 1.
    #[inline(always)]
    fn turn(&mut self, plane: &BitPlane, left: usize) -> bool {
        let across = plane.words().len() / self.height;
        self.left = 64 * left;
        let squares = plane.words().chunks(64 * across);
        for ((k, any), rows) in self.any.iter_mut().enumerate().zip(squares) {
            let mut square = [0; 64];
            for (row, word) in square
                .iter_mut()
                .zip(rows.iter().skip(left).step_by(across))
            {
                *row = *word;
            }
            *any = square.iter().fold(0, |any, row| any | row) != 0;
            if *any {
                transpose(&mut square);
                let words = self.bits.iter_mut().skip(k).step_by(self.words);
                for (word, column) in words.zip(square) {
                    *word = column;
                }
            }
        }
        self.any.contains(&true)
    }

    /// Puts the pixels of a column that are 1 into the free slots, as long as there are any.
    #[inline(always)]
    fn each<const FROM_BOTTOM: bool>(&self, x: usize, free: &mut std::slice::IterMut<'_, At>) {
        let column = &self.bits[x * self.words..][..self.words];
        for k in 0..self.words {
            let k = if FROM_BOTTOM { self.words - 1 - k } else { k };
            let mut word = if self.any[k] { column[k] } else { 0 };
            while word != 0 {
                let bit = if FROM_BOTTOM {
                    let bit = word.ilog2();
                    word ^= 1 << bit;
                    bit
                } else {
                    let bit = word.trailing_zeros();
                    // Without its lowest 1.
                    word &= word - 1;
                    bit
                };
                let Some(slot) = free.next() else { return };
                *slot = At {
                    y: 64 * k + bit as usize,
                    x: self.left + x,
                };
            }
        }
    }
}

/// Rows become columns: blocks of 32, of 16, down to one, change places.
#[inline(always)]
fn transpose(square: &mut [u64; 64]) {
    let mut by = 32;
    let mut mask = 0xFFFF_FFFF;
    while by != 0 {
        for block in square.chunks_exact_mut(2 * by) {
            let (upper, lower) = block.split_at_mut(by);
            for (upper, lower) in upper.iter_mut().zip(lower) {
                let moved = (*upper >> by ^ *lower) & mask;
                *upper ^= moved << by;
                *lower ^= moved;
            }
        }
        by /= 2;
        mask ^= mask << by;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::readout::scan::Order;
    use proptest::prelude::*;

    #[test]
    fn rows_become_columns() {
        let hash = |i: u64| (i + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let rows: [u64; 64] = std::array::from_fn(|i| hash(i as u64) ^ hash(i as u64) >> 29);
        let mut columns = rows;
        transpose(&mut columns);
        for (y, row) in rows.iter().enumerate() {
            for (x, column) in columns.iter().enumerate() {
                assert_eq!(row >> x & 1, column >> y & 1);
            }
        }
    }

    #[test]
    fn rows_of_bits_are_found_row_by_row() {
        let size = Size::new(4, 70);
        let mut bits = BitPlane::zeros(size);
        for (y, x) in [(0, 3), (1, 2), (1, 69), (3, 0)] {
            bits.set(y, x, true);
        }
        let scan = Scanned::of_rows(&bits, size, 1..=255);
        let found: Vec<_> = scan.found.iter().map(|at| (at.y, at.x)).collect();
        assert_eq!(found, [(1, 69), (1, 2), (3, 0)]);
        assert_eq!((scan.missed, scan.ambiguous), (0, false));
    }

    proptest! {
        /// Against a walk over all pixels in order.
        #[test]
        fn pixels_are_found_in_order(
            (height, width) in (1usize..140, 1usize..140), seed: u64, most in 1u64..40,
            slots in 0u32..400, from_left: bool, from_bottom: bool
        ) {
            let size = Size::new(height, width);
            let mut bits = BitPlane::zeros(size);
            for y in 0..height {
                for x in 0..width {
                    let hash = (seed ^ (y * width + x) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                    bits.set(y, x, (hash >> 32).is_multiple_of(most));
                }
            }
            let order = Order { from_left, from_bottom };
            let all: Vec<_> = order
                .columns(size)
                .flat_map(|x| order.rows(size).map(move |y| At { y, x }))
                .filter(|at| bits.get(at.y, at.x))
                .collect();
            let some = all.len().min(slots as usize);
            let scan = Scanned::new(&bits, size, slots, order);
            prop_assert_eq!(&scan.found[..], &all[..some]);
            prop_assert_eq!(scan.missed, (all.len() - some) as u64);
            let origin = At { y: 0, x: width - 1 };
            prop_assert_eq!(scan.ambiguous, all[..some].contains(&origin));
            let all: Vec<_> = order
                .rows(size)
                .flat_map(|y| order.columns(size).map(move |x| At { y, x }))
                .filter(|at| bits.get(at.y, at.x))
                .collect();
            let scan = Scanned::by_rows(&bits, size, slots, order);
            prop_assert_eq!(&scan.found[..], &all[..some]);
            prop_assert_eq!(scan.missed, (all.len() - some) as u64);
            prop_assert_eq!(scan.ambiguous, all[..some].contains(&origin));
        }
    }
}
