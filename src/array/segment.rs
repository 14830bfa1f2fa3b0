//! Words that wait to be run together: those between two operations of the host that look at
//! the array or change it.

use super::{Layout, State, band::Constants, sweep::Issued};
use crate::isa::{Cell, Primitive, operands::Unit};

/// As many pieces wait at most.
const FULL: usize = 1024;

/// One word, or the copy of a register that the next word needs.
#[derive(Clone, Copy, Debug)]
pub(super) enum Piece<'a> {
    Word {
        issued: Issued<'a>,
        line: u32,
        /// How many rows away it reads from the cell that it writes.
        halo: usize,
        unit: Unit,
    },
    Copy(Cell),
}

impl Piece<'_> {
    /// How many rows away it reads from the cell that it writes.
    pub(super) const fn halo(&self) -> usize {
        match self {
            Self::Word { halo, .. } => *halo,
            Self::Copy(_) => 0,
        }
    }

    /// Whether it is one-bit logic of each pixel alone.
    pub(super) fn is_bits(&self) -> bool {
        matches!(
            self,
            Self::Word {
                unit: Unit::Logic | Unit::Idle,
                ..
            }
        )
    }
}

/// Words that wait.
#[derive(Debug)]
pub(super) struct Segment<'a, C> {
    pieces: Vec<Piece<'a>>,
    constants: Constants<C>,
    layout: Layout,
}

impl<'a, C: Clone> Segment<'a, C> {
    pub(super) fn new(state: &State<C>) -> Self {
        Self {
            pieces: Vec::new(),
            constants: Constants::of(state, 0),
            layout: state.layout,
        }
    }

    /// One more word.
    pub(super) fn push(&mut self, word: &'a Primitive, step: u64, line: u32) {
        if self.pieces.is_empty() {
            self.constants.first = step;
        }
        let operands = self.layout.operands(word);
        let copied = operands.copied();
        self.pieces.extend(copied.map(Piece::Copy));
        let issued = Issued {
            word,
            step: step - self.constants.first,
            input: self.constants.last(),
            copied: copied.is_some(),
        };
        self.pieces.push(Piece::Word {
            issued,
            line,
            halo: operands.halo()[0],
            unit: operands.unit,
        });
    }

    /// The global input holds something else for the words to come.
    pub(super) fn input(&mut self, state: &State<C>) {
        self.constants.input(state);
    }

    pub(super) fn is_full(&self) -> bool {
        self.pieces.len() >= FULL
    }

    /// All have run.
    pub(super) fn clear(&mut self) {
        self.pieces.clear();
        self.constants.forget();
    }

    pub(super) fn pieces(&self) -> &[Piece<'a>] {
        &self.pieces
    }

    pub(super) const fn constants(&self) -> &Constants<C> {
        &self.constants
    }

    /// Registers that are copied.
    pub(super) fn copied(&self) -> impl Iterator<Item = Cell> {
        self.pieces.iter().filter_map(|piece| match piece {
            Piece::Copy(cell) => Some(*cell),
            Piece::Word { .. } => None,
        })
    }
}
