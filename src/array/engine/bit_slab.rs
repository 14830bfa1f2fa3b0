//! Rows of every plane of bits: what one thread may read and write, whatever the cells hold.

use std::ops::Range;

use super::{
    super::{BitPlane, Layout},
    planes,
};
use crate::isa::{Bit, Digital};

/// Rows of every plane of bits.
pub(super) struct BitSlab<'a> {
    /// Of the whole array.
    pub(super) layout: Layout,
    /// Which rows these are.
    pub(super) rows: Range<usize>,
    /// Registers; then the copy, where there is one; then FLAG: see [`planes`].
    pub(super) planes: Vec<&'a mut [u64]>,
    select: &'a [u64],
    rect: &'a [u64],
    /// Room for a row.
    pub(super) room: Vec<u64>,
}

impl<'a> BitSlab<'a> {
    /// All rows.
    pub(super) fn whole(
        layout: Layout,
        digital: &'a mut [BitPlane],
        copy: &'a mut [u64],
        flag: &'a mut BitPlane,
        [select, rect]: [&'a BitPlane; 2],
    ) -> Self {
        let mut planes: Vec<_> = digital.iter_mut().map(BitPlane::words_mut).collect();
        planes.push(copy);
        planes.push(flag.words_mut());
        Self {
            layout,
            rows: 0..layout.size.height,
            planes,
            select: select.words(),
            rect: rect.words(),
            room: vec![0; layout.size.width.div_ceil(64)],
        }
    }

    /// The rows above `row`, and those from there on.
    pub(super) fn split(self, row: usize) -> (Self, Self) {
        let at = (row - self.rows.start) * self.words();
        let (above, below) = split_all(self.planes, at);
        let (select_above, select_below) = self.select.split_at(at);
        let (rect_above, rect_below) = self.rect.split_at(at);
        let top = BitSlab {
            layout: self.layout,
            rows: self.rows.start..row,
            planes: above,
            select: select_above,
            rect: rect_above,
            room: self.room.clone(),
        };
        let bottom = BitSlab {
            layout: self.layout,
            rows: row..self.rows.end,
            planes: below,
            select: select_below,
            rect: rect_below,
            room: self.room,
        };
        (top, bottom)
    }

    /// Words in a row.
    pub(super) fn words(&self) -> usize {
        self.layout.size.width.div_ceil(64)
    }

    /// Where rows lie in a plane of this slab.
    pub(super) fn row_words(&self, rows: Range<usize>) -> Range<usize> {
        let (top, words) = (self.rows.start, self.words());
        (rows.start - top) * words..(rows.end - top) * words
    }

    pub(super) fn flag(&self) -> &[u64] {
        self.planes[planes::flag(&self.layout)]
    }

    pub(super) fn digital(&self, register: Digital) -> &[u64] {
        self.planes[usize::from(register.0)]
    }

    /// A one-bit operand, or the copy of it.
    pub(super) fn bits(&self, bit: Bit, copied: bool) -> &[u64] {
        match bit {
            _ if copied => self.planes[planes::bit_copy(&self.layout)],
            Bit::Register(register) => self.digital(register),
            Bit::Flag => self.flag(),
            Bit::Select => self.select,
            Bit::Rect => self.rect,
        }
    }

    /// Takes a plane out, to be put back.
    pub(super) fn take(&mut self, plane: usize) -> &'a mut [u64] {
        std::mem::take(&mut self.planes[plane])
    }

    /// Puts a plane back.
    pub(super) fn put(&mut self, plane: usize, bits: &'a mut [u64]) {
        self.planes[plane] = bits;
    }

    /// Copies rows of a register.
    pub(super) fn copy(&mut self, register: Digital, rows: Range<usize>) {
        let words = self.row_words(rows);
        let (registers, copies) = self.planes.split_at_mut(planes::bit_copy(&self.layout));
        copies[0][words.clone()].copy_from_slice(&registers[usize::from(register.0)][words]);
    }
}

/// Cuts every plane; one that was never made stays empty.
pub(super) fn split_all<T>(planes: Vec<&mut [T]>, at: usize) -> (Vec<&mut [T]>, Vec<&mut [T]>) {
    let halves = planes.into_iter().map(|plane| {
        let at = at.min(plane.len());
        plane.split_at_mut(at)
    });
    halves.unzip()
}
