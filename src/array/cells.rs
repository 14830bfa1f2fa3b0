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

/// So many values, at a place of their own.
#[derive(Clone)]
pub(super) struct Cells<T> {
    all: Vec<T>,
    lead: usize,
}

impl<T: Clone> Cells<T> {
    /// The plane number `k`, all alike.
    pub(super) fn new(k: usize, value: T, cells: usize) -> Self {
        let lead = k * STAGGER % 4096 / size_of::<T>().max(1);
        Self {
            all: vec![value; lead + cells],
            lead,
        }
    }
}

impl<T> Deref for Cells<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.all[self.lead..]
    }
}

impl<T> DerefMut for Cells<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.all[self.lead..]
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
