//! Liveness: which registers are read before they are written again. A store that nobody reads is
//! dead, and is left out.

use super::{super::Layout, instruction::Instruction};
use crate::isa::{
    Analog, Cell, Operands,
    operands::{Access, FlagEffect},
};

/// A set of analogue registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Live(u64);

impl Live {
    /// All of them: what the host can see.
    pub(super) const ALL: Self = Self(!0);

    /// Registers beyond the sixty-fourth are always in it.
    fn bit(register: Analog) -> u64 {
        1u64.checked_shl(register.0.into()).unwrap_or(0)
    }

    pub(super) fn has(self, register: Analog) -> bool {
        let bit = Self::bit(register);
        bit == 0 || self.0 & bit != 0
    }

    fn insert(&mut self, register: Analog) {
        self.0 |= Self::bit(register);
    }

    fn remove(&mut self, register: Analog) {
        self.0 &= !Self::bit(register);
    }

    /// As it is before a word, if it is `self` after it; `whole`: FLAG is 1 in all pixels.
    fn before(mut self, operands: &Operands, whole: bool) -> Self {
        // Into NEWS of a neighbour, too, all cells are written: those at the border of the array
        // are driven from off it.
        let stored = || operands.writes().filter_map(Access::analog);
        let replaces = operands.replaces(whole);
        let unread = |write: &Access| write.analog().is_some_and(|register| !self.has(register));
        if replaces && stored().next().is_some() && operands.writes().all(unread) {
            // A dead store: nobody reads what it reads, either.
            return self;
        }
        for register in stored().filter(|_| replaces) {
            self.remove(register);
        }
        for register in operands.reads().filter_map(Access::analog) {
            self.insert(register);
        }
        self
    }
}

/// What is known about a word from those around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// FLAG is 1 in all pixels before it.
    pub(super) whole: bool,
    /// Which analogue registers are read after it, before all their cells are written.
    pub(super) live: Live,
}

impl Known {
    /// Nothing.
    pub(super) const NOTHING: Self = Self {
        whole: false,
        live: Live::ALL,
    };
}

/// What is known about each instruction; after the last the host looks. `whole`: FLAG is 1 in all
/// pixels before the first.
pub(super) fn known(
    instructions: &[Instruction<'_>],
    mut whole: bool,
    layout: &Layout,
) -> Vec<Known> {
    let operands = instructions.iter().map(|instruction| match instruction {
        Instruction::Rows { word, .. } | Instruction::Cells(word) => {
            Some(layout.operands(&word.primitive))
        }
        Instruction::Copy(_) => None,
    });
    let operands: Vec<_> = operands.collect();
    let mut all = Vec::with_capacity(instructions.len());
    for word in &operands {
        all.push(Known {
            whole,
            ..Known::NOTHING
        });
        if let Some(word) = word {
            match word.flag {
                FlagEffect::Keeps => {}
                FlagEffect::Sets => whole = true,
                FlagEffect::May => whole = false,
            }
        }
    }
    let mut live = Live::ALL;
    for ((instruction, word), known) in instructions.iter().zip(&operands).zip(&mut all).rev() {
        known.live = live;
        if let Some(word) = word {
            live = live.before(word, known.whole);
        } else if let Instruction::Copy(Cell::Analog(register)) = instruction {
            live.insert(*register);
        }
    }
    all
}
