//! Basic blocks: words between two operations of the host that look at the array or change it,
//! lowered to passes.

use super::{
    super::{
        Layout,
        semantics::{RowForm, row_form},
    },
    instruction::{Instruction, Word},
    liveness::{self, Live},
    pass::{Lowering, Pass, Tiles},
};
use crate::{
    isa::{Cell, Primitive},
    program::Host,
};

/// A basic block.
#[derive(Clone, Debug, Default)]
pub(in crate::array) struct Block {
    pub(in crate::array) words: Vec<Word>,
    /// What the host puts on the global input on the way.
    pub(in crate::array) inputs: Vec<Host>,
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
    pub(super) fn push(&mut self, primitive: &Primitive, line: u32) {
        self.words.push(Word {
            primitive: primitive.clone(),
            step: self.words.len() as u64,
            input: 1 + self.inputs.len(),
            line,
        });
    }

    /// Makes its passes, when it has all its words.
    pub(super) fn lower(&mut self, layout: &Layout, lowering: Lowering) {
        self.lower_with(layout, lowering, row_form);
    }

    /// The same, where another choice says which words have a row form.
    pub(super) fn lower_with(
        &mut self,
        layout: &Layout,
        lowering: Lowering,
        form: fn(&Primitive) -> Option<RowForm<'_>>,
    ) {
        if !lowering.passes {
            return;
        }
        let mut instructions = Vec::with_capacity(self.words.len());
        for word in &self.words {
            let Some(form) = form(&word.primitive) else {
                instructions.push(Instruction::Cells(word));
                continue;
            };
            let operands = layout.operands(&word.primitive);
            let copied = operands.copied();
            instructions.extend(copied.map(Instruction::Copy));
            self.copied.extend(copied);
            instructions.push(Instruction::Rows {
                word,
                form,
                copied: copied.is_some(),
                halo: operands.halo()[0],
                unit: operands.unit,
            });
        }
        self.copied.sort_unstable();
        self.copied.dedup();
        self.passes = [true, false].map(|whole| passes(&instructions, whole, layout, lowering));
    }
}

/// `whole`: FLAG is 1 in all pixels before the first.
fn passes(
    mut instructions: &[Instruction<'_>],
    whole: bool,
    layout: &Layout,
    mut lowering: Lowering,
) -> Vec<Pass> {
    // Bits are so few that all of them stay in the cache.
    if instructions.iter().all(Instruction::is_bits) {
        lowering.rows = layout.size.height;
    }
    let mut known = liveness::known(instructions, whole, layout);
    if lowering.stores_all {
        for known in &mut known {
            known.live = Live::ALL;
        }
    }
    let mut known = &known[..];
    let mut passes = Vec::new();
    while let Some(first) = instructions.first() {
        let (pass, taken) = match first {
            Instruction::Cells(word) => (Pass::Cells((*word).clone()), 1),
            Instruction::Rows { .. } | Instruction::Copy(_) => {
                let (tiles, taken) = Tiles::new(instructions, known, layout, lowering);
                (Pass::Tiles(tiles), taken)
            }
        };
        (instructions, known) = (&instructions[taken..], &known[taken..]);
        passes.push(pass);
    }
    passes
}
