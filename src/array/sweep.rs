//! Operations on rows: what [`semantics`](super::semantics) says of a pixel, on many at once.
//!
//! Which rows when is the business of a [`Schedule`](super::Schedule). What reaches a row from its
//! neighbours is at most a halo away.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::Range;

use multiversion::multiversion;

use super::{
    Place, RowOps, Settings, Share, State, Undecided,
    band::{Band, Copies},
    bits,
    logic::{any, dnews, fill, logic},
    pair::{pair, pair_level},
    positive::positive,
    rows::{self, Links},
    store::{store, store_level},
    wire::{Job, Jobs, Store, Wire},
};
use crate::{
    isa::{Analog, Bit, Cell, Direction, Primitive},
    plane::Size,
};

/// A word of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Issued<'a> {
    pub(super) word: &'a Primitive,
    /// Its number in the block.
    pub(super) step: u64,
    /// Which of the band's inputs the global input holds.
    pub(super) input: usize,
    /// Whether it reads the copy of a register: see [`Operands::copied`](crate::isa::Operands).
    pub(super) copied: bool,
}

/// Makes room for the copy of a register.
pub(super) fn make_copies<C: Clone>(copies: &mut Copies<C>, state: &State<C>, cell: Cell) {
    match cell {
        // FLAG is never read beside the pixel that writes it.
        Cell::Flag => {}
        Cell::Analog(_) => {
            let pixels = state.layout.size.pixels();
            copies.analog.resize(pixels, state.edge.clone());
        }
        Cell::Digital(_) => copies.bits.resize(state.flag.words().len(), 0),
    }
}

/// Copies rows of a register that a word reads and writes.
pub(super) fn copy<C: Clone>(band: &mut Band<'_, C>, cell: Cell, rows: Range<usize>) {
    match cell {
        Cell::Analog(register) => band.copy(register, rows),
        Cell::Digital(register) => band.copy_bits(register, rows),
        Cell::Flag => {}
    }
}

/// Does each job on the rows that it is given: those are the rows that it writes. What it reads
/// beside them must lie in the band, or off the array.
///
/// # Errors
/// Which job has no answer in this domain.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn sweep<D: RowOps>(
    array: Array<'_, D>,
    band: &mut Band<'_, D::Cell>,
    jobs: &Jobs,
    spans: &[Range<usize>],
) -> Result<(), (usize, Undecided)> {
    for (k, (job, rows)) in jobs.jobs.iter().zip(spans).enumerate() {
        if !rows.is_empty() {
            let done = array.execute(band, job, &jobs.wires, rows.clone());
            done.map_err(|undecided| (k, undecided))?;
        }
    }
    Ok(())
}

/// The single stores of a job, one after the other, some of them on no row: where something
/// comes from off the array, or the domain knows no pairs, a pair is two.
#[inline(always)]
fn single<'a>(
    job: &'a Job,
    k: usize,
    rows: &Range<usize>,
    inner: &Range<usize>,
) -> Option<(&'a Store, Range<usize>)> {
    match (job, k) {
        (Job::Store(store), 0) => Some((store, rows.clone())),
        (Job::Pair(_), _) if inner == rows => None,
        (Job::Pair(both), 0) => Some((&both.first, rows.start..inner.start)),
        (Job::Pair(both), 1) => Some((&both.second, rows.start..inner.start)),
        (Job::Pair(both), 2) => Some((&both.first, inner.end..rows.end)),
        (Job::Pair(both), 3) => Some((&both.second, inner.end..rows.end)),
        _ => None,
    }
}

/// What words mean, in one domain.
pub(super) struct Array<'a, D> {
    pub(super) domain: &'a D,
    pub(super) settings: &'a Settings,
}

impl<D> Clone for Array<'_, D> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D> Copy for Array<'_, D> {}

impl<D: RowOps> Array<'_, D> {
    /// A job of a [`sweep`].
    #[inline(always)]
    fn execute(
        self,
        band: &mut Band<'_, D::Cell>,
        job: &Job,
        wires: &[Wire],
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        let clip = self.settings.clip;
        if !clip && self.level(band, job, wires, &rows) {
            return Ok(());
        }
        // Where a pair is one.
        let inner = match job {
            Job::Pair(both) if self.domain.pairs() => {
                both.first.border.inside(band.layout.size, &rows)
            }
            _ => rows.start..rows.start,
        };
        let mut k = 0;
        while let Some((target, rows)) = single(job, k, &rows, &inner) {
            k += 1;
            if !rows.is_empty() {
                let wires = &wires[target.wires.clone()];
                let (mut field, room) = band.field();
                store(self.domain, &mut field, wires, target, clip, rows, room);
            }
        }
        match job {
            Job::Pair(both) if self.domain.pairs() => {
                let (mut field, room) = band.field();
                pair(self.domain, &mut field, wires, both, clip, inner, room);
            }
            // They are among those above.
            Job::Store(_) | Job::Pair(_) => {}
            Job::Drive {
                wires: bus,
                driven,
                step,
            } => self.drive(
                band,
                &wires[bus.clone()],
                driven,
                band.first() + step,
                &rows,
            ),
            Job::Square { wires: bus, step } => {
                self.square(band, &wires[bus.clone()], band.first() + step, rows)?;
            }
            Job::Positive { wires: bus, border } => {
                let words = band.row_words(rows.clone());
                let flag = band.take_flag();
                let bits = &mut flag[words];
                let (field, _) = band.field();
                let wires = &wires[bus.clone()];
                let result = positive(self.domain, &field, wires, *border, bits, rows);
                band.put_flag(flag);
                result?;
            }
            Job::Logic(logic) => band.logic(logic, rows),
            Job::Word { word, step } => self.word(band, word, band.first() + step, rows),
            Job::Copy(cell) => copy(band, *cell, rows),
        }
        Ok(())
    }

    /// Stores in rows where no cell needs a choice, as most do: the short way. Whether they are
    /// such rows.
    #[inline(always)]
    fn level(
        self,
        band: &mut Band<'_, D::Cell>,
        job: &Job,
        wires: &[Wire],
        rows: &Range<usize>,
    ) -> bool {
        match job {
            Job::Store(target) if target.is_level(rows, &band.rows, band.layout.size) => {
                let wires = &wires[target.wires.clone()];
                store_level(self.domain, band, wires, target, rows);
            }
            Job::Pair(both)
                if both.level
                    && self.domain.pairs()
                    && both.first.is_level(rows, &band.rows, band.layout.size) =>
            {
                let wires = &wires[both.first.wires.clone()];
                pair_level(self.domain, band, wires, both, rows);
            }
            _ => return false,
        }
        true
    }

    /// A word that has no bus. PROP has no rows: see [`propagate`].
    #[inline(never)]
    fn word(self, band: &mut Band<'_, D::Cell>, word: &Primitive, step: u64, rows: Range<usize>) {
        match word {
            Primitive::Nop
            | Primitive::BlurSet
            | Primitive::PropRead
            | Primitive::Prop { .. }
            // These have one.
            | Primitive::Bus { .. }
            | Primitive::Square { .. }
            | Primitive::Where { .. } => {}
            Primitive::ResetPix => {
                let level = self.domain.hold(self.settings.reset_level);
                let cells = band.row_cells(rows);
                band.pix()[cells].fill(level);
            }
            Primitive::All => {
                let size = band.layout.size;
                let words = band.row_words(rows);
                let flag = band.take_flag();
                bits::fill(&mut flag[words], size.width, true);
                band.put_flag(flag);
            }
            Primitive::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                self.blur(band, *target, *source, (*horizontal, *vertical), step, rows);
            }
            Primitive::Set { targets } => fill(band, targets, true, rows),
            Primitive::Clear { targets } => fill(band, targets, false, rows),
            Primitive::Or { target, sources } => logic(band, *target, sources, false, rows),
            Primitive::Nor { target, sources } => logic(band, *target, sources, true, rows),
            Primitive::WhereBit { sources } => {
                let words = band.row_words(rows);
                let kept = sources.contains(&Bit::Flag);
                let flag = band.take_flag();
                let bits = &mut flag[words.clone()];
                any(band, bits, words, sources, Bit::Flag, (kept, false));
                band.put_flag(flag);
            }
            Primitive::Dnews {
                target,
                source,
                boundary,
            } => dnews(band, *target, *source, *boundary, rows),
        }
    }

    /// NEWS cells that several pixels drive: each holds the sum of what they put in.
    #[inline(never)]
    fn drive(
        self,
        band: &mut Band<'_, D::Cell>,
        wires: &[Wire],
        driven: &[((isize, isize), Share)],
        step: u64,
        rows: &Range<usize>,
    ) {
        let register = band.layout.news;
        let cells = band.take(register);
        let (field, _) = band.field();
        let width = field.size.width;
        for (y, x) in rows.clone().flat_map(|y| (0..width).map(move |x| (y, x))) {
            let mut total = self.domain.nothing();
            let mut any = None;
            for ((dy, dx), share) in driven {
                let (y, x) = (y.wrapping_add_signed(-dy), x.wrapping_add_signed(-dx));
                if field.flagged(y, x) {
                    let sum = field.sum(self.domain, wires, y, x);
                    self.domain.join(&mut total, &sum);
                    any = Some(*share);
                }
            }
            if let Some(share) = any {
                let place = Place {
                    y,
                    x,
                    register,
                    step,
                };
                let stored = self.domain.store(&total, share, place);
                cells[field.cell(y, x)] = self.domain.limited(stored, self.settings.clip);
            }
        }
        band.put(register, cells);
    }

    /// `gain` times the square of the bus, where FLAG is 1.
    #[inline(never)]
    fn square(
        self,
        band: &mut Band<'_, D::Cell>,
        wires: &[Wire],
        step: u64,
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        let (register, gain) = (band.layout.news, self.settings.square_gain);
        let cells = band.take(register);
        let (field, _) = band.field();
        let width = field.size.width;
        let mut decided = true;
        for (y, x) in rows.flat_map(|y| (0..width).map(move |x| (y, x))) {
            let place = Place {
                y,
                x,
                register,
                step,
            };
            let sum = field.sum(self.domain, wires, y, x);
            match self.domain.square(&sum, gain, place) {
                Some(cell) if field.flagged(y, x) => {
                    cells[field.cell(y, x)] = self.domain.limited(cell, self.settings.clip);
                }
                Some(_) => {}
                None => decided = false,
            }
        }
        band.put(register, cells);
        if decided {
            Ok(())
        } else {
            Err(Undecided { operation: "sq" })
        }
    }

    /// One explicit step of diffusion. A link conducts where the gates of both its pixels are
    /// open: R1 along columns, R2 along rows. Nothing flows over the border.
    fn blur(
        self,
        band: &mut Band<'_, D::Cell>,
        target: Analog,
        source: Analog,
        (horizontal, vertical): (bool, bool),
        step: u64,
        rows: Range<usize>,
    ) {
        let Size { height, width } = band.layout.size;
        let words = band.words();
        let gates = Direction::ALL.map(|direction| {
            let wanted = match direction {
                Direction::North | Direction::South => vertical,
                Direction::East | Direction::West => horizontal,
            };
            wanted.then(|| band.layout.roles.links(direction))
        });
        let mut linked = [const { Vec::new() }; 4].map(|_: Vec<u64>| vec![0; words]);
        let top = band.rows.start;
        let cells = band.take(target);
        let mut block = std::mem::take(&mut band.cells);
        for y in rows {
            let row = |y: usize| band.row_cells(y..y + 1);
            let mut beside = [y; 4];
            for (k, direction) in Direction::ALL.into_iter().enumerate() {
                let to = y.wrapping_add_signed(direction.step().0);
                linked[k].fill(0);
                if let (Some(gate), true) = (gates[k], to < height) {
                    beside[k] = to;
                    let gates = band.digital(gate);
                    let (own, there) = (
                        &gates[band.row_words(y..y + 1)],
                        &gates[band.row_words(to..to + 1)],
                    );
                    for (i, word) in linked[k].iter_mut().enumerate() {
                        *word = own[i] & bits::seen(there, i, direction, width, false);
                    }
                }
            }
            let from = band.analog(source, source == target);
            let links = Links {
                own: &from[row(y)],
                beside: beside.map(|y| &from[row(y)]),
                linked: linked.each_ref().map(Vec::as_slice),
                parts: self.settings.diffusion.max(4).into(),
            };
            let place = Place {
                y,
                x: 0,
                register: target,
                step,
            };
            let flags = &band.flag()[band.row_words(y..y + 1)];
            let cells = &mut cells[(y - top) * width..][..width];
            let clip = self.settings.clip;
            rows::diffuse(self.domain, &links, flags, place, clip, cells, &mut block);
        }
        band.put(target, cells);
        band.cells = block;
    }
}
