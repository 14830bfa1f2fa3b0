//! Lines: rows of weights, and their correlation with rows of pixels.

use multiversion::multiversion;

use crate::number::Number;

use super::width::is_wide;

/// A row of weights, and the rows of the kernel in which it stands: one, or several that are equal.
#[derive(Clone, Debug)]
pub(super) struct Line<H> {
    pub(super) weights: Vec<H>,
    pub(super) rows: Vec<usize>,
}

impl<H: Copy> Line<H> {
    pub(super) fn all<N: Number<Held = H>>(number: &N, rows: Vec<Vec<H>>) -> Vec<Self> {
        let together = is_wide(number);
        let mut lines: Vec<Self> = Vec::new();
        for (row, weights) in rows.into_iter().enumerate() {
            let bits = |held: &H| number.value(*held).to_bits();
            let equal =
                |line: &&mut Self| line.weights.iter().map(bits).eq(weights.iter().map(bits));
            match lines.iter_mut().find(equal) {
                Some(line) if together => line.rows.push(row),
                _ => lines.push(Self {
                    weights,
                    rows: vec![row],
                }),
            }
        }
        lines
    }
}

/// Sums of rows of `source`, pixel by pixel.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn add_rows<N: Number>(
    number: &N,
    rows: &[usize],
    (source, stride): (&[N::Held], usize),
    out: &mut [N::Held],
) {
    const PART: usize = 32;
    let Some((&first, rows)) = rows.split_first() else {
        return;
    };
    let whole = out.len();
    let row = |row: usize| source[row * stride..][..whole].as_chunks::<PART>();
    let (parts, rest) = out.as_chunks_mut::<PART>();
    for (n, part) in parts.iter_mut().enumerate() {
        let mut sums = row(first).0[n];
        for &next in rows {
            for (sum, &value) in sums.iter_mut().zip(&row(next).0[n]) {
                *sum = number.add(*sum, value);
            }
        }
        *part = sums;
    }
    for (n, sum) in rest.iter_mut().enumerate() {
        *sum = row(first).1[n];
        for &next in rows {
            *sum = number.add(*sum, row(next).1[n]);
        }
    }
}

/// Computes a row of sums, or with `FRESH` false adds to one: the correlation of the lines with
/// `source`, or, for lines of several rows, with `summed`; each is given with its stride.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn correlate<N: Number, const BLOCK: usize, const FRESH: bool>(
    number: &N,
    lines: &[Line<N::Held>],
    source: (&[N::Held], usize),
    summed: (&[N::Held], usize),
    out: &mut [N::Held],
) {
    let none = [N::ZERO; BLOCK];
    let (blocks, rest) = out.as_chunks_mut::<BLOCK>();
    let start = BLOCK * blocks.len();
    for (block, out) in blocks.iter_mut().enumerate() {
        let sums = if FRESH { none } else { *out };
        *out = add_block(number, lines, source, summed, BLOCK * block, sums);
    }
    if !rest.is_empty() {
        let mut sums = none;
        if !FRESH {
            sums[..rest.len()].copy_from_slice(rest);
        }
        let sums = add_block(number, lines, source, summed, start, sums);
        rest.copy_from_slice(&sums[..rest.len()]);
    }
}

/// Computes two rows of sums, one below the other, for lines of one row each.
pub(super) fn correlate_two<N: Number, const BLOCK: usize, const HALF: usize>(
    number: &N,
    lines: &[Line<N::Held>],
    (source, stride): (&[N::Held], usize),
    (upper, lower): (&mut [N::Held], &mut [N::Held]),
) {
    let (first, last) = (&lines[..1], &lines[lines.len() - 1..]);
    let none = (&[][..], 0);
    let below = (&source[stride..], stride);
    correlate::<N, BLOCK, true>(number, first, (source, stride), none, upper);
    correlate_shared::<N, HALF>(number, lines, below, (&mut *upper, &mut *lower));
    correlate::<N, BLOCK, false>(number, last, below, none, lower);
}

/// The part that both rows share: each pixel is loaded once, and goes into the upper sum by all
/// lines but the first, into the lower one by all but the last.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn correlate_shared<N: Number, const BLOCK: usize>(
    number: &N,
    lines: &[Line<N::Held>],
    source: (&[N::Held], usize),
    (upper, lower): (&mut [N::Held], &mut [N::Held]),
) {
    let (blocks, rest) = upper.as_chunks_mut::<BLOCK>();
    let (lower_blocks, lower_rest) = lower.as_chunks_mut::<BLOCK>();
    let start = BLOCK * blocks.len();
    for (block, (upper, lower)) in blocks.iter_mut().zip(lower_blocks).enumerate() {
        (*upper, *lower) = add_two(number, lines, source, BLOCK * block, *upper);
    }
    if !rest.is_empty() {
        let mut upper = [N::ZERO; BLOCK];
        upper[..rest.len()].copy_from_slice(rest);
        let (upper, lower) = add_two(number, lines, source, start, upper);
        rest.copy_from_slice(&upper[..rest.len()]);
        lower_rest.copy_from_slice(&lower[..rest.len()]);
    }
}

/// A block of sums, and what [`correlate`] adds to it from a column on.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn add_block<N: Number, const BLOCK: usize>(
    number: &N,
    lines: &[Line<N::Held>],
    (source, stride): (&[N::Held], usize),
    (summed, whole): (&[N::Held], usize),
    column: usize,
    mut sums: [N::Held; BLOCK],
) -> [N::Held; BLOCK] {
    let mut seen = 0;
    for Line { weights, rows } in lines {
        let (source, start) = if let [row] = rows[..] {
            (source, row * stride)
        } else {
            seen += 1;
            (summed, (seen - 1) * whole)
        };
        let start = start + column;
        let Some(source) = source.get(start..start + weights.len() - 1 + BLOCK) else {
            continue;
        };
        for (source, &weight) in source.windows(BLOCK).zip(weights) {
            for (sum, &value) in sums.iter_mut().zip(source) {
                *sum = number.add(*sum, number.mul(weight, value));
            }
        }
    }
    sums
}

/// Blocks of two rows as [`correlate_shared`] computes them from a column on.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn add_two<N: Number, const BLOCK: usize>(
    number: &N,
    lines: &[Line<N::Held>],
    (source, stride): (&[N::Held], usize),
    column: usize,
    mut upper: [N::Held; BLOCK],
) -> ([N::Held; BLOCK], [N::Held; BLOCK]) {
    let mut lower = [N::ZERO; BLOCK];
    for (row, interval) in lines.windows(2).enumerate() {
        let (above, line) = (&interval[0].weights, &interval[1].weights);
        let start = row * stride + column;
        let Some(source) = source.get(start..start + line.len() - 1 + BLOCK) else {
            continue;
        };
        let weights = line.iter().zip(above);
        for (source, (&weight, &above)) in source.windows(BLOCK).zip(weights) {
            for ((upper, lower), &value) in upper.iter_mut().zip(&mut lower).zip(source) {
                *upper = number.add(*upper, number.mul(weight, value));
                *lower = number.add(*lower, number.mul(above, value));
            }
        }
    }
    (upper, lower)
}
