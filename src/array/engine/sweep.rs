//! Operations on rows: what [`semantics`](super::semantics) says of a pixel, on many at once.
//!
//! Which rows when is the business of a [`Schedule`](super::Schedule). What reaches a row from its
//! neighbours is at most a halo away. Nothing here loops over cells: that do the rows of the domain,
//! of bits, and [`merge`](super::runs::merge), each compiled for several vector widths.

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

/// The single stores of an operation, one after the other, some of them on no row: where something
/// comes from off the array, or the domain does not fuse, a fused store is two.
#[inline]
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
    #[inline]
    fn execute(
        self,
        slab: &mut Slab<'_, D::Cell>,
        operation: &Operation,
        bus_inputs: &[BusInput],
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        let (domain, clip) = (self.domain, self.settings.clip);
        if !clip && self.interior(slab, operation, bus_inputs, &rows) {
            return Ok(());
        }
        // Where two stores are one.
        let inner = match operation {
            Operation::Fused(both) if domain.fuses() => {
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
                store(domain, &mut view, bus_inputs, target, clip, rows, room);
            }
        }
        match operation {
            Operation::Fused(both) if domain.fuses() => {
                let (mut view, room) = slab.view();
                fused(domain, &mut view, bus_inputs, both, clip, inner, room);
            }
            // They are among those above.
            Operation::Store(_) | Operation::Fused(_) => {}
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
            Operation::Neighbours(word) => slab.bits.neighbours(word, rows),
            Operation::Copy(cell) => slab.copy(*cell, rows),
        }
        Ok(())
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
