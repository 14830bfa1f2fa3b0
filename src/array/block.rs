//! Basic blocks: words between two operations of the host that look at the array or change it,
//! lowered to tile passes.

use super::{
    Layout,
    live::{self, Live},
    sweep::Issued,
    tiled::Pass,
};
use crate::{
    isa::{Cell, Primitive, operands::Unit},
    program::Host,
};

/// How a schedule and a domain want blocks lowered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lowering {
    /// Rows of a tile; all of the array's where bits alone are worked on.
    pub(super) rows: usize,
    /// Whether dead stores are stored, too.
    pub(super) stores_all: bool,
    /// Whether two stores may be fused.
    pub(super) fuses: bool,
    /// Whether there are passes at all; else each cell is executed by itself.
    pub(super) passes: bool,
}

/// A word of a block.
#[derive(Clone, Debug)]
pub(super) struct Word {
    pub(super) word: Primitive,
    /// Its number in the block.
    pub(super) step: u64,
    /// Which of the inputs of [`Constants`](super::band::Constants) the global input holds.
    pub(super) input: usize,
    pub(super) line: u32,
}

/// A word, or the copy of a register that the next word needs.
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
    const fn is_bits(&self) -> bool {
        matches!(
            self,
            Self::Word {
                unit: Unit::Logic | Unit::Idle,
                ..
            }
        )
    }
}

/// A basic block.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub(super) words: Vec<Word>,
    /// What the host puts on the global input on the way.
    pub(super) inputs: Vec<Host>,
    /// Registers that are copied.
    pub(super) copied: Vec<Cell>,
    /// Where FLAG is 1 in all pixels before it, and where it is not.
    pub(super) passes: [Vec<Pass>; 2],
}

impl Block {
    /// Words and inputs.
    pub(super) fn len(&self) -> usize {
        self.words.len() + self.inputs.len()
    }

    /// One more word.
    pub(super) fn push(&mut self, word: &Primitive, line: u32) {
        self.words.push(Word {
            word: word.clone(),
            step: self.words.len() as u64,
            input: 1 + self.inputs.len(),
            line,
        });
    }

    /// Makes its passes, when it has all its words.
    pub(super) fn lower(&mut self, layout: &Layout, lowering: Lowering) {
        if !lowering.passes {
            return;
        }
        let mut pieces = Vec::with_capacity(self.words.len());
        for Word {
            word,
            step,
            input,
            line,
        } in &self.words
        {
            let operands = layout.operands(word);
            let copied = operands.copied();
            pieces.extend(copied.map(Piece::Copy));
            self.copied.extend(copied);
            let issued = Issued {
                word,
                step: *step,
                input: *input,
                copied: copied.is_some(),
            };
            pieces.push(Piece::Word {
                issued,
                line: *line,
                halo: operands.halo()[0],
                unit: operands.unit,
            });
        }
        self.copied.sort_unstable();
        self.copied.dedup();
        self.passes = [true, false].map(|whole| passes(&pieces, whole, layout, lowering));
    }
}

/// `whole`: FLAG is 1 in all pixels before the first.
fn passes(
    mut pieces: &[Piece<'_>],
    whole: bool,
    layout: &Layout,
    mut lowering: Lowering,
) -> Vec<Pass> {
    // Bits are so few that all of them stay in the cache.
    if pieces.iter().all(Piece::is_bits) {
        lowering.rows = layout.size.height;
    }
    let mut known = live::known(pieces, whole, layout);
    if lowering.stores_all {
        for known in &mut known {
            known.live = Live::ALL;
        }
    }
    let mut known = &known[..];
    let mut passes = Vec::new();
    while !pieces.is_empty() {
        let pass = Pass::new(pieces, known, layout, lowering);
        (pieces, known) = (&pieces[pass.len()..], &known[pass.len()..]);
        passes.push(pass);
    }
    passes
}
