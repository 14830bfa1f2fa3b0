//! Loops over cells that lie beside each other.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::hint::black_box;

use super::runs::lanes;
use crate::number::{Wide, Width};

/// So many cells at a time: a loop over them needs no end of its own.
const BLOCK: usize = 64;

/// Sets each cell to what `of` makes of the operands.
#[inline(always)]
pub(super) fn each<T: Copy + Default, U, const N: usize>(
    operands: [&[T]; N],
    cells: &mut [U],
    of: impl Fn([T; N]) -> U,
) {
    let (blocks, last) = cells.as_chunks_mut::<BLOCK>();
    let done = BLOCK * blocks.len();
    for (k, cells) in blocks.iter_mut().enumerate() {
        let operands = block(operands, k);
        for (i, cell) in cells.iter_mut().enumerate() {
            *cell = of(picked(operands, i));
        }
    }
    for (i, cell) in (done..).zip(last) {
        // They are few: no vectors for them.
        *cell = of(picked(operands, black_box(i)));
    }
}

/// The same where the bits of the cells are 1.
#[inline(always)]
pub(super) fn some<T: Width, const N: usize>(
    operands: [&[T]; N],
    words: &[u64],
    cells: &mut [T],
    of: impl Fn([T; N]) -> T,
) {
    let bits = lanes();
    let (blocks, last) = cells.as_chunks_mut::<BLOCK>();
    let done = blocks.len();
    for (k, (cells, word)) in blocks.iter_mut().zip(words).enumerate() {
        // By value: nothing that is read can be what was just written.
        let from = block(operands, k).map(|block| *block);
        let mut new = [T::ZERO; BLOCK];
        for (i, new) in new.iter_mut().enumerate() {
            *new = of(picked(from.each_ref(), i));
        }
        let lanes = cells.as_chunks_mut::<16>().0.iter_mut();
        for (k, (cells, new)) in lanes.zip(new.as_chunks::<16>().0).enumerate() {
            let flags = (word >> (16 * k)) as u16;
            let (old, mut merged) = (*cells, *new);
            for (i, cell) in merged.iter_mut().enumerate() {
                *cell = T::choose(old[i], new[i], u8::from(flags & bits[i] != 0));
            }
            *cells = merged;
        }
    }
    for (i, cell) in last.iter_mut().enumerate() {
        if words[done] >> i & 1 == 1 {
            *cell = of(picked(operands, BLOCK * done + i));
        }
    }
}

/// Sets each cell to what `of` makes of the sum of any number of operands.
#[inline(always)]
pub(super) fn summed<T: Width, U>(
    operands: &[&[T]],
    cells: &mut [U],
    of: impl Fn(T::Wide) -> U,
) {
    for (k, cells) in cells.chunks_mut(BLOCK).enumerate() {
        let mut sums = [T::Wide::default(); BLOCK];
        for operand in operands {
            let operand = &operand[BLOCK * k..][..cells.len()];
            for (sum, cell) in sums.iter_mut().zip(operand) {
                *sum = sum.plus(cell.widen());
            }
        }
        for (cell, sum) in cells.iter_mut().zip(sums) {
            *cell = of(sum);
        }
    }
}

/// The cells `i` of all operands.
#[inline(always)]
fn picked<T: Copy + Default, const N: usize>(
    operands: [&(impl std::ops::Index<usize, Output = T> + ?Sized); N],
    i: usize,
) -> [T; N] {
    let mut cells = [T::default(); N];
    for (cell, operand) in cells.iter_mut().zip(operands) {
        *cell = operand[i];
    }
    cells
}

/// The block `k` of all operands.
#[inline(always)]
fn block<T, const N: usize>(operands: [&[T]; N], k: usize) -> [&[T; BLOCK]; N] {
    operands.map(|operand| &operand.as_chunks().0[k])
}
