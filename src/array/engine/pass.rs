//! What becomes of a block, one pass over the array after the other: bands of rows that go through
//! many words while they are in the cache.
//!
//! ```text
//!            rows ─►                       word i works on rows [b·R - s, (b+1)·R - s), where
//!   word 0   ▐ band 0 ▐ band 1 ▐ band 2    s grows by the halo of a word, before and after
//!   word 1   ▐ band 0▐ band 1 ▐ band 2     it: what a word reads has been written by the words
//!   word 2   ▐ band 0▐ band 1 ▐ band 2     before it, and by none after it.
//!   word 3   ▐band 0 ▐ band 1▐ band 2
//! ```
//!
//! Each thread has rows of its own. Where they meet, both keep away by `s` from the seam, and
//! what is left open there is done when all have ended:
//!
//! ```text
//!   word 0   ▐ thread 0        ▌s▐        thread 1 ▐
//!   word 1   ▐ thread 0      ▌ seam ▐     thread 1 ▐
//! ```

use std::ops::Range;

use super::{
    super::{Layout, RowOps, State, Undecided},
    constants::Constants,
    instruction::{Instruction, Word},
    liveness::Known,
    operation::Operation,
    select::Operations,
    slab::{Copies, Slab},
    sweep::{self, Semantics},
};
use crate::{
    parallel::{self, Job},
    plane::Size,
};

/// Bands move up by so many rows at most: what is behind them leaves the cache.
const FARTHEST: usize = 16;

/// Bytes of a register in one band: those of the few registers that words in a row work on fit
/// into the cache next to a core, and a band is long enough that its beginning costs little.
const BAND: usize = 8192;

/// The rows of a band.
pub(super) fn rows(size: Size, cell: usize) -> usize {
    (BAND / (size.width * cell)).max(1)
}

/// How a schedule and a domain want blocks lowered.
#[derive(Clone, Copy, Debug)]
pub(in crate::array) struct Lowering {
    /// Rows of a tile; all of the array's where bits alone are worked on.
    pub(in crate::array) rows: usize,
    /// Whether dead stores are stored, too.
    pub(in crate::array) stores_all: bool,
    /// Whether two stores may be fused.
    pub(in crate::array) fuses: bool,
    /// Whether there are passes at all; else each cell is executed by itself.
    pub(in crate::array) passes: bool,
}

/// One pass over the array.
#[derive(Clone, Debug)]
pub(super) enum Pass {
    Tiles(Tiles),
    /// A word that has no row form: its meaning is executed, pixel by pixel, on the whole array.
    /// So nothing that it reads anywhere has changed, and its operands need not say how far it
    /// looks.
    Cells(Word),
}

/// A tile pass: words that the bands go through, and how far the bands have moved up at each.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    operations: Operations,
    /// Of each operation.
    shifts: Vec<usize>,
    lines: Vec<u32>,
    rows: usize,
}

impl Tiles {
    /// As many of the instructions as can go together, and how many they are.
    pub(super) fn new(
        instructions: &[Instruction<'_>],
        known: &[Known],
        layout: &Layout,
        lowering: Lowering,
    ) -> (Self, usize) {
        let mut pass = Self {
            operations: Operations::default(),
            shifts: Vec::with_capacity(instructions.len()),
            lines: Vec::with_capacity(instructions.len()),
            rows: lowering.rows,
        };
        let mut taken = 0;
        // One band does not move.
        let moves = lowering.rows < layout.size.height;
        let mut before = 0;
        for (instruction, known) in instructions.iter().zip(known) {
            let halo = if moves { instruction.halo() } else { 0 };
            let last = pass.shifts.last();
            let shift = last.map_or(halo, |last| last + halo.max(before));
            if shift > FARTHEST && last.is_some() {
                break;
            }
            let line = match instruction {
                Instruction::Copy(cell) => {
                    pass.operations.operations.push(Operation::Copy(*cell));
                    0
                }
                Instruction::Rows {
                    word, form, copied, ..
                } => {
                    pass.operations.word(word, *form, *copied, layout, *known);
                    word.line
                }
                Instruction::Cells(_) => break,
            };
            taken += 1;
            // It writes nothing that the one before it reads, nor reads beside its own pixel.
            let one_more = pass.operations.operations.len() == pass.shifts.len() + 1;
            if moves && lowering.fuses && one_more && pass.operations.join(known.live) {
                continue;
            }
            if pass.operations.operations.len() > pass.shifts.len() {
                before = halo;
            }
            pass.shifts.resize(pass.operations.operations.len(), shift);
            pass.lines.resize(pass.operations.operations.len(), line);
        }
        (pass, taken)
    }

    /// Runs them on the whole array.
    pub(super) fn run<D: RowOps>(
        &self,
        semantics: Semantics<'_, D>,
        threads: usize,
        state: &mut State<D::Cell>,
        copies: &mut Copies<D::Cell>,
        constants: &Constants<D::Cell>,
    ) -> Result<(), (u32, Undecided)> {
        let height = state.layout.size.height;
        let farthest = self.shifts.last().copied().unwrap_or(0);
        let parts = threads.min(height / (2 * farthest + self.rows)).max(1);
        let mut band = Slab::whole(state, copies, constants);
        if parts == 1 {
            return self.part(semantics, &mut band, 0..height);
        }
        let seams: Vec<usize> = (1..parts).map(|part| part * height / parts).collect();
        let mut bands = Vec::with_capacity(parts);
        for seam in &seams {
            let (above, below) = band.split(*seam);
            bands.push(above);
            band = below;
        }
        bands.push(band);
        let jobs = bands.into_iter().map(|mut band| -> Job<'_, _> {
            let rows = band.rows.clone();
            Box::new(move || self.part(semantics, &mut band, rows.clone()))
        });
        parallel::all(jobs)?;
        let mut band = Slab::whole(state, copies, constants);
        for seam in seams {
            let spans = self.shifts.iter().map(|shift| seam - shift..seam + shift);
            self.sweep(semantics, &mut band, &spans.collect::<Vec<_>>())?;
        }
        Ok(())
    }

    /// Each operation on its rows.
    fn sweep<D: RowOps>(
        &self,
        semantics: Semantics<'_, D>,
        band: &mut Slab<'_, D::Cell>,
        spans: &[Range<usize>],
    ) -> Result<(), (u32, Undecided)> {
        let done = sweep::sweep(semantics, band, &self.operations, spans);
        done.map_err(|(k, undecided)| (self.lines[k], undecided))
    }

    /// One thread's rows, band after band.
    fn part<D: RowOps>(
        &self,
        semantics: Semantics<'_, D>,
        band: &mut Slab<'_, D::Cell>,
        part: Range<usize>,
    ) -> Result<(), (u32, Undecided)> {
        let height = band.layout.size.height;
        let mut spans = Vec::with_capacity(self.shifts.len());
        let mut top = part.start;
        while top < part.end {
            let bottom = top + self.rows;
            spans.clear();
            for shift in &self.shifts {
                let from = if top == part.start {
                    top
                } else {
                    top.saturating_sub(*shift)
                };
                let to = if bottom >= part.end {
                    part.end
                } else {
                    bottom.saturating_sub(*shift)
                };
                // Away from the seams; the array's own borders are none.
                let first = part.start + if part.start == 0 { 0 } else { *shift };
                let last = part.end - if part.end == height { 0 } else { *shift };
                spans.push(from.max(first)..to.min(last));
            }
            self.sweep(semantics, band, &spans)?;
            top = bottom;
        }
        Ok(())
    }
}
