//! Loops over cells that lie beside each other.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use super::runs::lanes;
use crate::number::Width;

/// So many cells at a time: a loop over them needs no end of its own.
const BLOCK: usize = 64;

/// Sets each cell to what `of` makes of the operands.
#[inline(always)]
pub(super) fn each<T: Width, const N: usize>(
    operands: [&[T]; N],
    cells: &mut [T],
    of: impl Fn([T; N]) -> T,
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
        *cell = of(picked(operands, i));
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

/// The same twice: `first` of the operands, `second` of that and of the extra ones.
#[inline(always)]
pub(super) fn twice<T: Width, const N: usize, const M: usize>(
    operands: [&[T]; N],
    extra: [&[T]; M],
    mut between: Option<&mut [T]>,
    cells: &mut [T],
    first: impl Fn([T; N]) -> T,
    second: impl Fn(T, [T; M]) -> T,
) {
    let (blocks, last) = cells.as_chunks_mut::<BLOCK>();
    let done = BLOCK * blocks.len();
    for (k, cells) in blocks.iter_mut().enumerate() {
        let (operands, extra) = (block(operands, k), block(extra, k));
        if let Some(between) = between.as_deref_mut() {
            let between: &mut [T; BLOCK] = &mut between.as_chunks_mut().0[k];
            for (i, middle) in between.iter_mut().enumerate() {
                *middle = first(picked(operands, i));
            }
            for (i, cell) in cells.iter_mut().enumerate() {
                *cell = second(between[i], picked(extra, i));
            }
        } else {
            for (i, cell) in cells.iter_mut().enumerate() {
                *cell = second(first(picked(operands, i)), picked(extra, i));
            }
        }
    }
    for (i, cell) in (done..).zip(last) {
        let middle = first(picked(operands, i));
        if let Some(between) = between.as_deref_mut() {
            between[i] = middle;
        }
        *cell = second(middle, picked(extra, i));
    }
}

/// The cells `i` of all operands.
#[inline(always)]
pub(super) fn picked<T: Width, const N: usize>(
    operands: [&(impl std::ops::Index<usize, Output = T> + ?Sized); N],
    i: usize,
) -> [T; N] {
    let mut cells = [T::ZERO; N];
    for (cell, operand) in cells.iter_mut().zip(operands) {
        *cell = operand[i];
    }
    cells
}

/// The block `k` of all operands.
#[inline(always)]
fn block<T: Width, const N: usize>(operands: [&[T]; N], k: usize) -> [&[T; BLOCK]; N] {
    operands.map(|operand| &operand.as_chunks().0[k])
}
