//! Floats in the cells and on the bus: f64 and f32.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::{Add, Div, Mul, Sub};

use multiversion::multiversion;

use super::{
    Ageing, Domain, Place, RowOps, Share,
    domain::LIMITS,
    each::{each, each_twice},
};

/// f64 everywhere: the arithmetic that the others are measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exact;

/// f32 everywhere; sources are added in the order of the operands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Single;

/// What both are.
trait Real:
    Copy
    + Default
    + From<f32>
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
}

impl Real for f64 {}
impl Real for f32 {}

/// `-(sum) · part`. Not `-sum`, which would leave negative zeros behind.
#[inline(always)]
fn stored<T: Real, const N: usize>(operands: [T; N], part: T) -> T {
    (T::from(0.0) - sum(operands)) * part
}

/// The same as a function. A closure that is written in a function of several vector widths is one
/// of its own for each width, and so is the loop that gets it.
#[inline(always)]
fn storing<T: Real, const N: usize>(part: T) -> impl Fn([T; N]) -> T {
    move |operands| stored(operands, part)
}

/// A first sum with 0 would change nothing but the sign of a 0, and that is lost in the
/// difference.
#[inline(always)]
fn sum<T: Real, const N: usize>(operands: [T; N]) -> T {
    let mut sum = operands[0];
    for operand in &operands[1..] {
        sum = sum + *operand;
    }
    sum
}

/// Stores along a row, divided.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn row<T: Real>(operands: &[&[T]], by: u32, cells: &mut [T]) {
    // Times a half is divided by two, to the bit.
    let whole = T::from(by as f32);
    let exact = by.is_power_of_two();
    let part = if exact {
        T::from(1.0) / whole
    } else {
        T::from(1.0)
    };
    match *operands {
        [] => cells.fill(T::from(0.0)),
        [a] => each([a], cells, storing(part)),
        [a, b] => each([a, b], cells, storing(part)),
        [a, b, c] => each([a, b, c], cells, storing(part)),
        [first, ref others @ ..] => many(first, others, part, cells),
    }
    if !exact {
        for cell in cells {
            *cell = *cell / whole;
        }
    }
}

/// The same of a bus with many wires.
#[inline(never)]
fn many<T: Real>(first: &[T], others: &[&[T]], part: T, cells: &mut [T]) {
    cells.copy_from_slice(first);
    for operand in others {
        for (cell, operand) in cells.iter_mut().zip(*operand) {
            *cell = *cell + *operand;
        }
    }
    for cell in cells {
        *cell = stored([*cell], part);
    }
}

/// Two stores at once, the first divided by a power of two.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn pair<T: Real>(operands: &[&[T]], own: bool, by: u32, extra: Option<&[T]>, cells: &mut [T]) {
    let part = T::from(1.0) / T::from(by as f32);
    each_twice(operands, own, extra, cells, &of_one(part), &of_two(part));
}

/// What the second of two stores leaves, the first of one operand: without another, and with one.
#[inline(always)]
fn of_one<T: Real>(part: T) -> (impl Fn(T) -> T, impl Fn(T, T) -> T) {
    let whole = T::from(1.0);
    (
        move |a| stored([stored([a], part)], whole),
        move |a, c| stored([stored([a], part), c], whole),
    )
}

/// The same, the first of two operands.
#[inline(always)]
fn of_two<T: Real>(part: T) -> (impl Fn(T, T) -> T, impl Fn(T, T, T) -> T) {
    let whole = T::from(1.0);
    (
        move |a, b| stored([stored([a, b], part)], whole),
        move |a, b, c| stored([stored([a, b], part), c], whole),
    )
}

/// Whether each sum is above zero.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn positives<T: Real>(operands: &[&[T]], bytes: &mut [u8]) {
    match *operands {
        [] => bytes.fill(0),
        [a] => each([a], bytes, positive),
        [a, b] => each([a, b], bytes, positive),
        [a, b, c] => each([a, b, c], bytes, positive),
        [first, ref others @ ..] => {
            for (i, byte) in bytes.iter_mut().enumerate() {
                let add = |sum: T, operand: &&[T]| sum + operand[i];
                *byte = positive([others.iter().fold(first[i], add)]);
            }
        }
    }
}

/// 1 where the sum is above zero.
#[inline(always)]
fn positive<T: Real, const N: usize>(operands: [T; N]) -> u8 {
    (sum(operands) > T::from(0.0)).into()
}

macro_rules! float {
    ($domain:ty, $cell:ty, $bits:ty, $name:literal) => {
        impl Domain for $domain {
            type Cell = $cell;
            type Sum = $cell;

            fn name(&self) -> String {
                $name.into()
            }
            #[inline]
            fn hold(&self, value: f64) -> $cell {
                value as $cell
            }
            fn value(&self, cell: &$cell) -> f64 {
                (*cell).into()
            }
            #[inline]
            fn nothing(&self) -> $cell {
                0.0
            }
            #[inline]
            fn add(&self, sum: &mut $cell, cell: &$cell, times: i32) {
                *sum += cell * times as $cell;
            }
            #[inline]
            fn join(&self, sum: &mut $cell, other: &$cell) {
                *sum += other;
            }
            #[inline]
            fn store(&self, sum: &$cell, share: Share, _: Place) -> $cell {
                (0.0 - sum) / share.by as $cell
            }
            fn square(&self, sum: &$cell, gain: f64, _: Place) -> Option<$cell> {
                let sum = f64::from(*sum);
                Some((sum * sum * gain) as $cell)
            }
            #[inline]
            fn positive(&self, sum: &$cell) -> Option<bool> {
                Some(*sum > 0.0)
            }
            #[inline]
            fn limit(&self, cell: $cell) -> $cell {
                // The limits are exact in both.
                cell.clamp(LIMITS.0 as $cell, LIMITS.1 as $cell)
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
                row(operands, share.by, cells);
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
                pair(operands, own, by, extra, cells);
            }
            #[inline(always)]
            fn choose(&self, old: &$cell, new: &$cell, take: u8) -> $cell {
                let (old, new) = (old.to_bits(), new.to_bits());
                <$cell>::from_bits(old ^ ((old ^ new) & <$bits>::from(take).wrapping_neg()))
            }
            fn positives(&self, operands: &[&[$cell]], bytes: &mut [u8]) -> bool {
                positives(operands, bytes);
                true
            }
        }
    };
}

float!(Exact, f64, u64, "exact");
float!(Single, f32, u32, "f32");
