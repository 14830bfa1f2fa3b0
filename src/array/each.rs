//! Loops over cells that lie beside each other.

// What is not inlined is not compiled for the wide vectors; nor, where the crate is compiled in
// several units, are the zips that lints prefer to loops by number.
#![allow(clippy::inline_always, clippy::needless_range_loop)]

use std::{hint::black_box, ops::Index};

use crate::number::{Wide, Width};

/// So many cells at a time: a loop over them needs no end of its own.
const BLOCK: usize = 128;

/// So many under one word of bits.
const WORD: usize = 64;

/// Whether this version of a function has vectors so wide that a loop for each number of operands
/// is quicker than one for all. A macro: inside a function that is compiled for several machines
/// each version answers for itself, and a function beside it would answer for none.
macro_rules! has_wide_vectors {
    () => {
        !multiversion::target::target_cfg_f!(all(
            target_arch = "x86_64",
            not(target_feature = "avx2")
        ))
    };
}
pub(super) use has_wide_vectors;

/// The place of each of sixteen bits.
const BITS: [u16; 16] = [
    1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768,
];

/// The place of each of sixteen bits, not as a constant: so the compiler keeps sixteen lanes
/// together.
#[inline(always)]
pub(super) fn lanes() -> [u16; 16] {
    *black_box(&BITS)
}

/// Sets each cell to what `of` makes of the operands.
#[inline(always)]
pub(super) fn each<T: Copy + Default, U, const N: usize>(
    operands: [&[T]; N],
    cells: &mut [U],
    of: impl Fn([T; N]) -> U,
) {
    over(operands, cells, |cell, picked| *cell = of(picked));
}

/// The same of what the cell held before, and the operands.
#[inline(always)]
fn each_own<T: Copy + Default, const N: usize>(
    operands: [&[T]; N],
    cells: &mut [T],
    of: impl Fn(T, [T; N]) -> T,
) {
    over(operands, cells, |cell, picked| *cell = of(*cell, picked));
}

/// Goes over cells with the operands of each.
#[inline(always)]
fn over<T: Copy + Default, U, const N: usize>(
    operands: [&[T]; N],
    cells: &mut [U],
    set: impl Fn(&mut U, [T; N]),
) {
    let (blocks, last) = cells.as_chunks_mut::<BLOCK>();
    let done = BLOCK * blocks.len();
    let whole = whole::<_, N, BLOCK>(operands, blocks.len());
    let nothing = [T::default(); BLOCK];
    for (k, cells) in blocks.iter_mut().enumerate() {
        let from = block(&whole, k, &nothing);
        for (i, cell) in cells.iter_mut().enumerate() {
            set(cell, picked(from, i));
        }
    }
    for (i, cell) in (done..).zip(last) {
        set(cell, picked(operands, i));
    }
}

/// Two stores at once, of one operand or of two, where `own` says that one of them is what the
/// cell held before; and of one more on the second bus.
///
/// Without `wide` vectors it is one loop for all of them.
#[inline(always)]
pub(super) fn each_twice<T: Copy + Default>(
    operands: &[&[T]],
    own: bool,
    extra: Option<&[T]>,
    cells: &mut [T],
    wide: bool,
    one: &(impl Fn(T) -> T, impl Fn(T, T) -> T),
    two: &(impl Fn(T, T) -> T, impl Fn(T, T, T) -> T),
) {
    if !wide {
        for i in 0..cells.len() {
            let (held, c) = (own.then_some(cells[i]), extra.map(|extra| extra[i]));
            let first = operands.first().map(|operand| operand[i]);
            let (a, b) = match (first, held) {
                (Some(a), Some(held)) => (a, Some(held)),
                (Some(a), None) => (a, operands.get(1).map(|operand| operand[i])),
                (None, Some(held)) => (held, None),
                (None, None) => return,
            };
            cells[i] = match (b, c) {
                (None, None) => one.0(a),
                (None, Some(c)) => one.1(a, c),
                (Some(b), None) => two.0(a, b),
                (Some(b), Some(c)) => two.1(a, b, c),
            };
        }
        return;
    }
    match (operands, own, extra) {
        (&[a], false, None) => each([a], cells, |[a]| one.0(a)),
        (&[a], false, Some(c)) => each([a, c], cells, |[a, c]| one.1(a, c)),
        (&[a, b], false, None) => each([a, b], cells, |[a, b]| two.0(a, b)),
        (&[a, b], false, Some(c)) => each([a, b, c], cells, |[a, b, c]| two.1(a, b, c)),
        (&[], true, None) => each_own([], cells, |a, []| one.0(a)),
        (&[], true, Some(c)) => each_own([c], cells, |a, [c]| one.1(a, c)),
        (&[a], true, None) => each_own([a], cells, |b, [a]| two.0(a, b)),
        (&[a], true, Some(c)) => each_own([a, c], cells, |b, [a, c]| two.1(a, b, c)),
        _ => {}
    }
}

/// Makes a bit for each cell: whether what `of` makes of the operands is above zero.
#[inline(always)]
pub(super) fn above<T: Width, const N: usize>(
    operands: [&[T]; N],
    words: &mut [u64],
    of: impl Fn([T; N]) -> T,
) {
    let whole = whole::<_, N, WORD>(operands, words.len());
    let nothing = [T::ZERO; WORD];
    for (k, word) in words.iter_mut().enumerate() {
        let from = block(&whole, k, &nothing);
        let mut cells = [T::ZERO; WORD];
        for (i, cell) in cells.iter_mut().enumerate() {
            *cell = of(picked(from, i));
        }
        *word = T::above(&cells);
    }
}

/// Sets each cell whose bit is 1 to what `of` makes of the operands.
#[inline(always)]
pub(super) fn some<T: Width, const N: usize>(
    operands: [&[T]; N],
    words: &[u64],
    cells: &mut [T],
    of: impl Fn([T; N]) -> T,
) {
    let bits = lanes();
    let (blocks, last) = cells.as_chunks_mut::<WORD>();
    let done = blocks.len();
    let whole = whole::<_, N, WORD>(operands, done);
    for (k, (cells, word)) in blocks.iter_mut().zip(words).enumerate() {
        // By value: nothing that is read can be what was just written.
        let mut from = [[T::ZERO; WORD]; N];
        for (from, blocks) in from.iter_mut().zip(whole) {
            *from = blocks[k];
        }
        let mut new = [T::ZERO; WORD];
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
            *cell = of(picked(operands, WORD * done + i));
        }
    }
}

/// Sets each cell to what `of` makes of the sum of any number of operands.
#[inline(always)]
pub(super) fn summed<T: Width, U>(operands: &[&[T]], cells: &mut [U], of: impl Fn(T::Wide) -> U) {
    for (k, cells) in cells.chunks_mut(BLOCK).enumerate() {
        let mut sums = [T::Wide::default(); BLOCK];
        for operand in operands {
            let operand = &operand[BLOCK * k..][..cells.len()];
            for (sum, cell) in sums.iter_mut().zip(operand) {
                *sum = sum.plus(cell.widen());
            }
        }
        for (cell, &sum) in cells.iter_mut().zip(&sums) {
            *cell = of(sum);
        }
    }
}

/// The cells `i` of all operands, each a slice or a block.
///
/// Gone through by number: a zip of the two arrays calls what is not inlined where the crate is
/// compiled in several units, and a loop over cells with a call in it is not vectorised.
#[inline(always)]
fn picked<T: Copy + Default, S: Index<usize, Output = T> + ?Sized, const N: usize>(
    operands: [&S; N],
    i: usize,
) -> [T; N] {
    let mut cells = [T::default(); N];
    for k in 0..N {
        cells[k] = operands[k][i];
    }
    cells
}

/// So many blocks of all operands.
#[inline(always)]
fn whole<T, const N: usize, const B: usize>(operands: [&[T]; N], blocks: usize) -> [&[[T; B]]; N] {
    let mut whole: [&[[T; B]]; N] = [&[]; N];
    for (whole, operand) in whole.iter_mut().zip(operands) {
        *whole = &operand.as_chunks().0[..blocks];
    }
    whole
}

/// Block `k` of all operands, as [`picked`]. Looked up before the loop over its cells: that loop then
/// has no bounds to check, which would keep it from being vectorised too. `nothing` is any block.
#[inline(always)]
fn block<'a, T, const N: usize, const B: usize>(
    whole: &[&'a [[T; B]]; N],
    k: usize,
    nothing: &'a [T; B],
) -> [&'a [T; B]; N] {
    let mut block = [nothing; N];
    for n in 0..N {
        block[n] = &whole[n][k];
    }
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_loop_for_all_is_as_a_loop_for_each() {
        let plane = |k: i16| (0..300).map(|i| k * i % 101).collect::<Vec<i16>>();
        let (a, b, c) = (&plane(37)[..], &plane(53)[..], &plane(71)[..]);
        let one = (|a: i16| 3 * a, |a: i16, c: i16| 5 * a - c);
        let two = (
            |a: i16, b: i16| 7 * a + b,
            |a: i16, b: i16, c: i16| a - 2 * b + 9 * c,
        );
        for (operands, own) in [
            (&[a][..], false),
            (&[a, b], false),
            (&[], true),
            (&[a], true),
        ] {
            for extra in [None, Some(c)] {
                let made = [false, true].map(|wide| {
                    let mut cells = b.to_vec();
                    each_twice(operands, own, extra, &mut cells, wide, &one, &two);
                    cells
                });
                assert_eq!(made[0], made[1], "{} {own} {extra:?}", operands.len());
                assert_ne!(made[0], b);
            }
        }
    }
}
