//! Operations on rows: what [`semantics`](super::semantics) says of a pixel, on many at once.
//!
//! Which rows when is the business of a [`Schedule`](crate::array::Schedule). What reaches a row from its
//! neighbours is at most a halo away.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::Range;

use multiversion::multiversion;

use super::{
    super::{Place, RowOps, Settings, Share, State, Undecided, bits},
    fused::{fused, fused_interior},
    logic::{any, dnews, fill, logic},
    operation::{BusInput, Operation, Operations, Store},
    rows::{self, Links},
    sign::sign_bits,
    slab::{Copies, Slab},
    store::{store, store_interior},
};
use crate::{
    isa::{Analog, Bit, Cell, Direction, Primitive},
    plane::Size,
};

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
pub(super) fn copy<C: Clone>(slab: &mut Slab<'_, C>, cell: Cell, rows: Range<usize>) {
    match cell {
        Cell::Analog(register) => slab.copy(register, rows),
        Cell::Digital(register) => slab.copy_bits(register, rows),
        Cell::Flag => {}
    }
}

/// Does each operation on the rows that it is given: those are the rows that it writes. What it reads
/// beside them must lie in the slab, or off the array.
///
/// # Errors
/// Which operation has no answer in this domain.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn sweep<D: RowOps>(
    semantics: Semantics<'_, D>,
    slab: &mut Slab<'_, D::Cell>,
    operations: &Operations,
    spans: &[Range<usize>],
) -> Result<(), (usize, Undecided)> {
    for (k, (operation, rows)) in operations.operations.iter().zip(spans).enumerate() {
        if !rows.is_empty() {
            let done = semantics.execute(slab, operation, &operations.bus_inputs, rows.clone());
            done.map_err(|undecided| (k, undecided))?;
        }
    }
    Ok(())
}

/// The single stores of an operation, one after the other, some of them on no row: where something
/// comes from off the array, or the domain does not fuse, a fused store is two.
#[inline(always)]
fn single<'a>(
    operation: &'a Operation,
    k: usize,
    rows: &Range<usize>,
    inner: &Range<usize>,
) -> Option<(&'a Store, Range<usize>)> {
    match (operation, k) {
        (Operation::Store(store), 0) => Some((store, rows.clone())),
        (Operation::Fused(_), _) if inner == rows => None,
        (Operation::Fused(both), 0) => Some((&both.first, rows.start..inner.start)),
        (Operation::Fused(both), 1) => Some((&both.second, rows.start..inner.start)),
        (Operation::Fused(both), 2) => Some((&both.first, inner.end..rows.end)),
        (Operation::Fused(both), 3) => Some((&both.second, inner.end..rows.end)),
        _ => None,
    }
}

/// What words mean, in one domain.
pub(in crate::array) struct Semantics<'a, D> {
    pub(in crate::array) domain: &'a D,
    pub(in crate::array) settings: &'a Settings,
}

impl<D> Clone for Semantics<'_, D> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D> Copy for Semantics<'_, D> {}

impl<D: RowOps> Semantics<'_, D> {
    /// An operation of a [`sweep`].
    #[inline(always)]
    fn execute(
        self,
        slab: &mut Slab<'_, D::Cell>,
        operation: &Operation,
        bus_inputs: &[BusInput],
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        let clip = self.settings.clip;
        if !clip && self.interior(slab, operation, bus_inputs, &rows) {
            return Ok(());
        }
        // Where two stores are one.
        let inner = match operation {
            Operation::Fused(both) if self.domain.fuses() => {
                both.first.border.inside(slab.layout.size, &rows)
            }
            _ => rows.start..rows.start,
        };
        let mut k = 0;
        while let Some((target, rows)) = single(operation, k, &rows, &inner) {
            k += 1;
            if !rows.is_empty() {
                let bus_inputs = &bus_inputs[target.bus_inputs.clone()];
                let (mut view, room) = slab.view();
                store(self.domain, &mut view, bus_inputs, target, clip, rows, room);
            }
        }
        match operation {
            Operation::Fused(both) if self.domain.fuses() => {
                let (mut view, room) = slab.view();
                fused(self.domain, &mut view, bus_inputs, both, clip, inner, room);
            }
            // They are among those above.
            Operation::Store(_) | Operation::Fused(_) => {}
            Operation::Drive {
                bus_inputs: bus,
                driven,
                step,
            } => self.drive(
                slab,
                &bus_inputs[bus.clone()],
                driven,
                slab.first() + step,
                &rows,
            ),
            Operation::Square {
                bus_inputs: bus,
                step,
            } => {
                self.square(slab, &bus_inputs[bus.clone()], slab.first() + step, rows)?;
            }
            Operation::Sign {
                bus_inputs: bus,
                border,
            } => {
                let words = slab.row_words(rows.clone());
                let flag = slab.take_flag();
                let bits = &mut flag[words];
                let (view, _) = slab.view();
                let bus_inputs = &bus_inputs[bus.clone()];
                let result = sign_bits(self.domain, &view, bus_inputs, *border, bits, rows);
                slab.put_flag(flag);
                result?;
            }
            Operation::Logic(logic) => slab.logic(logic, rows),
            Operation::Word { word, step } => self.word(slab, word, slab.first() + step, rows),
            Operation::Copy(cell) => copy(slab, *cell, rows),
        }
        Ok(())
    }

    /// Stores in rows where no cell needs a choice, as most do: the short way. Whether they are
    /// such rows.
    #[inline(always)]
    fn interior(
        self,
        slab: &mut Slab<'_, D::Cell>,
        operation: &Operation,
        bus_inputs: &[BusInput],
        rows: &Range<usize>,
    ) -> bool {
        match operation {
            Operation::Store(target) if target.is_interior(rows, &slab.rows, slab.layout.size) => {
                let bus_inputs = &bus_inputs[target.bus_inputs.clone()];
                store_interior(self.domain, slab, bus_inputs, target, rows);
            }
            Operation::Fused(both)
                if both.interior
                    && self.domain.fuses()
                    && both.first.is_interior(rows, &slab.rows, slab.layout.size) =>
            {
                let bus_inputs = &bus_inputs[both.first.bus_inputs.clone()];
                fused_interior(self.domain, slab, bus_inputs, both, rows);
            }
            _ => return false,
        }
        true
    }

    /// A word that has no bus. PROP has no rows: see [`propagate`].
    #[inline(never)]
    fn word(self, slab: &mut Slab<'_, D::Cell>, word: &Primitive, step: u64, rows: Range<usize>) {
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
                let dark = self.domain.hold(self.settings.reset_level);
                let cells = slab.row_cells(rows);
                slab.pix()[cells].fill(dark);
            }
            Primitive::All => {
                let size = slab.layout.size;
                let words = slab.row_words(rows);
                let flag = slab.take_flag();
                bits::fill(&mut flag[words], size.width, true);
                slab.put_flag(flag);
            }
            Primitive::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                self.blur(slab, *target, *source, (*horizontal, *vertical), step, rows);
            }
            Primitive::Set { targets } => fill(slab, targets, true, rows),
            Primitive::Clear { targets } => fill(slab, targets, false, rows),
            Primitive::Or { target, sources } => logic(slab, *target, sources, false, rows),
            Primitive::Nor { target, sources } => logic(slab, *target, sources, true, rows),
            Primitive::WhereBit { sources } => {
                let words = slab.row_words(rows);
                let kept = sources.contains(&Bit::Flag);
                let flag = slab.take_flag();
                let bits = &mut flag[words.clone()];
                any(slab, bits, words, sources, Bit::Flag, (kept, false));
                slab.put_flag(flag);
            }
            Primitive::Dnews {
                target,
                source,
                boundary,
            } => dnews(slab, *target, *source, *boundary, rows),
        }
    }

    /// NEWS cells that several pixels drive: each holds the sum of what they put in.
    #[inline(never)]
    fn drive(
        self,
        slab: &mut Slab<'_, D::Cell>,
        bus_inputs: &[BusInput],
        driven: &[((isize, isize), Share)],
        step: u64,
        rows: &Range<usize>,
    ) {
        let register = slab.layout.news;
        let cells = slab.take(register);
        let (view, _) = slab.view();
        let width = view.size.width;
        for (y, x) in rows.clone().flat_map(|y| (0..width).map(move |x| (y, x))) {
            let mut total = self.domain.nothing();
            let mut any = None;
            for ((dy, dx), share) in driven {
                let (y, x) = (y.wrapping_add_signed(-dy), x.wrapping_add_signed(-dx));
                if view.flagged(y, x) {
                    let sum = view.sum(self.domain, bus_inputs, y, x);
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
                cells[view.cell(y, x)] = self.domain.limited(stored, self.settings.clip);
            }
        }
        slab.put(register, cells);
    }

    /// `gain` times the square of the bus, where FLAG is 1.
    #[inline(never)]
    fn square(
        self,
        slab: &mut Slab<'_, D::Cell>,
        bus_inputs: &[BusInput],
        step: u64,
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        let (register, gain) = (slab.layout.news, self.settings.square_gain);
        let cells = slab.take(register);
        let (view, _) = slab.view();
        let width = view.size.width;
        let mut decided = true;
        for (y, x) in rows.flat_map(|y| (0..width).map(move |x| (y, x))) {
            let place = Place {
                y,
                x,
                register,
                step,
            };
            let sum = view.sum(self.domain, bus_inputs, y, x);
            match self.domain.square(&sum, gain, place) {
                Some(cell) if view.flagged(y, x) => {
                    cells[view.cell(y, x)] = self.domain.limited(cell, self.settings.clip);
                }
                Some(_) => {}
                None => decided = false,
            }
        }
        slab.put(register, cells);
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
        slab: &mut Slab<'_, D::Cell>,
        target: Analog,
        source: Analog,
        (horizontal, vertical): (bool, bool),
        step: u64,
        rows: Range<usize>,
    ) {
        let Size { height, width } = slab.layout.size;
        let words = slab.words();
        let gates = Direction::ALL.map(|direction| {
            let wanted = match direction {
                Direction::North | Direction::South => vertical,
                Direction::East | Direction::West => horizontal,
            };
            wanted.then(|| slab.layout.roles.links(direction))
        });
        let mut linked = [const { Vec::new() }; 4].map(|_: Vec<u64>| vec![0; words]);
        let top = slab.rows.start;
        let cells = slab.take(target);
        let mut block = std::mem::take(&mut slab.cells);
        for y in rows {
            let row = |y: usize| slab.row_cells(y..y + 1);
            let mut beside = [y; 4];
            for (k, direction) in Direction::ALL.into_iter().enumerate() {
                let to = y.wrapping_add_signed(direction.step().0);
                linked[k].fill(0);
                if let (Some(gate), true) = (gates[k], to < height) {
                    beside[k] = to;
                    let gates = slab.digital(gate);
                    let (own, there) = (
                        &gates[slab.row_words(y..y + 1)],
                        &gates[slab.row_words(to..to + 1)],
                    );
                    for (i, word) in linked[k].iter_mut().enumerate() {
                        *word = own[i] & bits::seen(there, i, direction, width, false);
                    }
                }
            }
            let from = slab.analog(source, source == target);
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
            let flags = &slab.flag()[slab.row_words(y..y + 1)];
            let cells = &mut cells[(y - top) * width..][..width];
            let clip = self.settings.clip;
            rows::diffuse(self.domain, &links, flags, place, clip, cells, &mut block);
        }
        slab.put(target, cells);
        slab.cells = block;
    }
}
