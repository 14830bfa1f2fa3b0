//! What a cell holds, and how the summing bus treats it.

// What is not inlined into the loops of `rows` is not compiled for wide vectors.
#![allow(clippy::inline_always)]

use std::fmt::Debug;

use half::{bf16, f16};

use crate::{
    isa::{Analog, Digital},
    number::{self, Number},
};

/// An arithmetic of the array.
///
/// The bus is one node. The sources are summed in an accumulator ([`Domain::Sum`]); at the
/// store the sum is negated, divided by the number of targets, and rounded once, halves to
/// even; then the cell is limited, where the array clips.
pub trait Domain: Sync {
    /// What a register holds in one pixel.
    type Cell: Clone + Debug + PartialEq + Send + Sync;

    /// The accumulator of the bus.
    type Sum: Clone + Send;

    /// The name, as given to `--domain`.
    fn name(&self) -> String;

    /// The nearest cell to a value in LSB, as it is set from outside.
    fn hold(&self, value: f64) -> Self::Cell;

    /// The value of a cell in LSB, without loss.
    fn value(&self, cell: &Self::Cell) -> f64;

    /// An empty bus.
    fn nothing(&self) -> Self::Sum;

    /// One more cell on the bus, `times` over.
    fn add(&self, sum: &mut Self::Sum, cell: &Self::Cell, times: i32);

    /// Joins two buses that drive one cell.
    fn join(&self, sum: &mut Self::Sum, other: &Self::Sum);

    /// The share of `-(sum)` that arrives in the cell at `place`.
    fn store(&self, sum: &Self::Sum, share: Share, place: Place) -> Self::Cell;

    /// The cells `i` of all operands on one bus.
    #[inline(always)]
    fn sum<const N: usize>(&self, operands: &[&[Self::Cell]; N], i: usize) -> Self::Sum {
        let mut sum = self.nothing();
        for operand in operands {
            self.add(&mut sum, &operand[i], 1);
        }
        sum
    }

    /// Stores along a row: the cell `i` right of `place` gets its share of what the operands
    /// have at `i`, limited where the array clips.
    #[inline(always)]
    fn store_row<const N: usize>(
        &self,
        operands: [&[Self::Cell]; N],
        share: Share,
        place: Place,
        clip: bool,
        cells: &mut [Self::Cell],
    ) {
        let operands = operands.map(|operand| &operand[..cells.len()]);
        for (i, cell) in cells.iter_mut().enumerate() {
            let x = place.x + i;
            let stored = self.store(&self.sum(&operands, i), share, Place { x, ..place });
            *cell = self.limited(stored, clip);
        }
    }

    /// Whether [`Domain::store_pair`] can be asked, which is worth it where a store costs more
    /// than what is stored.
    fn pairs(&self) -> bool {
        false
    }

    /// Two stores at once, not limited: what the first makes of the operands, divided by 1 or 2,
    /// goes to `between`, if that is asked for; what the second makes of that and of the extra
    /// operands, undivided, goes to the cells.
    #[inline(always)]
    fn store_pair<const N: usize, const M: usize>(
        &self,
        _operands: [&[Self::Cell]; N],
        _by: u32,
        _extra: [&[Self::Cell]; M],
        _between: Option<&mut [Self::Cell]>,
        _cells: &mut [Self::Cell],
    ) {
    }

    /// The bus of each cell, undivided, where its bit is 1, in one go; whether this domain does
    /// so. Else nothing is stored.
    #[inline(always)]
    fn store_some<const N: usize>(
        &self,
        _operands: [&[Self::Cell]; N],
        _words: &[u64],
        _cells: &mut [Self::Cell],
    ) -> bool {
        false
    }

    /// The new cell where `take` is 1, the old one where it is 0. Numbers choose without a
    /// branch.
    #[inline(always)]
    fn choose(&self, old: &Self::Cell, new: &Self::Cell, take: u8) -> Self::Cell {
        if take == 0 { old.clone() } else { new.clone() }
    }

    /// `gain · sum²`, as it arrives in the cell at `place`; `None` where this domain has no answer.
    fn square(&self, sum: &Self::Sum, gain: f64, place: Place) -> Option<Self::Cell>;

    /// Whether the sum is above zero; `None` where this domain has no answer.
    fn positive(&self, sum: &Self::Sum) -> Option<bool>;

    /// Sets each byte to 1 where the sum of what the operands have there is
    /// above zero, else to 0; whether this domain has an answer for all of them.
    #[inline(always)]
    fn positives<const N: usize>(&self, operands: [&[Self::Cell]; N], bytes: &mut [u8]) -> bool {
        let mut decided = true;
        // No early way out, so that this runs in vectors.
        for (i, byte) in bytes.iter_mut().enumerate() {
            let answer = self.positive(&self.sum(&operands, i));
            decided &= answer.is_some();
            *byte = (answer == Some(true)).into();
        }
        decided
    }

    /// The cell, limited to [-128, 127] LSB.
    fn limit(&self, cell: Self::Cell) -> Self::Cell;

    /// The cell, limited if stores are.
    #[inline(always)]
    fn limited(&self, cell: Self::Cell, clip: bool) -> Self::Cell {
        if clip { self.limit(cell) } else { cell }
    }

    /// What the DAC makes of a value in LSB, with or without the host's calibration.
    fn input(&self, value: f64, _calibrated: bool) -> Self::Cell {
        self.hold(value)
    }

    /// Whether a word gives the same from the same, whatever the place and the step.
    fn is_steady(&self) -> bool {
        true
    }

    /// What a cell holds some seconds later; `None` where cells keep what they hold.
    fn aged(&self, _cell: &Self::Cell, _seconds: f64) -> Option<Self::Cell> {
        None
    }

    /// How long one-bit registers hold at least, in seconds, without being written; `None`
    /// where they hold for ever.
    fn retention(&self) -> Option<f64> {
        None
    }

    /// Whether a one-bit cell still holds, so many seconds after it was written.
    fn holds(&self, _register: Digital, _pixel: usize, _seconds: f64) -> bool {
        true
    }
}

/// What part of the bus a cell gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// The sum is divided by this.
    pub by: u32,
    /// Where the bus splits between several targets: which of them this is, from 0.
    pub part: Option<u8>,
}

impl Share {
    /// Of a bus with so many targets.
    #[must_use]
    pub const fn of(targets: usize, part: usize) -> Self {
        Self {
            by: targets as u32,
            part: if targets > 1 { Some(part as u8) } else { None },
        }
    }
}

/// Which cell is written, and when: the seed of its noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Row.
    pub y: usize,
    /// Column.
    pub x: usize,
    /// Register.
    pub register: Analog,
    /// Number of the instruction word since the chip was switched on.
    pub step: u64,
}

/// A domain has no answer: the result is not a kernel, or not an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{operation}` has no answer in this domain")]
pub struct Undecided {
    /// Which kind of instruction.
    pub operation: &'static str,
}

/// The ends of the ADC scale, in LSB.
pub(super) const LIMITS: (f64, f64) = (-128.0, 127.0);

/// Two stores at once in floats, as one after the other leaves them.
macro_rules! float_pair {
    ($cell:ty) => {
        fn pairs(&self) -> bool {
            true
        }
        #[inline(always)]
        fn store_pair<const N: usize, const M: usize>(
            &self,
            operands: [&[$cell]; N],
            by: u32,
            extra: [&[$cell]; M],
            mut between: Option<&mut [$cell]>,
            cells: &mut [$cell],
        ) {
            let n = cells.len();
            let operands = operands.map(|operand| &operand[..n]);
            let extra = extra.map(|operand| &operand[..n]);
            let first = |i: usize| {
                let mut sum = operands.first().map_or(0.0, |first| first[i]);
                for operand in operands.iter().skip(1) {
                    sum += operand[i];
                }
                (0.0 - sum) / by as $cell
            };
            let second =
                |first, i: usize| 0.0 - extra.iter().fold(first, |sum, operand| sum + operand[i]);
            if let Some(between) = between.as_deref_mut() {
                let between = &mut between[..n];
                for (i, cell) in cells.iter_mut().enumerate() {
                    between[i] = first(i);
                    *cell = second(between[i], i);
                }
            } else {
                for (i, cell) in cells.iter_mut().enumerate() {
                    *cell = second(first(i), i);
                }
            }
        }
    };
}

/// f64 everywhere: the arithmetic that the others are measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exact;

impl Domain for Exact {
    type Cell = f64;
    type Sum = f64;

    fn name(&self) -> String {
        "exact".into()
    }
    fn hold(&self, value: f64) -> f64 {
        value
    }
    fn value(&self, cell: &f64) -> f64 {
        *cell
    }
    #[inline]
    fn nothing(&self) -> f64 {
        0.0
    }
    #[inline]
    fn add(&self, sum: &mut f64, cell: &f64, times: i32) {
        *sum += cell * f64::from(times);
    }
    #[inline]
    fn join(&self, sum: &mut f64, other: &f64) {
        *sum += other;
    }
    #[inline]
    fn store(&self, sum: &f64, share: Share, _: Place) -> f64 {
        // Not `-sum`, which would leave negative zeros behind.
        (0.0 - sum) / f64::from(share.by)
    }
    #[inline(always)]
    fn choose(&self, old: &f64, new: &f64, take: u8) -> f64 {
        let (old, new) = (old.to_bits(), new.to_bits());
        f64::from_bits(old ^ ((old ^ new) & u64::from(take).wrapping_neg()))
    }
    float_pair!(f64);
    fn square(&self, sum: &f64, gain: f64, _: Place) -> Option<f64> {
        Some(sum * sum * gain)
    }
    #[inline]
    fn positive(&self, sum: &f64) -> Option<bool> {
        Some(*sum > 0.0)
    }
    #[inline]
    fn limit(&self, cell: f64) -> f64 {
        cell.clamp(LIMITS.0, LIMITS.1)
    }
}

/// f32 everywhere; sources are added in the order of the operands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Single;

/// Half precision in the cells, f32 on the bus. `T` is [`struct@f16`] or [`struct@bf16`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halves<T>(std::marker::PhantomData<T>);

impl<T> Default for Halves<T> {
    fn default() -> Self {
        Self(std::marker::PhantomData)
    }
}

/// The domains whose bus is an f32.
macro_rules! single_bus {
    ($domain:ty, $cell:ty, $bits:ty, $name:literal, $number:expr, $wide:expr, $narrow:expr, {$($more:item)*}) => {
        impl Domain for $domain {
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
            #[inline(always)]
            fn choose(&self, old: &$cell, new: &$cell, take: u8) -> $cell {
                let (old, new) = (old.to_bits(), new.to_bits());
                <$cell>::from_bits(old ^ ((old ^ new) & <$bits>::from(take).wrapping_neg()))
            }
            fn square(&self, sum: &f32, gain: f64, _: Place) -> Option<$cell> {
                let sum = f64::from(*sum);
                Some($number.hold(sum * sum * gain))
            }
            #[inline(always)]
            fn positives<const N: usize>(&self, operands: [&[$cell]; N], bytes: &mut [u8]) -> bool {
                let mut at = 0;
                let (blocks, rest) = bytes.as_chunks_mut::<64>();
                for bytes in blocks {
                    let mut sums = [0.0; 64];
                    for operand in operands {
                        for (sum, cell) in sums.iter_mut().zip(&operand[at..at + 64]) {
                            *sum += $wide(*cell);
                        }
                    }
                    for (byte, sum) in bytes.iter_mut().zip(sums) {
                        *byte = (sum > 0.0).into();
                    }
                    at += 64;
                }
                for (i, byte) in rest.iter_mut().enumerate() {
                    *byte = (self.sum(&operands, at + i) > 0.0).into();
                }
                true
            }
            #[inline]
            fn positive(&self, sum: &f32) -> Option<bool> {
                Some(*sum > 0.0)
            }
            #[inline]
            fn limit(&self, cell: $cell) -> $cell {
                // The limits are exact in all of these.
                cell.clamp($narrow(LIMITS.0 as f32), $narrow(LIMITS.1 as f32))
            }
            #[inline(always)]
            fn store_row<const N: usize>(
                &self,
                operands: [&[$cell]; N],
                share: Share,
                _: Place,
                clip: bool,
                cells: &mut [$cell],
            ) {
                let operands = operands.map(|operand| &operand[..cells.len()]);
                // Limited before it is rounded: the limits are exact, so nothing changes.
                let (low, high) = (LIMITS.0 as f32, LIMITS.1 as f32);
                for (i, cell) in cells.iter_mut().enumerate() {
                    // A first sum with 0 would change nothing but the sign of a 0, and that
                    // is lost in the difference.
                    let mut sum = operands.first().map_or(0.0, |first| $wide(first[i]));
                    for operand in operands.iter().skip(1) {
                        sum += $wide(operand[i]);
                    }
                    let part = (0.0 - sum) / share.by as f32;
                    *cell = $narrow(if clip { part.clamp(low, high) } else { part });
                }
            }

            $($more)*
        }
    };
}

single_bus!(
    Single,
    f32,
    u32,
    "f32",
    crate::number::F32,
    std::convert::identity,
    std::convert::identity,
    {
        float_pair!(f32);
    }
);
single_bus!(
    Halves<f16>,
    f16,
    u16,
    "f16",
    crate::number::F16,
    number::f16_to_f32,
    number::f32_to_f16,
    {}
);
single_bus!(
    Halves<bf16>,
    bf16,
    u16,
    "bf16",
    crate::number::Bf16,
    number::bf16_to_f32,
    number::f32_to_bf16,
    {}
);
