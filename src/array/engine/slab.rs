//! Rows of every plane of the array: what one thread may read and write.

use std::ops::Range;

use super::{
    super::{Layout, State},
    bit_slab::{BitSlab, split_all},
    constants::Constants,
    planes,
    runs::ROOM,
    view::View,
};
use crate::isa::{Analog, Cell};

/// Planes beside the registers: of one that a word reads at neighbours and writes itself,
/// what it held before the word. They are made when they are first needed.
#[derive(Clone, Debug)]
pub(super) struct Copies<C> {
    analog: Vec<C>,
    bits: Vec<u64>,
}

impl<C> Default for Copies<C> {
    fn default() -> Self {
        Self {
            analog: Vec::new(),
            bits: Vec::new(),
        }
    }
}

impl<C: Clone> Copies<C> {
    /// Makes room for the copy of a register.
    pub(super) fn make(&mut self, state: &State<C>, cell: Cell) {
        match cell {
            // FLAG is never read beside the pixel that writes it.
            Cell::Flag => {}
            Cell::Analog(_) => {
                let pixels = state.layout.size.pixels();
                self.analog.resize(pixels, state.edge.clone());
            }
            Cell::Digital(_) => self.bits.resize(state.flag.words().len(), 0),
        }
    }
}

/// Rows of every plane.
pub(super) struct Slab<'a, C> {
    /// Of the whole array.
    pub(super) layout: Layout,
    /// Which rows these are.
    pub(super) rows: Range<usize>,
    /// Registers; then the copy, where there is one; then the photodiodes: see [`planes`].
    analog: Vec<&'a mut [C]>,
    pub(super) bits: BitSlab<'a>,
    constants: &'a Constants<C>,
    /// Room for blocks of cells.
    pub(super) room: Vec<C>,
}

impl<'a, C: Clone> Slab<'a, C> {
    /// All rows.
    pub(super) fn whole(
        state: &'a mut State<C>,
        copies: &'a mut Copies<C>,
        constants: &'a Constants<C>,
    ) -> Self {
        let layout = state.layout;
        let mut analog: Vec<&mut [C]> = state.analog.iter_mut().map(|plane| &mut **plane).collect();
        analog.push(&mut copies.analog);
        analog.push(&mut state.pix);
        let host = [&state.select, &state.rect];
        Self {
            layout,
            rows: 0..layout.size.height,
            analog,
            bits: BitSlab::whole(
                layout,
                &mut state.digital,
                &mut copies.bits,
                &mut state.flag,
                host,
            ),
            constants,
            room: vec![state.edge.clone(); ROOM],
        }
    }

    /// The rows above `row`, and those from there on.
    pub(super) fn split(self, row: usize) -> (Self, Self) {
        let at = (row - self.rows.start) * self.layout.size.width;
        let (above, below) = split_all(self.analog, at);
        let (bits_above, bits_below) = self.bits.split(row);
        let top = Slab {
            layout: self.layout,
            rows: self.rows.start..row,
            analog: above,
            bits: bits_above,
            constants: self.constants,
            room: self.room.clone(),
        };
        let bottom = Slab {
            layout: self.layout,
            rows: row..self.rows.end,
            analog: below,
            bits: bits_below,
            constants: self.constants,
            room: self.room,
        };
        (top, bottom)
    }

    /// Copies rows of a register.
    pub(super) fn copy(&mut self, cell: Cell, rows: Range<usize>) {
        match cell {
            Cell::Analog(register) => {
                let cells = self.row_cells(rows);
                let (registers, copies) = self.analog.split_at_mut(planes::copy(&self.layout));
                let register = &registers[usize::from(register.0)];
                copies[0][cells.clone()].clone_from_slice(&register[cells]);
            }
            Cell::Digital(register) => self.bits.copy(register, rows),
            Cell::Flag => {}
        }
    }
}

impl<'a, C> Slab<'a, C> {
    /// The number of the first word since power-on.
    pub(super) const fn first(&self) -> u64 {
        self.constants.first
    }

    /// Takes a register out, to be put back.
    pub(super) fn take(&mut self, register: Analog) -> &'a mut [C] {
        std::mem::take(&mut self.analog[usize::from(register.0)])
    }

    /// Puts a register back.
    pub(super) fn put(&mut self, register: Analog, cells: &'a mut [C]) {
        self.analog[usize::from(register.0)] = cells;
    }

    /// What a word reads: a register, or the copy of it.
    pub(super) fn analog(&self, register: Analog, copied: bool) -> &[C] {
        if copied {
            self.analog[planes::copy(&self.layout)]
        } else {
            self.analog[usize::from(register.0)]
        }
    }

    /// The photodiodes.
    pub(super) fn pix(&mut self) -> &mut [C] {
        self.analog[planes::light(&self.layout)]
    }

    /// What loops over pixels read, and the room that they need.
    #[inline]
    pub(super) fn view(&mut self) -> (View<'_, 'a, C>, &mut [C]) {
        let view = View {
            size: self.layout.size,
            top: self.rows.start,
            planes: &mut self.analog,
            flag: self.bits.flag(),
            constants: self.constants,
        };
        (view, &mut self.room)
    }

    /// Where rows of cells lie in a plane of this slab.
    pub(super) fn row_cells(&self, rows: Range<usize>) -> Range<usize> {
        let (top, width) = (self.rows.start, self.layout.size.width);
        (rows.start - top) * width..(rows.end - top) * width
    }
}
