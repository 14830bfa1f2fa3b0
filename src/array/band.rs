//! Rows of every plane of the array: what one thread may read and write.

use std::ops::Range;

use super::{
    Layout, State,
    rows::{Bus, Operand},
};
use crate::isa::{Analog, Bit, Digital, Source};

/// What every part of the array needs besides its own rows.
#[derive(Clone, Debug)]
pub(super) struct Constants<C> {
    /// A row of what lies off the array.
    pub(super) edge: Vec<C>,
    /// Rows of what the global input held, one after the other.
    pub(super) inputs: Vec<Vec<C>>,
}

impl<C: Clone> Constants<C> {
    pub(super) fn of(state: &State<C>) -> Self {
        let width = state.layout.size.width;
        Self {
            edge: vec![state.edge.clone(); width],
            inputs: vec![vec![state.input.clone(); width]],
        }
    }
}

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

/// The sources of a bus; the usual numbers of them without room of their own.
pub(super) enum Operands<'a, C> {
    Few([Operand<'a, C>; FEW], usize),
    Many(Vec<Operand<'a, C>>),
}

/// As many as SCAMP-5's words have.
const FEW: usize = 4;

impl<'a, C> std::ops::Deref for Operands<'a, C> {
    type Target = [Operand<'a, C>];

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Few(operands, n) => &operands[..*n],
            Self::Many(operands) => operands,
        }
    }
}

/// Rows of every plane.
pub(super) struct Band<'a, C> {
    /// Of the whole array.
    pub(super) layout: Layout,
    /// Which rows these are.
    pub(super) rows: Range<usize>,
    /// Registers; then, where there is one, the copy.
    analog: Vec<&'a mut [C]>,
    pub(super) pix: &'a mut [C],
    /// Registers; then, where there is one, the copy.
    digital: Vec<&'a mut [u64]>,
    flag: &'a mut [u64],
    select: &'a [u64],
    rect: &'a [u64],
    constants: &'a Constants<C>,
    /// Room for 64 cells.
    pub(super) cells: Vec<C>,
    /// Room for a row of bits.
    pub(super) bits: Vec<u64>,
}

impl<'a, C: Clone> Band<'a, C> {
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
        let mut digital: Vec<_> = state
            .digital
            .iter_mut()
            .map(super::BitPlane::words_mut)
            .collect();
        digital.push(&mut copies.bits);
        Self {
            layout,
            rows: 0..layout.size.height,
            analog,
            pix: &mut state.pix,
            digital,
            flag: state.flag.words_mut(),
            select: state.select.words(),
            rect: state.rect.words(),
            cells: vec![state.edge.clone(); 64],
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
        let (pix, pix_below) = self.pix.split_at_mut(above * width);
        let (flag, flag_below) = self.flag.split_at_mut(above * words);
        let (select, select_below) = self.select.split_at(above * words);
        let (rect, rect_below) = self.rect.split_at(above * words);
        let top = Band {
            layout: self.layout,
            rows: self.rows.start..row,
            analog,
            pix,
            digital,
            flag,
            select,
            rect,
            constants: self.constants,
            cells: self.cells.clone(),
            bits: self.bits.clone(),
        };
        let below = Band {
            layout: self.layout,
            rows: row..self.rows.end,
            analog: analog_below,
            pix: pix_below,
            digital: digital_below,
            flag: flag_below,
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

impl<'a, C> Band<'a, C> {
    /// Words of bits in a row.
    pub(super) fn words(&self) -> usize {
        self.layout.size.width.div_ceil(64)
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
            self.analog[self.analog.len() - 1]
        } else {
            self.analog[usize::from(register.0)]
        }
    }

    /// All analogue registers.
    pub(super) fn registers(&mut self) -> &mut [&'a mut [C]] {
        &mut self.analog
    }

    pub(super) fn flag(&self) -> &[u64] {
        self.flag
    }

    pub(super) fn take_flag(&mut self) -> &'a mut [u64] {
        std::mem::take(&mut self.flag)
    }

    pub(super) fn put_flag(&mut self, flag: &'a mut [u64]) {
        self.flag = flag;
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
            _ if copied => self.digital[self.digital.len() - 1],
            Bit::Register(register) => self.digital(register),
            Bit::Flag => self.flag,
            Bit::Select => self.select,
            Bit::Rect => self.rect,
        }
    }

    /// Where rows of bits lie in a plane of this band.
    pub(super) fn row_words(&self, rows: Range<usize>) -> Range<usize> {
        let (top, words) = (self.rows.start, self.words());
        (rows.start - top) * words..(rows.end - top) * words
    }

    /// Where rows of cells lie in a plane of this band.
    pub(super) fn row_cells(&self, rows: Range<usize>) -> Range<usize> {
        let (top, width) = (self.rows.start, self.layout.size.width);
        (rows.start - top) * width..(rows.end - top) * width
    }

    /// What one source puts on the bus; `copied`: NEWS as it was before the word.
    fn operand(&self, source: Source, input: usize, copied: bool) -> Operand<'_, C> {
        let width = self.layout.size.width;
        let news = self.layout.news;
        let (cells, stride, beside) = match source {
            Source::Register(register) => (
                self.analog(register, copied && register == news),
                width,
                (0, 0),
            ),
            Source::Pix => (&*self.pix, width, (0, 0)),
            Source::In => (&self.constants.inputs[input][..], 0, (0, 0)),
            Source::Neighbour(direction) => (self.analog(news, copied), width, direction.step()),
        };
        Operand {
            cells,
            top: self.rows.start,
            stride,
            beside,
        }
    }

    /// What the sources put on the bus.
    pub(super) fn operands(
        &self,
        sources: &[Source],
        input: usize,
        copied: bool,
    ) -> Operands<'_, C> {
        let operand = |source: &Source| self.operand(*source, input, copied);
        if sources.len() > FEW {
            return Operands::Many(sources.iter().map(operand).collect());
        }
        let nothing = Operand {
            cells: &[],
            top: 0,
            stride: 0,
            beside: (0, 0),
        };
        let mut operands = [nothing; FEW];
        for (to, source) in operands.iter_mut().zip(sources) {
            *to = operand(source);
        }
        Operands::Few(operands, sources.len())
    }

    /// The bus of every pixel.
    pub(super) fn bus<'b>(&'b self, operands: &'b [Operand<'b, C>]) -> Bus<'b, C> {
        Bus {
            size: self.layout.size,
            operands,
            outside: &self.constants.edge,
        }
    }
}

impl<C: Clone> Band<'_, C> {
    /// Copies rows of a register.
    pub(super) fn copy(&mut self, register: Analog, rows: Range<usize>) {
        let cells = self.row_cells(rows);
        let copy = self.analog.len() - 1;
        let (registers, copies) = self.analog.split_at_mut(copy);
        copies[0][cells.clone()].clone_from_slice(&registers[usize::from(register.0)][cells]);
    }

    /// Copies rows of a one-bit register.
    pub(super) fn copy_bits(&mut self, register: Digital, rows: Range<usize>) {
        let words = self.row_words(rows);
        let copy = self.digital.len() - 1;
        let (registers, copies) = self.digital.split_at_mut(copy);
        copies[0][words.clone()].copy_from_slice(&registers[usize::from(register.0)][words]);
    }
}
