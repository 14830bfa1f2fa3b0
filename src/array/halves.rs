//! Half precision in the cells, f32 on the bus.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use half::{bf16, f16};
use multiversion::multiversion;

use super::{Ageing, Domain, Place, RowOps, Share, domain::LIMITS};
use crate::number::{self, Number};

/// Half precision in the cells, f32 on the bus. `T` is [`struct@f16`] or [`struct@bf16`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halves<T>(std::marker::PhantomData<T>);

impl<T> Default for Halves<T> {
    fn default() -> Self {
        Self(std::marker::PhantomData)
    }
}

/// Cells that are worked on at once.
const BLOCK: usize = 64;

/// Sets each cell to what `of` makes of the sum of the operands; `wide`: what a cell holds.
/// So many instructions a cell that the call does not matter.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn summed<T, U, W, O>(operands: &[&[T]], cells: &mut [U], wide: W, of: O)
where
    T: Copy,
    W: Fn(T) -> f32,
    O: Fn(f32) -> U,
{
    for (k, cells) in cells.chunks_mut(BLOCK).enumerate() {
        let mut sums = [0.0; BLOCK];
        for operand in operands {
            let operand = &operand[BLOCK * k..][..cells.len()];
            for (sum, cell) in sums.iter_mut().zip(operand) {
                *sum += wide(*cell);
            }
        }
        for (cell, sum) in cells.iter_mut().zip(sums) {
            *cell = of(sum);
        }
    }
}

macro_rules! half {
    ($cell:ty, $name:literal, $number:expr, $wide:path, $narrow:path) => {
        impl Domain for Halves<$cell> {
            type Cell = $cell;
            type Sum = f32;

            fn name(&self) -> String {
                $name.into()
            }
            fn hold(&self, value: f64) -> $cell {
                $number.hold(value)
            }
            fn value(&self, cell: &$cell) -> f64 {
                $number.value(*cell)
            }
            #[inline]
            fn nothing(&self) -> f32 {
                0.0
            }
            #[inline]
            fn add(&self, sum: &mut f32, cell: &$cell, times: i32) {
                *sum += $wide(*cell) * times as f32;
            }
            #[inline]
            fn join(&self, sum: &mut f32, other: &f32) {
                *sum += other;
            }
            #[inline]
            fn store(&self, sum: &f32, share: Share, _: Place) -> $cell {
                $narrow((0.0 - sum) / share.by as f32)
            }
            fn square(&self, sum: &f32, gain: f64, _: Place) -> Option<$cell> {
                let sum = f64::from(*sum);
                Some($number.hold(sum * sum * gain))
            }
            #[inline]
            fn positive(&self, sum: &f32) -> Option<bool> {
                Some(*sum > 0.0)
            }
            #[inline]
            fn limit(&self, cell: $cell) -> $cell {
                // The limits are exact in both.
                cell.clamp($narrow(LIMITS.0 as f32), $narrow(LIMITS.1 as f32))
            }
        }

        impl Ageing for Halves<$cell> {}

        impl RowOps for Halves<$cell> {
            fn store_row(
                &self,
                operands: &[&[$cell]],
                share: Share,
                _: Place,
                cells: &mut [$cell],
            ) {
                let by = share.by as f32;
                summed(
                    operands,
                    cells,
                    |cell| $wide(cell),
                    |sum| $narrow((0.0 - sum) / by),
                );
            }
            #[inline(always)]
            fn choose(&self, old: &$cell, new: &$cell, take: u8) -> $cell {
                let (old, new) = (old.to_bits(), new.to_bits());
                <$cell>::from_bits(old ^ ((old ^ new) & u16::from(take).wrapping_neg()))
            }
            fn positives(&self, operands: &[&[$cell]], bytes: &mut [u8]) -> bool {
                summed(
                    operands,
                    bytes,
                    |cell| $wide(cell),
                    |sum| (sum > 0.0).into(),
                );
                true
            }
        }
    };
}

half!(
    f16,
    "f16",
    number::F16,
    number::f16_to_f32,
    number::f32_to_f16
);
half!(
    bf16,
    "bf16",
    number::Bf16,
    number::bf16_to_f32,
    number::f32_to_bf16
);
