//! The words of a basic block.

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
pub(in crate::array) enum Instruction<'a> {
    Word {
        word: &'a Word,
        /// Whether it reads the copy of a register: see [`Operands::copied`](crate::isa::Operands).
        copied: bool,
        /// How many rows away it reads from the cell that it writes.
        halo: usize,
        unit: Unit,
    },
    Copy(Cell),
}

impl Instruction<'_> {
    /// How many rows away it reads from the cell that it writes.
    pub(in crate::array) const fn halo(&self) -> usize {
        match self {
            Self::Word { halo, .. } => *halo,
            Self::Copy(_) => 0,
        }
    }

    /// Whether it is one-bit logic of each pixel alone.
    pub(in crate::array) const fn is_bits(&self) -> bool {
        matches!(
            self,
            Self::Word {
                unit: Unit::Logic | Unit::Idle,
                ..
            }
        )
    }
}
