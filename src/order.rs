//! Stable sorting, compiled once for all types.
//!
//! A sort of the standard library is some ten kilobytes for each type and each comparison. Here
//! places are sorted, by one that calls the comparison, and the items then follow. Where long lists
//! are sorted in a run, as events are, the standard library's own is faster.

use std::cmp::Ordering;

/// Slices that are put in order; equal items stay as they are.
pub(crate) trait Order<T> {
    /// By a comparison.
    fn order_by(&mut self, compare: impl FnMut(&T, &T) -> Ordering);

    /// By a key, made at each comparison.
    fn order_by_key<K: Ord>(&mut self, key: impl FnMut(&T) -> K);
}

impl<T> Order<T> for [T] {
    fn order_by(&mut self, mut compare: impl FnMut(&T, &T) -> Ordering) {
        let mut places = sorted(self.len(), &mut |a, b| compare(&self[a], &self[b]));
        for at in 0..self.len() {
            // What belongs here may have been swapped away, to where another was before it.
            let mut from = places[at];
            while from < at {
                from = places[from];
            }
            places[at] = from;
            self.swap(at, from);
        }
    }

    fn order_by_key<K: Ord>(&mut self, mut key: impl FnMut(&T) -> K) {
        self.order_by(|a, b| key(a).cmp(&key(b)));
    }
}

/// The places from 0 on, in order.
#[inline(never)]
fn sorted(n: usize, compare: &mut dyn FnMut(usize, usize) -> Ordering) -> Vec<usize> {
    let mut places: Vec<usize> = (0..n).collect();
    places.sort_by(|a, b| compare(*a, *b));
    places
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn items_are_as_a_stable_sort_leaves_them(
            values in prop::collection::vec(0..40u8, 0..200)
        ) {
            let mut own: Vec<_> = values.into_iter().enumerate().collect();
            let mut known = own.clone();
            own.order_by_key(|item| item.1);
            known.sort_by_key(|item| item.1);
            prop_assert_eq!(&own, &known);
            own.order_by(|a, b| b.1.cmp(&a.1));
            known.sort_by_key(|item| std::cmp::Reverse(item.1));
            prop_assert_eq!(own, known);
        }
    }
}
