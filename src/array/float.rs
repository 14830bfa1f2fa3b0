//! Floats in the cells: f64, f32 and the halves. The bus is f64 for f64, f32 for the others.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use super::{
    Ageing, Domain, Place, RowOps, Share,
    each::{each, each_twice, has_wide_vectors},
};
use crate::number::{self, F32, F64, HeldBf16, HeldF16, Number, Real};

/// f64 everywhere: the arithmetic that the others are measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exact;

/// f32 everywhere; sources are added in the order of the operands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Single;

/// IEEE binary16 in the cells, f32 on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Half;

/// bfloat16 in the cells, f32 on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bfloat;

/// Cells that are summed at once, where there are many operands.
const BLOCK: usize = 64;

/// `-(sum) · part`, held. Not `-sum`, which would leave negative zeros behind.
#[inline(always)]
fn stored<N: Number, const K: usize>(number: N, operands: [N::Held; K], part: N::Real) -> N::Held {
    number.hold_real((N::Real::ZERO - sum(number, operands)) * part)
}

/// The same as a function. A closure that is written in a function of several vector widths is one
/// of its own for each width, and so is the loop that gets it.
#[inline(always)]
fn storing<N: Number, const K: usize>(
    number: N,
    part: N::Real,
) -> impl Fn([N::Held; K]) -> N::Held {
    move |operands| stored(number, operands, part)
}

/// `-(sum) / by`, held.
#[inline(always)]
fn divided<N: Number>(number: N, by: N::Real) -> impl Fn(N::Real) -> N::Held {
    move |sum| number.hold_real((N::Real::ZERO - sum) / by)
}

/// A first sum with 0 would change nothing but the sign of a 0, and that is lost in the
/// difference.
#[inline(always)]
fn sum<N: Number, const K: usize>(number: N, operands: [N::Held; K]) -> N::Real {
    let mut sum = number.real(operands[0]);
    for operand in &operands[1..] {
        sum = sum + number.real(*operand);
    }
    sum
}

/// Sets each cell to what `of` makes of the sum of any number of operands.
#[inline(always)]
fn summed<N: Number, U>(
    number: N,
    operands: &[&[N::Held]],
    cells: &mut [U],
    of: impl Fn(N::Real) -> U,
) {
    for (k, cells) in cells.chunks_mut(BLOCK).enumerate() {
        let mut sums = [N::Real::ZERO; BLOCK];
        for operand in operands {
            let operand = &operand[BLOCK * k..][..cells.len()];
            for (sum, cell) in sums.iter_mut().zip(operand) {
                *sum = *sum + number.real(*cell);
            }
        }
        for (cell, sum) in cells.iter_mut().zip(sums) {
            *cell = of(sum);
        }
    }
}

/// Stores along a row, divided.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn row<N: Number>(number: N, operands: &[&[N::Held]], by: u32, cells: &mut [N::Held]) {
    let wide = has_wide_vectors!();
    let by = (by, N::Real::from_i32(by as i32));
    // Times a half is divided by two, to the bit.
    let part = N::Real::ONE / by.1;
    match *operands {
        [] => cells.fill(N::ZERO),
        _ if !wide || !by.0.is_power_of_two() => {
            summed(number, operands, cells, divided(number, by.1));
        }
        [a] => each([a], cells, storing(number, part)),
        [a, b] => each([a, b], cells, storing(number, part)),
        [a, b, c] => each([a, b, c], cells, storing(number, part)),
        _ => summed(number, operands, cells, divided(number, by.1)),
    }
}

/// Two stores at once, the first divided by a power of two.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn pair<N: Number>(
    number: N,
    operands: &[&[N::Held]],
    own: bool,
    by: u32,
    extra: Option<&[N::Held]>,
    cells: &mut [N::Held],
) {
    let part = N::Real::ONE / N::Real::from_i32(by as i32);
    let one = (one(number, part), one_more(number, part));
    let two = (two(number, part), two_more(number, part));
    let wide = has_wide_vectors!();
    each_twice(operands, own, extra, cells, wide, &one, &two);
}

// What the second of two stores leaves, the first of one operand or of two: without another on the
// second bus, and with one.

#[inline(always)]
fn one<N: Number>(number: N, part: N::Real) -> impl Fn(N::Held) -> N::Held {
    move |a| stored(number, [stored(number, [a], part)], N::Real::ONE)
}

#[inline(always)]
fn one_more<N: Number>(number: N, part: N::Real) -> impl Fn(N::Held, N::Held) -> N::Held {
    move |a, c| stored(number, [stored(number, [a], part), c], N::Real::ONE)
}

#[inline(always)]
fn two<N: Number>(number: N, part: N::Real) -> impl Fn(N::Held, N::Held) -> N::Held {
    move |a, b| stored(number, [stored(number, [a, b], part)], N::Real::ONE)
}

#[inline(always)]
fn two_more<N: Number>(number: N, part: N::Real) -> impl Fn(N::Held, N::Held, N::Held) -> N::Held {
    move |a, b, c| stored(number, [stored(number, [a, b], part), c], N::Real::ONE)
}

/// Whether each sum is above zero.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn positives<N: Number>(number: N, operands: &[&[N::Held]], bytes: &mut [u8]) {
    let wide = has_wide_vectors!();
    match *operands {
        [] => bytes.fill(0),
        _ if !wide => summed(number, operands, bytes, above_zero),
        [a] => each([a], bytes, positive(number)),
        [a, b] => each([a, b], bytes, positive(number)),
        [a, b, c] => each([a, b, c], bytes, positive(number)),
        _ => summed(number, operands, bytes, above_zero),
    }
}

/// 1 where the sum is above zero.
#[inline(always)]
fn positive<N: Number, const K: usize>(number: N) -> impl Fn([N::Held; K]) -> u8 {
    move |operands| above_zero(sum(number, operands))
}

#[inline(always)]
fn above_zero<R: Real>(sum: R) -> u8 {
    (sum > R::ZERO).into()
}

/// `new` where `take` is 1, `old` where it is 0, without a branch.
macro_rules! chosen {
    ($old:expr, $new:expr, $take:expr, f64) => {
        f64::from_bits(chosen!(bits $old, $new, $take, u64))
    };
    ($old:expr, $new:expr, $take:expr, f32) => {
        f32::from_bits(chosen!(bits $old, $new, $take, u32))
    };
    (bits $old:expr, $new:expr, $take:expr, $bits:ty) => {{
        let (old, new) = ($old.to_bits(), $new.to_bits());
        old ^ ((old ^ new) & <$bits>::from($take).wrapping_neg())
    }};
    ($old:expr, $new:expr, $take:expr, $held:ident) => {
        if $take == 0 { *$old } else { *$new }
    };
}

macro_rules! float {
    ($domain:ident, $number:expr, $cell:ident, $bus:ident, $name:literal) => {
        impl Domain for $domain {
            type Cell = $cell;
            type Sum = $bus;

            fn name(&self) -> String {
                $name.into()
            }
            #[inline(always)]
            fn hold(&self, value: f64) -> $cell {
                $number.hold(value)
            }
            fn value(&self, cell: &$cell) -> f64 {
                $number.value(*cell)
            }
            #[inline]
            fn nothing(&self) -> $bus {
                0.0
            }
            #[inline]
            fn add(&self, sum: &mut $bus, cell: &$cell, times: i32) {
                *sum += $number.real(*cell) * times as $bus;
            }
            #[inline]
            fn join(&self, sum: &mut $bus, other: &$bus) {
                *sum += other;
            }
            #[inline]
            fn store(&self, sum: &$bus, share: Share, _: Place) -> $cell {
                $number.hold_real((0.0 - sum) / share.by as $bus)
            }
            fn square(&self, sum: &$bus, gain: f64, _: Place) -> Option<$cell> {
                let sum = f64::from(*sum);
                Some($number.hold(sum * sum * gain))
            }
            #[inline]
            fn positive(&self, sum: &$bus) -> Option<bool> {
                Some(*sum > 0.0)
            }
            #[inline(always)]
            fn limit(&self, cell: $cell, limits: (f64, f64)) -> $cell {
                let (low, high) = ($number.hold(limits.0), $number.hold(limits.1));
                let cell = if cell < low { low } else { cell };
                if cell > high { high } else { cell }
            }
        }

        impl Ageing for $domain {}

        impl RowOps for $domain {
            fn store_row(
                &self,
                operands: &[&[$cell]],
                share: Share,
                _: Place,
                cells: &mut [$cell],
            ) {
                row($number, operands, share.by, cells);
            }
            fn fuses(&self) -> bool {
                true
            }
            fn store_fused(
                &self,
                operands: &[&[$cell]],
                own: bool,
                by: u32,
                extra: Option<&[$cell]>,
                cells: &mut [$cell],
            ) {
                pair($number, operands, own, by, extra, cells);
            }
            #[inline(always)]
            fn choose(&self, old: &$cell, new: &$cell, take: u8) -> $cell {
                chosen!(old, new, take, $cell)
            }
            fn positives(&self, operands: &[&[$cell]], bytes: &mut [u8]) -> bool {
                positives($number, operands, bytes);
                true
            }
        }
    };
}

float!(Exact, F64, f64, f64, "exact");
float!(Single, F32, f32, f32, "f32");
float!(Half, number::F16, HeldF16, f32, "f16");
float!(Bfloat, number::Bf16, HeldBf16, f32, "bf16");
