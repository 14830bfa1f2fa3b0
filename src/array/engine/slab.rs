//! Rows of every plane of the array: what one thread may read and write.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::ops::Range;

use super::{
    super::{BitPlane, Layout, State, bits},
    constants::Constants,
    operation::Logic,
    planes,
    runs::ROOM,
    view::View,
};
use crate::isa::{Analog, Bit, Digital};

/// Planes beside the registers: of one that a word reads at neighbours and writes itself,
/// what it held before the word. They are made when they are first needed.
#[derive(Clone, Debug)]
pub(super) struct Copies<C> {
    pub(super) analog: Vec<C>,
    pub(super) bits: Vec<u64>,
}

impl<C> Default for Copies<C> {
    fn default() -> Self {
        Self {
            analog: Vec::new(),
            bits: Vec::new(),
        }
    }
}

/// Rows of every plane.
pub(super) struct Slab<'a, C> {
    /// Of the whole array.
    pub(super) layout: Layout,
    /// Which rows these are.
    pub(super) rows: Range<usize>,
    /// Registers; then the copy, where there is one; then the photodiodes.
    analog: Vec<&'a mut [C]>,
    /// Registers; then the copy, where there is one; then FLAG.
    digital: Vec<&'a mut [u64]>,
    select: &'a [u64],
    rect: &'a [u64],
    constants: &'a Constants<C>,
    /// Room for blocks of cells.
    pub(super) cells: Vec<C>,
    /// Room for a row of bits.
    pub(super) bits: Vec<u64>,
}

impl<'a, C: Clone> Slab<'a, C> {
    /// All rows.
    pub(super) fn whole(
        state: &'a mut State<C>,
        copies: &'a mut Copies<C>,
        constants: &'a Constants<C>,
    ) -> Self {
        let layout = state.layout;
        let words = layout.size.width.div_ceil(64);
        let mut analog: Vec<&mut [C]> = state.analog.iter_mut().map(|plane| &mut **plane).collect();
        analog.push(&mut copies.analog);
        analog.push(&mut state.pix);
        let mut digital: Vec<_> = state.digital.iter_mut().map(BitPlane::words_mut).collect();
        digital.push(&mut copies.bits);
        digital.push(state.flag.words_mut());
        Self {
            layout,
            rows: 0..layout.size.height,
            analog,
            digital,
            select: state.select.words(),
            rect: state.rect.words(),
            cells: vec![state.edge.clone(); ROOM],
            bits: vec![0; words],
            constants,
        }
    }

    /// The rows above `row`, and those from there on.
    pub(super) fn split(self, row: usize) -> (Self, Self) {
        let width = self.layout.size.width;
        let words = self.words();
        let above = row - self.rows.start;
        let (analog, analog_below) = split_all(self.analog, above * width);
        let (digital, digital_below) = split_all(self.digital, above * words);
        let (select, select_below) = self.select.split_at(above * words);
        let (rect, rect_below) = self.rect.split_at(above * words);
        let top = Slab {
            layout: self.layout,
            rows: self.rows.start..row,
            analog,
            digital,
            select,
            rect,
            constants: self.constants,
            cells: self.cells.clone(),
            bits: self.bits.clone(),
        };
        let below = Slab {
            layout: self.layout,
            rows: row..self.rows.end,
            analog: analog_below,
            digital: digital_below,
            select: select_below,
            rect: rect_below,
            constants: self.constants,
            cells: self.cells,
            bits: self.bits,
        };
        (top, below)
    }
}

/// Cuts every plane; one that was never made stays empty.
fn split_all<T>(planes: Vec<&mut [T]>, at: usize) -> (Vec<&mut [T]>, Vec<&mut [T]>) {
    let cut = |plane: &mut [T]| at.min(plane.len());
    planes
        .into_iter()
        .map(|plane| {
            let at = cut(plane);
            plane.split_at_mut(at)
        })
        .unzip()
}

impl<'a, C> Slab<'a, C> {
    /// Words of bits in a row.
    pub(super) fn words(&self) -> usize {
        self.layout.size.width.div_ceil(64)
    }

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
    #[inline(always)]
    pub(super) fn view(&mut self) -> (View<'_, 'a, C>, &mut [C]) {
        let view = View {
            size: self.layout.size,
            top: self.rows.start,
            planes: &mut self.analog,
            flag: self.digital[planes::flag(&self.layout)],
            constants: self.constants,
        };
        (view, &mut self.cells)
    }

    pub(super) fn flag(&self) -> &[u64] {
        self.digital[planes::flag(&self.layout)]
    }

    pub(super) fn take_flag(&mut self) -> &'a mut [u64] {
        std::mem::take(&mut self.digital[planes::flag(&self.layout)])
    }

    pub(super) fn put_flag(&mut self, flag: &'a mut [u64]) {
        self.digital[planes::flag(&self.layout)] = flag;
    }

    pub(super) fn take_bits(&mut self, register: Digital) -> &'a mut [u64] {
        std::mem::take(&mut self.digital[usize::from(register.0)])
    }

    pub(super) fn put_bits(&mut self, register: Digital, bits: &'a mut [u64]) {
        self.digital[usize::from(register.0)] = bits;
    }

    pub(super) fn digital(&self, register: Digital) -> &[u64] {
        self.digital[usize::from(register.0)]
    }

    /// A one-bit operand, or the copy of it.
    pub(super) fn bits(&self, bit: Bit, copied: bool) -> &[u64] {
        match bit {
            _ if copied => self.digital[usize::from(self.layout.digital)],
            Bit::Register(register) => self.digital(register),
            Bit::Flag => self.flag(),
            Bit::Select => self.select,
            Bit::Rect => self.rect,
        }
    }

    /// Where rows of bits lie in a plane of this slab.
    pub(super) fn row_words(&self, rows: Range<usize>) -> Range<usize> {
        let (top, words) = (self.rows.start, self.words());
        (rows.start - top) * words..(rows.end - top) * words
    }

    /// Where rows of cells lie in a plane of this slab.
    pub(super) fn row_cells(&self, rows: Range<usize>) -> Range<usize> {
        let (top, width) = (self.rows.start, self.layout.size.width);
        (rows.start - top) * width..(rows.end - top) * width
    }
}

impl<C> Slab<'_, C> {
    /// One-bit logic on some rows.
    #[inline(always)]
    pub(super) fn logic(&mut self, logic: &Logic, rows: Range<usize>) {
        let words = self.row_words(rows);
        let target = std::mem::take(&mut self.digital[logic.target]);
        let bits = &mut target[words.clone()];
        let Logic { kept, not, .. } = *logic;
        match logic.count {
            0 => bits::or(bits, [], kept, not),
            1 => bits::or(bits, self.others::<1>(logic, &words), kept, not),
            2 => bits::or(bits, self.others::<2>(logic, &words), kept, not),
            3 => bits::or(bits, self.others::<3>(logic, &words), kept, not),
            _ => bits::or(bits, self.others::<4>(logic, &words), kept, not),
        }
        if logic.not {
            bits::cut(bits, self.layout.size.width);
        }
        self.digital[logic.target] = target;
    }

    /// The first `N` other sources.
    #[inline(always)]
    fn others<const N: usize>(&self, logic: &Logic, words: &Range<usize>) -> [&[u64]; N] {
        let mut others: [&[u64]; N] = [&[]; N];
        for (other, plane) in others.iter_mut().zip(logic.others) {
            *other = &self.digital[plane][words.clone()];
        }
        others
    }
}

impl<C: Clone> Slab<'_, C> {
    /// Copies rows of a register.
    pub(super) fn copy(&mut self, register: Analog, rows: Range<usize>) {
        let cells = self.row_cells(rows);
        let copy = planes::copy(&self.layout);
        let (registers, copies) = self.analog.split_at_mut(copy);
        copies[0][cells.clone()].clone_from_slice(&registers[usize::from(register.0)][cells]);
    }

    /// Copies rows of a one-bit register.
    pub(super) fn copy_bits(&mut self, register: Digital, rows: Range<usize>) {
        let words = self.row_words(rows);
        let copy = usize::from(self.layout.digital);
        let (registers, copies) = self.digital.split_at_mut(copy);
        copies[0][words.clone()].copy_from_slice(&registers[usize::from(register.0)][words]);
    }
}
