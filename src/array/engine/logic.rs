//! One-bit words, row by row, 64 pixels at a time.

use std::ops::Range;

use super::{
    super::bits,
    bit_slab::BitSlab,
    operation::{Logic, MaskedLogic, Neighbours},
};
use crate::{
    isa::{Bit, Direction},
    plane::Size,
};

impl BitSlab<'_> {
    /// `target := [not] any source`, where the engine knows all of it beforehand.
    pub(super) fn logic(&mut self, logic: &Logic, rows: Range<usize>) {
        let words = self.row_words(rows);
        let target = self.take(logic.target);
        let mut others: [&[u64]; 4] = [&[]; 4];
        for (other, plane) in others.iter_mut().zip(logic.others()) {
            *other = &self.planes[*plane][words.clone()];
        }
        let others = &others[..logic.others().len()];
        let bits = &mut target[words];
        bits::or_any(bits, others, logic.kept, logic.not);
        if logic.not {
            bits::cut(bits, self.layout.size.width);
        }
        self.put(logic.target, target);
    }

    /// `target := [not] any source`, of any sources, into any target.
    pub(super) fn masked_logic(&mut self, logic: &MaskedLogic, rows: Range<usize>) {
        let words = self.row_words(rows.clone());
        let target = self.take(logic.target);
        if let Some(mask) = logic.mask {
            // A row at a time, by way of a row of its own.
            let mut new = std::mem::take(&mut self.room);
            for y in rows {
                let words = self.row_words(y..y + 1);
                let old = &mut target[words.clone()];
                new.copy_from_slice(old);
                self.any(logic, &mut new, words.clone());
                bits::assign_where(old, &new, &self.digital(mask)[words]);
            }
            self.room = new;
        } else {
            self.any(logic, &mut target[words.clone()], words);
        }
        self.put(logic.target, target);
    }

    /// `words := [not] (any other source, or, where kept, themselves)`.
    fn any(&self, logic: &MaskedLogic, words: &mut [u64], rows: Range<usize>) {
        let MaskedLogic { kept, not, .. } = *logic;
        bits::or_any(words, &[], kept, not);
        for bit in &logic.others {
            let other = &self.bits(*bit, false)[rows.clone()];
            // Not of all is not of each and of each.
            if not {
                bits::clear_where(words, other);
            } else {
                bits::or_any(words, &[other], true, false);
            }
        }
        if not {
            bits::cut(words, self.layout.size.width);
        }
    }

    /// `target := OR over the directions that are enabled in the reading pixel`.
    pub(super) fn neighbours(&mut self, word: Neighbours, rows: Range<usize>) {
        let Neighbours {
            target,
            source,
            boundary,
        } = word;
        let Size { height, width } = self.layout.size;
        let roles = self.layout.roles;
        let copied = source == Bit::Register(target);
        let mut new = std::mem::take(&mut self.room);
        for y in rows {
            let words = self.row_words(y..y + 1);
            let source = self.bits(source, copied);
            new.fill(0);
            for direction in Direction::ALL {
                let to = y.wrapping_add_signed(direction.step().0);
                let there = (to < height).then(|| &source[self.row_words(to..to + 1)]);
                let enabled = &self.digital(roles.enables(direction))[words.clone()];
                bits::or_seen(&mut new, there, direction, width, boundary, enabled);
            }
            let plane = usize::from(target.0);
            let bits = self.take(plane);
            let old = &mut bits[words.clone()];
            if target == roles.propagated {
                bits::assign_where(old, &new, &self.digital(roles.mask)[words]);
            } else {
                old.copy_from_slice(&new);
            }
            self.put(plane, bits);
        }
        self.room = new;
    }
}
