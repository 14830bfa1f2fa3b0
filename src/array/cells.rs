//! The cells of one register, apart from those of the others in the cache.

use std::{
    fmt,
    ops::{Deref, DerefMut},
};

/// Bytes from the start of one plane to the start of the next, on top of whole pages.
///
/// Planes that lie whole pages apart take each other's place in the cache next to a core, and
/// a store to one holds up loads from another: eight that are so far apart share it evenly.
const STAGGER: usize = 4096 / 8 + 64;

/// Planes begin where a line of the cache does: a vector that lies across two costs twice.
const LINE: usize = 64;

/// So many values, at a place of their own.
pub(super) struct Cells<T> {
    all: Vec<T>,
    k: usize,
    lead: usize,
    len: usize,
}

impl<T: Clone> Cells<T> {
    /// The plane number `k`, all alike.
    pub(super) fn new(k: usize, value: T, cells: usize) -> Self {
        let size = size_of::<T>().max(1);
        let (stagger, slack) = (k * STAGGER % 4096 / size, LINE / size);
        let all = vec![value; stagger + slack + cells];
        let to_line = all.as_ptr().align_offset(LINE);
        let lead = stagger + if to_line <= slack { to_line } else { 0 };
        Self {
            all,
            k,
            lead,
            len: cells,
        }
    }
}

impl<T: Clone> Clone for Cells<T> {
    fn clone(&self) -> Self {
        match self.first() {
            None => Self::default(),
            Some(first) => {
                let mut copy = Self::new(self.k, first.clone(), self.len);
                copy.clone_from_slice(self);
                copy
            }
        }
    }
}

/// None.
impl<T> Default for Cells<T> {
    fn default() -> Self {
        Self {
            all: Vec::new(),
            k: 0,
            lead: 0,
            len: 0,
        }
    }
}

impl<T> Deref for Cells<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.all[self.lead..][..self.len]
    }
}

impl<T> DerefMut for Cells<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.all[self.lead..][..self.len]
    }
}

impl<T: PartialEq> PartialEq for Cells<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Eq> Eq for Cells<T> {}

impl<T: fmt::Debug> fmt::Debug for Cells<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}
