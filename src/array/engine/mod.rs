//! Programs lowered, once, and run on many pixels at a time: what
//! [`semantics`](super::semantics) says of one pixel, to the bit.
//!
//! ```text
//!   body ─ lower ─► basic blocks ─ liveness, select ─► operations on rows ─ pass ─► tiles, threads
//!                                                      fused stores, masks         ─ sweep ─► store, sign, logic
//!                                                    ─► words that have no row form: cell by cell
//! ```

mod bit_slab;
mod block;
mod constants;
mod diffusion;
mod drive;
mod expose;
mod fused;
mod instruction;
mod liveness;
mod logic;
mod lower;
mod operation;
mod pass;
mod planes;
mod runs;
mod select;
mod sign;
mod slab;
mod square;
mod store;
mod sweep;
#[cfg(test)]
mod tests;
mod view;

pub(super) use expose::expose;
pub(super) use lower::{Counted, Lowered, Stage};
pub(super) use sweep::Semantics;

use self::{
    block::Block,
    constants::Constants,
    instruction::Word,
    pass::{Lowering, Pass},
    slab::Copies,
};
use super::{RowOps, Schedule, State, Undecided, semantics};
use crate::plane::Size;

/// Arrays of so many pixels are plainly run cell by cell: a row is no gain.
const CELLS: usize = 256;

/// A schedule, the threads that it may use, and room to work in.
#[derive(Clone, Debug)]
pub(super) struct Engine<C> {
    schedule: Schedule,
    threads: usize,
    size: Size,
    copies: Copies<C>,
    constants: Constants<C>,
}

impl<C: Clone + PartialEq + Send + Sync> Engine<C> {
    pub(super) fn new(state: &State<C>, schedule: Schedule, threads: usize) -> Self {
        Self {
            schedule,
            threads: threads.max(1),
            size: state.layout.size,
            copies: Copies::default(),
            constants: Constants::new(state),
        }
    }

    /// Whether rows would be no gain.
    fn is_cell_by_cell(&self) -> bool {
        self.schedule == Schedule::Plain && self.size.pixels() <= CELLS
    }

    /// How it wants blocks; `fuses`: the domain can fuse two stores.
    pub(super) fn lowering(&self, fuses: bool) -> Lowering {
        let rows = match self.schedule {
            Schedule::Plain => self.size.height,
            Schedule::Tiled { rows: 0 } => pass::rows(self.size, size_of::<C>()),
            Schedule::Tiled { rows } => rows,
        };
        Lowering {
            rows,
            stores_all: self.schedule == Schedule::Plain,
            fuses,
            passes: !self.is_cell_by_cell(),
        }
    }

    /// Makes ready for the next block: the number of its first word since power-on, what the
    /// global input holds, and what the host puts there on the way.
    pub(super) fn begin(&mut self, first: u64, input: &C, inputs: impl Iterator<Item = C>) {
        self.constants.first = first;
        self.constants.set_input(0, input);
        for (k, input) in (1..).zip(inputs) {
            self.constants.set_input(k, &input);
        }
    }

    /// Runs a block on the whole array.
    ///
    /// # Errors
    /// The line of a word that has no answer in this domain.
    pub(super) fn run<D: RowOps<Cell = C>>(
        &mut self,
        semantics: Semantics<'_, D>,
        state: &mut State<C>,
        block: &Block,
    ) -> Result<(), (u32, Undecided)> {
        if self.is_cell_by_cell() {
            for word in &block.words {
                cells(semantics, state, word, &self.constants)?;
            }
        } else {
            for register in &block.copied {
                self.copies.make(state, *register);
            }
            let threads = match self.schedule {
                Schedule::Plain => 1,
                Schedule::Tiled { .. } => self.threads,
            };
            let passes = &block.passes[usize::from(!state.flag.is_full())];
            let (copies, constants) = (&mut self.copies, &self.constants);
            let mut run = || {
                passes.iter().try_for_each(|pass| match pass {
                    Pass::Tiles(tiles) => tiles.run(semantics, threads, state, copies, constants),
                    Pass::Cells(word) => cells(semantics, state, word, constants),
                })
            };
            if threads > 1 {
                // Among the threads, so that they need not be woken for every pass.
                rayon::scope(|_| run())?;
            } else {
                run()?;
            }
        }
        state
            .input
            .clone_from(&self.constants.inputs[1 + block.inputs.len()][0]);
        Ok(())
    }
}

/// A word, pixel after pixel, as [`semantics`] says.
fn cells<D: RowOps>(
    semantics: Semantics<'_, D>,
    state: &mut State<D::Cell>,
    word: &Word,
    constants: &Constants<D::Cell>,
) -> Result<(), (u32, Undecided)> {
    let input = &constants.inputs[word.input][0];
    let step = constants.first + word.step;
    let (domain, settings) = (semantics.domain, semantics.settings);
    let ran = semantics::execute(domain, settings, state, &word.primitive, input, step);
    ran.map_err(|undecided| (word.line, undecided))
}
