//! What a cell holds, and how the summing bus treats it.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::fmt::Debug;

use crate::isa::{Analog, Digital};

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

    /// `gain · sum²`, as it arrives in the cell at `place`; `None` where this domain has no answer.
    fn square(&self, sum: &Self::Sum, gain: f64, place: Place) -> Option<Self::Cell>;

    /// Whether the sum is above zero; `None` where this domain has no answer.
    fn positive(&self, sum: &Self::Sum) -> Option<bool>;

    /// The cell, limited to what lies between these two, in LSB.
    fn limit(&self, cell: Self::Cell, limits: (f64, f64)) -> Self::Cell;

    /// The cell, limited if stores are: `Settings::limits`.
    #[inline(always)]
    fn limited(&self, cell: Self::Cell, clip: Option<(f64, f64)>) -> Self::Cell {
        match clip {
            Some(limits) => self.limit(cell, limits),
            None => cell,
        }
    }

    /// What the DAC makes of a value in LSB, with or without the host's calibration.
    fn input(&self, value: f64, _calibrated: bool) -> Self::Cell {
        self.hold(value)
    }
}

/// What time does to cells. By default nothing.
pub trait Ageing: Domain {
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

/// Operations on rows of cells. Each says what [`Domain`] does cell by cell, and an arithmetic says
/// it again where it is faster together.
pub trait RowOps: Ageing {
    /// Whether a word gives the same from the same, whatever the place and the step.
    fn is_steady(&self) -> bool {
        true
    }

    /// Sets each cell to the nearest to `level + gain · value`, in LSB.
    #[inline(always)]
    fn hold_row(&self, level: f64, gain: f64, values: &[f64], cells: &mut [Self::Cell]) {
        for (cell, value) in cells.iter_mut().zip(values) {
            *cell = self.hold(level + gain * value);
        }
    }

    /// The cells `i` of all operands on one bus.
    fn sum(&self, operands: &[&[Self::Cell]], i: usize) -> Self::Sum {
        let mut sum = self.nothing();
        for operand in operands {
            self.add(&mut sum, &operand[i], 1);
        }
        sum
    }

    /// Stores along a row: the cell `i` right of `place` gets its share of what the operands
    /// have at `i`. As long as the cells are all operands, and not limited the cells.
    fn store_row(
        &self,
        operands: &[&[Self::Cell]],
        share: Share,
        place: Place,
        cells: &mut [Self::Cell],
    ) {
        for (i, cell) in cells.iter_mut().enumerate() {
            let x = place.x + i;
            *cell = self.store(&self.sum(operands, i), share, Place { x, ..place });
        }
    }

    /// Whether [`RowOps::store_fused`] can be asked, which is worth it where a store costs more
    /// than what is stored.
    fn fuses(&self) -> bool {
        false
    }

    /// Two stores at once, not limited: what the first makes of one or two operands, divided by
    /// 1 or 2, goes with the extra operand to the second, undivided, and from there to the cells.
    /// One of the first may be what the cells held before, as `own` says; it is not among the
    /// operands.
    #[inline(always)]
    fn store_fused(
        &self,
        _operands: &[&[Self::Cell]],
        _own: bool,
        _by: u32,
        _extra: Option<&[Self::Cell]>,
        _cells: &mut [Self::Cell],
    ) {
    }

    /// The bus of each cell, undivided, where its bit is 1, in one go; whether this domain does
    /// so. Else nothing is stored.
    #[inline(always)]
    fn store_some(
        &self,
        _operands: &[&[Self::Cell]],
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

    /// Sets each byte to 1 where the sum of what the operands have there is
    /// above zero, else to 0; whether this domain has an answer for all of them.
    fn positives(&self, operands: &[&[Self::Cell]], bytes: &mut [u8]) -> bool {
        let mut decided = true;
        for (i, byte) in bytes.iter_mut().enumerate() {
            let answer = self.positive(&self.sum(operands, i));
            decided &= answer.is_some();
            *byte = (answer == Some(true)).into();
        }
        decided
    }

    /// The same as the bits of words, 64 cells each, the lowest for the first; whether this
    /// domain does so. Else nothing is set.
    fn positive_words(&self, _operands: &[&[Self::Cell]], _words: &mut [u64]) -> bool {
        false
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
    pub const fn new(targets: usize, part: usize) -> Self {
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
