//! The words of a basic block.

use super::super::semantics::RowForm;
use crate::isa::{Cell, Primitive, operands::Unit};

/// A word of a block.
#[derive(Clone, Debug)]
pub(in crate::array) struct Word {
    pub(in crate::array) primitive: Primitive,
    /// Its number in the block.
    pub(in crate::array) step: u64,
    /// Which of the inputs of [`Constants`](super::constants::Constants) the global input holds.
    pub(in crate::array) input: usize,
    pub(in crate::array) line: u32,
}

/// A word, or the copy of a register that the next word needs.
#[derive(Clone, Copy, Debug)]
pub(super) enum Instruction<'a> {
    /// A word that has a row form.
    Rows {
        word: &'a Word,
        form: RowForm<'a>,
        /// Whether it reads the copy of a register: see [`Operands::copied`](crate::isa::Operands).
        copied: bool,
        /// How many rows away it reads from the cell that it writes.
        halo: usize,
        unit: Unit,
    },
    /// A word that has none.
    Cells(&'a Word),
    Copy(Cell),
}

impl Instruction<'_> {
    /// How many rows away it reads from the cell that it writes.
    pub(super) const fn halo(&self) -> usize {
        match self {
            Self::Rows { halo, .. } => *halo,
            Self::Cells(_) | Self::Copy(_) => 0,
        }
    }

    /// Whether those beside it in a pass may be one-bit logic of each pixel alone.
    pub(super) const fn is_bits(&self) -> bool {
        match self {
            Self::Rows { unit, .. } => matches!(unit, Unit::Logic | Unit::Idle),
            // A pass of its own.
            Self::Cells(_) => true,
            Self::Copy(_) => false,
        }
    }
}
