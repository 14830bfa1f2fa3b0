//! Cells under a mask.

use std::hint::black_box;

use multiversion::multiversion;

use super::super::{RowOps, each::lanes};

/// Cells that are worked on at once, at most.
pub(super) const PIECE: usize = 2048;

/// Words of bits that are looked at together.
const WORDS: usize = 8;

/// Cells that are stored under a mask together.
pub(super) const RUN: usize = 64 * WORDS;

/// Cells that a store needs room for: a run, or a piece of a column and of those on its bus inputs.
pub(super) const ROOM: usize = RUN;

/// Cells under a mask, run by run.
pub(super) struct Runs<'a> {
    /// None where all are 1.
    flags: &'a [u64],
    /// The bit of the first cell, under 64.
    offset: usize,
    cells: usize,
    next: usize,
    /// The bits of the last run.
    words: [u64; WORDS],
}

/// Some cells beside each other.
pub(super) struct Run {
    pub(super) from: usize,
    pub(super) to: usize,
    /// Whether it is all of them; else those of [`Runs::words`], at most [`RUN`].
    pub(super) all: bool,
}

impl<'a> Runs<'a> {
    #[inline]
    pub(super) fn new(flags: &'a [u64], offset: usize, cells: usize) -> Self {
        Self {
            flags,
            offset,
            cells,
            next: 0,
            words: [0; WORDS],
        }
    }

    /// All of them.
    #[inline]
    pub(super) fn all(cells: usize) -> Self {
        Self::new(&[], 0, cells)
    }

    /// The bits of the last run's cells.
    #[inline]
    pub(super) const fn words(&self) -> &[u64; WORDS] {
        &self.words
    }

    /// The bits of 64 cells.
    fn word(&self, i: usize) -> u64 {
        let bit = self.offset + i;
        let low = self.flags[bit / 64] >> (bit % 64);
        if bit.is_multiple_of(64) {
            low
        } else {
            low | self.flags.get(bit / 64 + 1).unwrap_or(&0) << (64 - bit % 64)
        }
    }

    /// Takes the bits of some cells; whether any of them is 1, and whether all are.
    #[inline]
    fn take(&mut self, from: usize, to: usize) -> (bool, bool) {
        let at = (self.offset + from) / 64;
        match self.flags[at..].as_chunks::<WORDS>().0.first() {
            Some(words) if self.offset == 0 && to - from == RUN => {
                let (mut any, mut all) = (0, !0);
                for (own, word) in self.words.iter_mut().zip(words) {
                    any |= *word;
                    all &= *word;
                    *own = *word;
                }
                (any != 0, all == !0)
            }
            _ => self.take_across(from, to),
        }
    }

    /// The same where they do not begin where a word does, or end inside one.
    #[inline(never)]
    fn take_across(&mut self, from: usize, to: usize) -> (bool, bool) {
        let (mut any, mut all) = (0, !0);
        for (k, i) in (from..to).step_by(64).enumerate() {
            let word = self.word(i);
            // What lies beyond the end is none of the cells.
            let beyond = if to - i < 64 { !0 << (to - i) } else { 0 };
            any |= word & !beyond;
            all &= word | beyond;
            self.words[k] = word;
        }
        (any != 0, all == !0)
    }

    /// The next cells of which at least one is to be stored.
    #[inline]
    pub(super) fn next(&mut self) -> Option<Run> {
        while self.next < self.cells {
            let from = self.next;
            if self.flags.is_empty() {
                self.next = (from + PIECE).min(self.cells);
                return Some(Run {
                    from,
                    to: self.next,
                    all: true,
                });
            }
            let to = (from + RUN).min(self.cells);
            self.next = to;
            let (any, all) = self.take(from, to);
            if any {
                return Some(Run { from, to, all });
            }
        }
        None
    }
}

/// Takes `new` where the bit is 1.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn merge<D: RowOps>(
    domain: &D,
    cells: &mut [D::Cell],
    new: &mut [D::Cell],
    words: &[u64; WORDS],
) {
    let bits = lanes();
    let whole = cells.len() / 64 * 64;
    let (cells, last_cells) = cells.split_at_mut(whole);
    let (new, last_new) = new.split_at_mut(whole);
    let blocks = cells.as_chunks_mut::<64>().0.iter_mut();
    let blocks = blocks.zip(new.as_chunks_mut::<64>().0).zip(words);
    for ((cells, new), word) in blocks {
        let lanes = cells.as_chunks_mut::<16>().0.iter_mut();
        let lanes = lanes.zip(new.as_chunks_mut::<16>().0);
        for (k, (cells, new)) in lanes.enumerate() {
            let flags = (word >> (16 * k)) as u16;
            // By value: nothing that is read can be what was just written.
            let (old, fresh) = (cells.clone(), new.clone());
            let mut merged = fresh.clone();
            for (i, cell) in merged.iter_mut().enumerate() {
                *cell = domain.choose(&old[i], &fresh[i], u8::from(flags & bits[i] != 0));
            }
            if size_of::<D::Cell>() < 4 {
                *cells = merged;
            } else {
                // By way of memory, or wide lanes are stored under a mask, which is slow.
                cells.clone_from(black_box(&merged));
            }
        }
    }
    let word = words.get(whole / 64).unwrap_or(&0);
    for (i, (cell, new)) in last_cells.iter_mut().zip(last_new).enumerate() {
        if word >> i & 1 == 1 {
            cell.clone_from(new);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::array::Exact;

    #[test]
    fn only_flagged_cells_change() {
        let mut flags = vec![0x9E37_79B9_7F4A_7C15, !0, !0, 0, 0xF0F0_F0F0_F0F0_F0F0];
        flags.extend([!0; 7]);
        for n in [1usize, 15, 16, 17, 40, 64, 65, 130, 200, 300, 700] {
            for offset in [0, 1] {
                let mut cells = vec![0.0; n];
                let mut runs = Runs::new(&flags, offset, n);
                while let Some(Run { from, to, all }) = runs.next() {
                    let mut new: Vec<_> = (from + 1..=to).map(|i| i as f64).collect();
                    let cells = &mut cells[from..to];
                    if all {
                        cells.clone_from_slice(&new);
                    } else {
                        merge(&Exact, cells, &mut new, runs.words());
                    }
                }
                for (i, cell) in cells.iter().enumerate() {
                    let bit = i + offset;
                    let on = flags[bit / 64] >> (bit % 64) & 1 == 1;
                    assert_eq!(*cell, if on { (i + 1) as f64 } else { 0.0 });
                }
            }
        }
    }
}
