//! Buffers aligned to cache lines, and staggered so that they do not evict each other.

use std::{
    fmt,
    ops::{Deref, DerefMut},
};

use ndarray::{Array1, s};

use crate::plane::{Plane, Size};

/// Bytes from the start of one plane to the start of the next, on top of whole pages.
///
/// Planes that lie whole pages apart take each other's place in the cache next to a core, and
/// a store to one holds up loads from another: eight that are so far apart share it evenly.
const STAGGER: usize = PAGE / 8 + 64;

/// Bytes of a page.
const PAGE: usize = 4096;

/// Bytes of a cache line, at which planes begin: a vector that lies across two lines costs twice.
pub(crate) const LINE: usize = 64;

/// A buffer of a fixed length, aligned to a cache line.
pub(crate) struct Aligned<T> {
    /// The values, with padding before and after.
    all: Vec<T>,
    /// The number of the plane, which gives its stagger.
    k: usize,
    /// Padding before the first value.
    lead: usize,
    len: usize,
}

impl<T: Clone> Aligned<T> {
    /// The plane number `k`, filled with `value`.
    pub(crate) fn new(k: usize, value: T, cells: usize) -> Self {
        let size = size_of::<T>().max(1);
        // What is smaller than a page lies beside its neighbours anyway.
        let stagger = if cells * size < PAGE {
            0
        } else {
            k * STAGGER % PAGE / size
        };
        let slack = LINE / size;
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

    /// The plane number `k`, a copy of `values`.
    pub(crate) fn from_slice(k: usize, values: &[T]) -> Self {
        let Some(first) = values.first() else {
            return Self::default();
        };
        let mut copy = Self::new(k, first.clone(), values.len());
        copy.clone_from_slice(values);
        copy
    }
}

/// Zeros, the plane number `k`.
pub(crate) fn zeros(k: usize, size: Size) -> Plane<f64> {
    let Aligned { all, lead, len, .. } = Aligned::new(k, 0.0, size.pixels());
    let values = Array1::from_vec(all).slice_move(s![lead..lead + len]);
    let plane = values.into_shape_with_order(size.shape());
    plane.expect("as many values as pixels, one after the other")
}

impl<T: Clone> Clone for Aligned<T> {
    fn clone(&self) -> Self {
        Self::from_slice(self.k, self)
    }
}

/// An empty buffer.
impl<T> Default for Aligned<T> {
    fn default() -> Self {
        Self {
            all: Vec::new(),
            k: 0,
            lead: 0,
            len: 0,
        }
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.all[self.lead..][..self.len]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.all[self.lead..][..self.len]
    }
}

impl<T: PartialEq> PartialEq for Aligned<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Eq> Eq for Aligned<T> {}

impl<T: fmt::Debug> fmt::Debug for Aligned<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_begin_where_a_line_does() {
        for k in 0..9 {
            let first = Aligned::new(k, 1.5f32, 77);
            let copy = first.clone();
            let plane = zeros(k, Size::new(3, 5));
            assert_eq!((&first[..], copy == first), (&[1.5; 77][..], true));
            assert_eq!((plane.dim(), plane.sum()), ((3, 5), 0.0));
            for at in [
                first.as_ptr().addr(),
                copy.as_ptr().addr(),
                plane.as_ptr().addr(),
            ] {
                assert_eq!(at % LINE, 0);
            }
        }
        assert!(Aligned::<u64>::from_slice(1, &[]).is_empty());
    }
}
