//! Fixed point in the cells.

// What is not inlined into a sweep is not compiled for wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use super::{
    Domain, Place, Share,
    domain::LIMITS,
    each::{each, some, summed},
};
use crate::number::{Number, Overflow, Q, Wide, Width};

/// Fixed point in the cells, an integer on the bus that holds every sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed<T> {
    number: Q<T>,
    limits: (T, T),
}

impl<T: Width> Fixed<T> {
    /// In this format.
    #[must_use]
    pub fn new(number: Q<T>) -> Self {
        // Where the format is narrower than the ADC scale, its own ends limit it already.
        let end = |limit: f64| T::saturate((limit * number.one() as f64) as i64);
        Self {
            number,
            limits: (end(LIMITS.0), end(LIMITS.1)),
        }
    }

    #[inline]
    fn saturates(&self) -> bool {
        self.number.overflow() == Overflow::Saturate
    }
}

impl<T: Width> Domain for Fixed<T> {
    type Cell = T;
    type Sum = T::Wide;

    fn name(&self) -> String {
        self.number.format().to_string()
    }
    #[inline]
    fn hold(&self, value: f64) -> T {
        self.number.hold(value)
    }
    fn value(&self, cell: &T) -> f64 {
        self.number.value(*cell)
    }
    #[inline]
    fn nothing(&self) -> T::Wide {
        T::Wide::default()
    }
    #[inline]
    fn add(&self, sum: &mut T::Wide, cell: &T, times: i32) {
        *sum = sum.plus(cell.widen().times(times));
    }
    #[inline]
    fn join(&self, sum: &mut T::Wide, other: &T::Wide) {
        *sum = sum.plus(*other);
    }
    #[inline]
    fn store(&self, sum: &T::Wide, share: Share, _: Place) -> T {
        self.number.narrow(sum.times(-1).divided(share.by))
    }
    #[inline(always)]
    fn store_row(&self, operands: &[&[T]], share: Share, _: Place, cells: &mut [T]) {
        // Without a choice inside the loops.
        match (operands, share.by) {
            ([], _) => cells.fill(T::ZERO),
            (&[a], 1) if self.saturates() => each([a], cells, saturated_sum),
            (&[a], 2) if self.saturates() => each([a], cells, saturated_half),
            (&[a, b], 1) if self.saturates() => each([a, b], cells, saturated_sum),
            (&[a, b], 2) if self.saturates() => each([a, b], cells, saturated_half),
            _ => wide_row(operands, share.by, self.saturates(), cells),
        }
    }
    #[inline(always)]
    fn store_some(&self, operands: &[&[T]], words: &[u64], cells: &mut [T]) -> bool {
        match *operands {
            [a] if self.saturates() => some([a], words, cells, saturated_sum),
            [a, b] if self.saturates() => some([a, b], words, cells, saturated_sum),
            _ => return false,
        }
        true
    }
    fn pairs(&self) -> bool {
        self.saturates()
    }
    /// What the first would store, taken from nought, is the sum, but for the lowest number, or
    /// half the sum.
    #[inline(always)]
    fn store_pair(&self, operands: &[&[T]], by: u32, extra: Option<&[T]>, cells: &mut [T]) {
        let lowest = T::ZERO.less(T::LIMITS.1);
        match (operands, by, extra) {
            (&[a], 1, None) => each([a], cells, |[a]| a.max(lowest)),
            (&[a], 1, Some(c)) => each([a, c], cells, |[a, c]| a.max(lowest).less(c)),
            (&[a], _, None) => each([a], cells, |[a]| a.middle(T::ZERO)),
            (&[a], _, Some(c)) => each([a, c], cells, |[a, c]| a.middle(T::ZERO).less(c)),
            (&[a, b], 1, None) => each([a, b], cells, |[a, b]| a.more(b).max(lowest)),
            (&[a, b], 1, Some(c)) => each([a, b, c], cells, |[a, b, c]| {
                saturated_sum([saturated_sum([a, b]), c])
            }),
            (&[a, b], _, None) => each([a, b], cells, |[a, b]| a.middle(b).max(lowest)),
            (&[a, b], _, Some(c)) => each([a, b, c], cells, |[a, b, c]| {
                a.middle(b).max(lowest).less(c)
            }),
            _ => {}
        }
    }
    #[inline(always)]
    fn choose(&self, old: &T, new: &T, take: u8) -> T {
        T::choose(*old, *new, take)
    }
    fn square(&self, sum: &T::Wide, gain: f64, _: Place) -> Option<T> {
        let sum: i64 = (*sum).into();
        let sum = sum as f64 / self.number.one() as f64;
        Some(self.number.hold(sum * sum * gain))
    }
    #[inline(always)]
    fn positives(&self, operands: &[&[T]], bytes: &mut [u8]) -> bool {
        match *operands {
            [a] => each([a], bytes, |[a]| (a > T::ZERO).into()),
            // What saturates keeps its sign.
            [a, b] => each([a, b], bytes, |all| (saturated_sum(all) < T::ZERO).into()),
            _ => wide_positives(operands, bytes),
        }
        true
    }
    #[inline]
    fn positive(&self, sum: &T::Wide) -> Option<bool> {
        Some(*sum > T::Wide::default())
    }
    #[inline]
    fn limit(&self, cell: T) -> T {
        cell.clamp(self.limits.0, self.limits.1)
    }
}

/// Stores of any number of wires and targets, by way of wide sums.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn wide_row<T: Width>(operands: &[&[T]], by: u32, saturates: bool, cells: &mut [T]) {
    let part = |sum: T::Wide| sum.times(-1).divided(by);
    match *operands {
        [a, b, c] if saturates && by == 1 => each([a, b, c], cells, |[a, b, c]| {
            T::saturate_wide(a.widen().plus(b.widen()).plus(c.widen()).times(-1))
        }),
        _ if saturates => summed(operands, cells, |sum| T::saturate_wide(part(sum))),
        _ => summed(operands, cells, |sum| T::wrap_wide(part(sum))),
    }
}

/// Whether the sum of any number of wires is above zero.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn wide_positives<T: Width>(operands: &[&[T]], bytes: &mut [u8]) {
    summed(operands, bytes, |sum| (sum > T::Wide::default()).into());
}

/// `-(sum)` of at most two, saturated; without leaving the width.
#[inline(always)]
fn saturated_sum<T: Width, const N: usize>(operands: [T; N]) -> T {
    match operands[..] {
        // The first difference would be one too low for the lowest number, which is the larger
        // only where both are; and then the second saturates anyway.
        [a, b] => T::ZERO.less(a.max(b)).less(a.min(b)),
        [a] => T::ZERO.less(a),
        _ => T::ZERO,
    }
}

/// `-(sum) / 2` of at most two, halves to even, saturated; without leaving the width.
#[inline(always)]
fn saturated_half<T: Width, const N: usize>(operands: [T; N]) -> T {
    match operands[..] {
        [a, b] => T::ZERO.less(a.middle(b)),
        [a] => T::ZERO.less(a.middle(T::ZERO)),
        _ => T::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::Analog;
    use proptest::prelude::*;

    /// Anywhere: fixed point is the same everywhere.
    const PLACE: Place = Place {
        y: 0,
        x: 0,
        register: Analog(0),
        step: 0,
    };

    /// The row's cells against the wide sum of each.
    fn agree<T: Width + PartialEq, const N: usize>(number: Q<T>, values: [&[T]; N]) {
        let domain = Fixed::new(number);
        for by in 1..=3 {
            let share = Share { by, part: None };
            let n = values.first().map_or(1, |values| values.len());
            let mut row = vec![T::ZERO; n];
            domain.store_row(&values, share, PLACE, &mut row);
            for (i, cell) in row.into_iter().enumerate() {
                let expected = domain.store(&domain.sum(&values, i), share, PLACE);
                let operands = values.map(|values| values[i]);
                assert_eq!(cell, expected, "{operands:?} by {by}");
            }
            if by == 1 {
                masked(&domain, values, n);
            }
        }
    }

    /// Some of the row's cells, against the wide sum of each of them.
    fn masked<T: Width + PartialEq, const N: usize>(
        domain: &Fixed<T>,
        values: [&[T]; N],
        n: usize,
    ) {
        let share = Share { by: 1, part: None };
        let word = |k: usize| (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let words: Vec<u64> = (0..n.div_ceil(64)).map(word).collect();
        let mut row = vec![T::LIMITS.1; n];
        if !domain.store_some(&values, &words, &mut row) {
            return;
        }
        for (i, cell) in row.into_iter().enumerate() {
            let expected = if words[i / 64] >> (i % 64) & 1 == 1 {
                domain.store(&domain.sum(&values, i), share, PLACE)
            } else {
                T::LIMITS.1
            };
            assert_eq!(cell, expected, "cell {i}, under a mask");
        }
    }

    fn formats<T: Width + PartialEq, const N: usize>(values: [&[T]; N]) {
        for fraction in [0, 4, T::BITS - 1] {
            for overflow in [Overflow::Saturate, Overflow::Wrap] {
                agree(Q::<T>::new(fraction).with_overflow(overflow), values);
            }
        }
    }

    #[test]
    fn all_pairs_of_bytes_are_as_the_wide_sum_says() {
        let pairs = (i8::MIN..=i8::MAX).flat_map(|a| (i8::MIN..=i8::MAX).map(move |b| (a, b)));
        let (a, b): (Vec<_>, Vec<_>) = pairs.unzip();
        formats::<i8, 0>([]);
        formats([&a]);
        formats([&a, &b]);
        formats([&a, &b, &a[..]]);
    }

    /// Two stores at once against the one and then the other.
    fn pairs_agree(operands: &[&[i16]], extra: Option<&[i16]>) {
        let nought = || vec![0; operands[0].len()];
        let domain = Fixed::new(Q::<i16>::new(0));
        let store = |operands: &[&[i16]], by| {
            let mut cells = nought();
            domain.store_row(operands, Share { by, part: None }, PLACE, &mut cells);
            cells
        };
        for by in [1, 2] {
            let first = store(operands, by);
            let second = match extra {
                Some(extra) => store(&[&first, extra], 1),
                None => store(&[&first], 1),
            };
            let mut cells = nought();
            domain.store_pair(operands, by, extra, &mut cells);
            assert!(cells == second, "{} by {by}, {extra:?}", operands.len());
        }
    }

    #[test]
    fn two_stores_at_once_are_as_one_after_the_other() {
        let near = |end: i16| (-3i16..=3).map(move |d| end.saturating_add(d));
        let values: Vec<i16> = near(i16::MIN)
            .chain(near(0))
            .chain(near(i16::MAX))
            .collect();
        let mut all = [vec![], vec![], vec![]];
        for a in &values {
            for b in &values {
                for c in &values {
                    all[0].push(*a);
                    all[1].push(*b);
                    all[2].push(*c);
                }
            }
        }
        let [a, b, c] = &all;
        pairs_agree(&[a], None);
        pairs_agree(&[a], Some(c));
        pairs_agree(&[a, b], None);
        pairs_agree(&[a, b], Some(c));
    }

    #[test]
    fn the_edges_of_words_are_as_the_wide_sum_says() {
        fn edges<T: Width + PartialEq>() {
            let (low, high) = T::LIMITS;
            let near = |end: T| (-3i64..=3).map(move |d| T::saturate(end.into() + d));
            let values: Vec<T> = near(low).chain(near(T::ZERO)).chain(near(high)).collect();
            let pairs = values
                .iter()
                .flat_map(|a| values.iter().map(move |b| (*a, *b)));
            let (a, b): (Vec<_>, Vec<_>) = pairs.unzip();
            formats([&a]);
            formats([&a, &b]);
            formats([&a, &b, &b[..], &a]);
        }
        edges::<i16>();
        edges::<i32>();
    }

    proptest! {
        #[test]
        fn any_words_are_as_the_wide_sum_says(
            a in prop::collection::vec(any::<(i16, i16, i16)>(), 1..100)
        ) {
            let of = |k: fn(&(i16, i16, i16)) -> i16| a.iter().map(k).collect::<Vec<_>>();
            let (x, y, z) = (of(|v| v.0), of(|v| v.1), of(|v| v.2));
            formats([&x, &y]);
            formats([&x, &y, &z[..]]);
        }
    }
}
