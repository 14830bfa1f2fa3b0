//! Operations on rows: what [`semantics`](super::semantics) says of a pixel, on many at once.
//!
//! Which rows when is the business of a [`Schedule`](crate::array::Schedule). What reaches a row from its
//! neighbours is at most a halo away. The loops over cells and bits, each compiled for several
//! vector widths, are elsewhere: in the domain, in `array/bits.rs`, in [`merge`](super::runs::merge).

use std::ops::Range;

use super::{
    super::{RowOps, Settings, Undecided},
    diffusion::diffuse,
    drive::drive,
    fused::{fused, fused_interior},
    operation::{BusInput, Operation, Store},
    planes,
    select::Operations,
    sign::sign_bits,
    slab::Slab,
    square::square,
    store::{store, store_interior},
};

/// Does each operation on the rows that it is given: those are the rows that it writes. What it reads
/// beside them must lie in the slab, or off the array.
///
/// # Errors
/// Which operation has no answer in this domain.
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
    #[inline]
    fn execute(
        self,
        slab: &mut Slab<'_, D::Cell>,
        operation: &Operation,
        bus_inputs: &[BusInput],
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        let (domain, clip) = (self.domain, self.settings.limits());
        if clip.is_none() && self.interior(slab, operation, bus_inputs, &rows) {
            return Ok(());
        }
        match operation {
            Operation::Store(target) => self.store(slab, target, bus_inputs, rows),
            Operation::Fused(both) => {
                let inner = if domain.fuses() {
                    both.first.border.inside(slab.layout.size, &rows)
                } else {
                    rows.start..rows.start
                };
                // Where something comes from off the array, or the domain does not fuse, they
                // are two.
                for rows in [rows.start..inner.start, inner.end..rows.end] {
                    self.store(slab, &both.first, bus_inputs, rows.clone());
                    self.store(slab, &both.second, bus_inputs, rows);
                }
                if domain.fuses() {
                    let (mut view, room) = slab.view();
                    fused(domain, &mut view, bus_inputs, both, clip, inner, room);
                }
            }
            Operation::Drive {
                bus_inputs: bus,
                driven,
                step,
            } => drive(
                domain,
                slab,
                &bus_inputs[bus.clone()],
                driven,
                *step,
                clip,
                rows,
            ),
            Operation::Square {
                bus_inputs: bus,
                step,
            } => square(
                domain,
                self.settings,
                slab,
                &bus_inputs[bus.clone()],
                *step,
                rows,
            )?,
            Operation::Sign {
                bus_inputs: bus,
                border,
            } => {
                let words = slab.bits.row_words(rows.clone());
                let plane = planes::flag(&slab.layout);
                let flag = slab.bits.take(plane);
                let bits = &mut flag[words];
                let (view, _) = slab.view();
                let bus_inputs = &bus_inputs[bus.clone()];
                let result = sign_bits(domain, &view, bus_inputs, *border, bits, rows);
                slab.bits.put(plane, flag);
                result?;
            }
            Operation::Reset => {
                let cells = slab.row_cells(rows);
                slab.pix()[cells].fill(domain.hold(self.settings.reset_level));
            }
            Operation::Diffusion(word) => diffuse(domain, self.settings, slab, word, rows),
            Operation::Logic(logic) => slab.bits.logic(logic, rows),
            Operation::MaskedLogic(logic) => slab.bits.masked_logic(logic, rows),
            Operation::Neighbours(word) => slab.bits.neighbours(*word, rows),
            Operation::Copy(cell) => slab.copy(*cell, rows),
        }
        Ok(())
    }

    /// One target of a bus, in any rows.
    fn store(
        self,
        slab: &mut Slab<'_, D::Cell>,
        target: &Store,
        bus_inputs: &[BusInput],
        rows: Range<usize>,
    ) {
        if !rows.is_empty() {
            let bus_inputs = &bus_inputs[target.bus_inputs.clone()];
            let (mut view, room) = slab.view();
            let clip = self.settings.limits();
            store(self.domain, &mut view, bus_inputs, target, clip, rows, room);
        }
    }

    /// Stores in rows where no cell needs a choice, as most do: the short way. Whether they are
    /// such rows.
    #[inline]
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
}
