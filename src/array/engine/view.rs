//! What the loops over pixels read: planes, and what lies off the array.

use std::ops::Range;

use super::{
    super::{Place, RowOps},
    constants::Constants,
    operation::{Border, BusInput, Store},
};
use crate::{isa::Analog, plane::Size};

/// Wires of a bus that is worked on many pixels at once, at most.
pub(super) const BUS_INPUTS: usize = 4;

/// Cells that follow each other in a plane.
pub(super) struct Stretch {
    /// The column of the first.
    pub(super) left: usize,
    /// Where it lies in its plane.
    pub(super) at: usize,
    pub(super) n: usize,
}

/// Some rows of the array.
pub(super) struct View<'b, 'a, C> {
    /// Of the whole array.
    pub(super) size: Size,
    /// The row that comes first in all planes.
    pub(super) top: usize,
    pub(super) planes: &'b mut [&'a mut [C]],
    pub(super) flag: &'b [u64],
    pub(super) constants: &'b Constants<C>,
}

impl<'a, C> View<'_, 'a, C> {
    /// Where a cell lies that is stored into, and when that is.
    #[inline]
    pub(super) fn place(&self, store: &Store, y: usize, x: usize) -> Place {
        Place {
            y,
            x,
            register: store.register,
            step: self.constants.first + store.step,
        }
    }

    /// Takes a register out, to be put back.
    pub(super) fn take(&mut self, register: Analog) -> &'a mut [C] {
        std::mem::take(&mut self.planes[usize::from(register.0)])
    }

    /// Puts a register back.
    pub(super) fn put(&mut self, register: Analog, cells: &'a mut [C]) {
        self.planes[usize::from(register.0)] = cells;
    }

    /// Where a cell lies in its plane.
    #[inline]
    pub(super) const fn cell(&self, y: usize, x: usize) -> usize {
        (y - self.top) * self.size.width + x
    }

    /// The cells of some rows, from the first that needs nothing from off the array to the last;
    /// those between, at the ends of rows, are among them.
    #[inline]
    pub(super) fn between(&self, border: Border, rows: &Range<usize>) -> Stretch {
        let left = border.left;
        Stretch {
            left,
            at: self.cell(rows.start, left),
            n: rows.len() * self.size.width - left - border.right,
        }
    }

    /// The same, where it does not matter what is stored at the ends of rows: if it can be, from
    /// the beginning of the first to the end of the last, so that vectors do not lie across
    /// lines of the cache.
    #[inline]
    pub(super) fn stretch(
        &self,
        bus_inputs: &[BusInput],
        beside: (isize, isize),
        border: Border,
        rows: &Range<usize>,
    ) -> Stretch {
        let (at, n) = (self.cell(rows.start, 0), rows.len() * self.size.width);
        let mut fits = true;
        for bus_input in bus_inputs {
            let (dy, dx) = (bus_input.beside.0 - beside.0, bus_input.beside.1 - beside.1);
            let start = at as isize + dy * self.size.width as isize + dx;
            let cells = match self.planes.get(bus_input.plane) {
                Some(plane) => plane.len(),
                None => usize::MAX,
            };
            fits &= start >= 0 && start as usize + n <= cells;
        }
        if fits {
            Stretch { left: 0, at, n }
        } else {
            self.between(border, rows)
        }
    }

    /// Where each bus input begins, that leads to the cells of a plane from `at` on; those lie
    /// `beside` the pixels whose bus they get.
    #[inline]
    pub(super) fn starts<const N: usize>(
        &self,
        bus_inputs: &[BusInput; N],
        at: usize,
        beside: (isize, isize),
    ) -> [usize; N] {
        let mut starts = [0; N];
        for (start, bus_input) in starts.iter_mut().zip(bus_inputs) {
            let (dy, dx) = (bus_input.beside.0 - beside.0, bus_input.beside.1 - beside.1);
            *start = at.wrapping_add_signed(dy * self.size.width as isize + dx);
        }
        starts
    }

    /// Where the bus inputs of the buses of one row lead, which may lie off the array.
    #[inline]
    pub(super) fn beyond<const N: usize>(
        &self,
        bus_inputs: &[BusInput; N],
        y: usize,
    ) -> [BusInput; N] {
        let mut bus_inputs = *bus_inputs;
        for bus_input in &mut bus_inputs {
            if y >= self.size.height
                || y.wrapping_add_signed(bus_input.beside.0) >= self.size.height
            {
                // The first of the inputs is what lies there.
                *bus_input = BusInput {
                    plane: self.planes.len(),
                    beside: (0, 0),
                };
            }
        }
        bus_inputs
    }

    /// What comes along each bus input: `n` cells, at most a [`PIECE`], so many after its start.
    #[inline]
    pub(super) fn sources<const N: usize>(
        &self,
        bus_inputs: &[BusInput; N],
        starts: &[usize; N],
        after: usize,
        n: usize,
    ) -> [&[C]; N] {
        let mut sources: [&[C]; N] = [&[]; N];
        for ((source, bus_input), start) in sources.iter_mut().zip(bus_inputs).zip(starts) {
            *source = self.source(*bus_input, start.wrapping_add(after), n);
        }
        sources
    }

    /// `n` cells from `at` on that come along one.
    #[inline]
    pub(super) fn source(&self, bus_input: BusInput, at: usize, n: usize) -> &[C] {
        match self.planes.get(bus_input.plane) {
            Some(plane) => &plane[at..][..n],
            None => &self.constants.inputs[bus_input.plane - self.planes.len()][..n],
        }
    }

    /// The words of FLAG of some rows.
    #[inline]
    pub(super) fn flags(&self, y: usize, rows: usize) -> &[u64] {
        let words = self.size.width.div_ceil(64);
        &self.flag[(y - self.top) * words..][..rows * words]
    }

    /// FLAG of a pixel; off the array it is 1.
    pub(super) fn flagged(&self, y: usize, x: usize) -> bool {
        let Size { height, width } = self.size;
        y >= height || x >= width || self.flags(y, 1)[x / 64] >> (x % 64) & 1 == 1
    }

    /// What a bus input leads to from the bus of a pixel, which may lie off the array.
    #[inline]
    fn at(&self, bus_input: BusInput, y: usize, x: usize) -> &C {
        let Size { height, width } = self.size;
        let (to_y, to_x) = (
            y.wrapping_add_signed(bus_input.beside.0),
            x.wrapping_add_signed(bus_input.beside.1),
        );
        if y < height && x < width && to_y < height && to_x < width {
            match self.planes.get(bus_input.plane) {
                Some(plane) => &plane[self.cell(to_y, to_x)],
                None => &self.constants.inputs[bus_input.plane - self.planes.len()][0],
            }
        } else {
            &self.constants.edge
        }
    }

    /// The bus of a pixel, which may lie off the array.
    #[inline]
    pub(super) fn sum<D: RowOps<Cell = C>>(
        &self,
        domain: &D,
        bus_inputs: &[BusInput],
        y: usize,
        x: usize,
    ) -> D::Sum {
        let mut sum = domain.nothing();
        for bus_input in bus_inputs {
            domain.add(&mut sum, self.at(*bus_input, y, x), 1);
        }
        sum
    }
}

impl<C: Clone> View<'_, '_, C> {
    /// Writes cells of a register one below the other.
    pub(super) fn put_column(&mut self, register: Analog, y: usize, x: usize, new: &[C]) {
        let (from, width) = (self.cell(y, x), self.size.width);
        let plane = &mut self.planes[usize::from(register.0)];
        for (cell, new) in plane[from..].iter_mut().step_by(width).zip(new) {
            cell.clone_from(new);
        }
    }

    /// Writes the same into all cells of a column.
    pub(super) fn fill_column(&mut self, register: Analog, rows: &Range<usize>, x: usize, new: &C) {
        let (from, width) = (self.cell(rows.start, x), self.size.width);
        let plane = &mut self.planes[usize::from(register.0)];
        for cell in plane[from..].iter_mut().step_by(width).take(rows.len()) {
            cell.clone_from(new);
        }
    }

    /// What a bus input leads to from the buses of one column, which may lie off the array; its rows
    /// and those where the bus input leads do not.
    #[inline]
    pub(super) fn column(&self, bus_input: BusInput, y: usize, x: usize, cells: &mut [C]) {
        let width = self.size.width;
        let (to_y, to_x) = (
            y.wrapping_add_signed(bus_input.beside.0),
            x.wrapping_add_signed(bus_input.beside.1),
        );
        match self.planes.get(bus_input.plane) {
            Some(plane) if x < width && to_x < width => {
                let there = plane[self.cell(to_y, to_x)..].iter().step_by(width);
                for (cell, there) in cells.iter_mut().zip(there) {
                    cell.clone_from(there);
                }
            }
            _ => cells.fill(self.at(bus_input, y, x).clone()),
        }
    }
}
