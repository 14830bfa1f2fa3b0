//! Words that wait to be run together: those between two operations of the host that look at
//! the array or change it.

use super::{
    State,
    band::Constants,
    reach::{self, Register},
    semantics::Issued,
};
use crate::isa::{Analog, Primitive};

/// As many pieces wait at most.
const FULL: usize = 1024;

/// One word, or the copy of a register that the next word needs.
#[derive(Clone, Copy, Debug)]
pub(super) enum Piece<'a> {
    Word { issued: Issued<'a>, line: u32 },
    Copy(Register),
}

impl Piece<'_> {
    /// How many rows away it reads from the cell that it writes.
    pub(super) fn reach(&self) -> usize {
        match self {
            Self::Word { issued, .. } => reach::reach(issued.word),
            Self::Copy(_) => 0,
        }
    }

    /// Whether it is one-bit logic of each pixel alone.
    pub(super) fn is_bits(&self) -> bool {
        let Self::Word { issued, .. } = self else {
            return false;
        };
        match issued.word {
            Primitive::Or { .. }
            | Primitive::Nor { .. }
            | Primitive::WhereBit { .. }
            | Primitive::Set { .. }
            | Primitive::Clear { .. }
            | Primitive::All
            | Primitive::Nop => true,
            Primitive::ResetPix
            | Primitive::Bus { .. }
            | Primitive::Square { .. }
            | Primitive::Where { .. }
            | Primitive::BlurSet
            | Primitive::Blur { .. }
            | Primitive::Dnews { .. }
            | Primitive::PropRead
            | Primitive::Prop { .. } => false,
        }
    }
}

/// Words that wait.
#[derive(Debug)]
pub(super) struct Segment<'a, C> {
    pieces: Vec<Piece<'a>>,
    constants: Constants<C>,
    news: Analog,
}

impl<'a, C: Clone> Segment<'a, C> {
    pub(super) fn new(state: &State<C>) -> Self {
        Self {
            pieces: Vec::new(),
            constants: Constants::of(state, 0),
            news: state.layout.news,
        }
    }

    /// One more word.
    pub(super) fn push(&mut self, word: &'a Primitive, step: u64, line: u32) {
        if self.pieces.is_empty() {
            self.constants.first = step;
        }
        let copied = reach::copied(word, self.news);
        self.pieces.extend(copied.map(Piece::Copy));
        let issued = Issued {
            word,
            step: step - self.constants.first,
            input: self.constants.last(),
            copied: copied.is_some(),
        };
        self.pieces.push(Piece::Word { issued, line });
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
    pub(super) fn copied(&self) -> impl Iterator<Item = Register> {
        self.pieces.iter().filter_map(|piece| match piece {
            Piece::Copy(register) => Some(*register),
            Piece::Word { .. } => None,
        })
    }
}
