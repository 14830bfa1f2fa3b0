//! Fixed point in the cells.

// What is not inlined into the loops of `rows` is not compiled for wide vectors.
#![allow(clippy::inline_always)]

use super::{
    Domain, Place, Share,
    domain::LIMITS,
    each::{each, picked, some, twice},
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
    fn store_row<const N: usize>(
        &self,
        operands: [&[T]; N],
        share: Share,
        _: Place,
        clip: bool,
        cells: &mut [T],
    ) {
        // Without a choice inside the loops.
        let saturates = self.number.overflow() == Overflow::Saturate;
        match (saturates, share.by) {
            (true, 1) if N <= 2 => each(operands, cells, saturated_sum),
            (false, 1) => each(operands, cells, wrapped_sum),
            (true, 2) if N <= 2 => each(operands, cells, saturated_half),
            (true, by) => each(operands, cells, |all| T::saturate_wide(wide_part(all, by))),
            (false, by) => each(operands, cells, |all| T::wrap_wide(wide_part(all, by))),
        }
        if clip {
            for cell in cells {
                *cell = self.limit(*cell);
            }
        }
    }
    #[inline(always)]
    fn store_some<const N: usize>(
        &self,
        operands: [&[T]; N],
        words: &[u64],
        cells: &mut [T],
    ) -> bool {
        match self.number.overflow() {
            Overflow::Saturate if N <= 2 => some(operands, words, cells, saturated_sum),
            Overflow::Saturate => return false,
            Overflow::Wrap => some(operands, words, cells, wrapped_sum),
        }
        true
    }
    fn pairs(&self) -> bool {
        true
    }
    #[inline(always)]
    fn store_pair<const N: usize, const M: usize>(
        &self,
        operands: [&[T]; N],
        by: u32,
        extra: [&[T]; M],
        between: Option<&mut [T]>,
        cells: &mut [T],
    ) {
        match self.number.overflow() {
            Overflow::Saturate if between.is_none() && (by == 2 || (N, M) != (2, 1)) => {
                saturated_pair(operands, by, extra, cells);
            }
            Overflow::Saturate => {
                let second = |first, extra: [T; M]| match extra[..] {
                    [extra] => saturated_sum([first, extra]),
                    _ => saturated_sum([first]),
                };
                if by == 2 {
                    twice(operands, extra, between, cells, saturated_half, second);
                } else {
                    twice(operands, extra, between, cells, saturated_sum, second);
                }
            }
            Overflow::Wrap => {
                let second = |first, extra: [T; M]| wrapped_sum(extra).wrapping_less(first);
                if by == 2 {
                    let half = |operands| T::wrap_wide(wide_part(operands, 2));
                    twice(operands, extra, between, cells, half, second);
                } else {
                    twice(operands, extra, between, cells, wrapped_sum, second);
                }
            }
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
    fn positives<const N: usize>(&self, operands: [&[T]; N], bytes: &mut [u8]) -> bool {
        let (blocks, rest) = bytes.as_chunks_mut::<64>();
        let done = 64 * blocks.len();
        let whole = operands.map(|operand| operand.as_chunks::<64>().0);
        for (k, bytes) in blocks.iter_mut().enumerate() {
            for (i, byte) in bytes.iter_mut().enumerate() {
                let operands = picked(whole.map(|whole| &whole[k]), i);
                // What saturates keeps its sign.
                *byte = if N <= 2 {
                    saturated_sum(operands) < T::ZERO
                } else {
                    wide_part(operands, 1) < T::Wide::default()
                }
                .into();
            }
        }
        for (i, byte) in rest.iter_mut().enumerate() {
            *byte = (wide_part(picked(operands, done + i), 1) < T::Wide::default()).into();
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

/// Two saturating stores, where nobody reads what the first stores: what it would store, taken
/// from nought, is the sum, but for the lowest number, or half the sum.
#[inline(always)]
fn saturated_pair<T: Width, const N: usize, const M: usize>(
    operands: [&[T]; N],
    by: u32,
    extra: [&[T]; M],
    cells: &mut [T],
) {
    let lowest = T::ZERO.less(T::LIMITS.1);
    let sum = |operands: [T; N]| match operands[..] {
        [a, b] => a.more(b).max(lowest),
        [a] => a.max(lowest),
        _ => T::ZERO,
    };
    let second = |sum: T, extra: [T; M]| match extra[..] {
        [extra] => sum.less(extra),
        _ => sum,
    };
    if by == 2 {
        let half = |operands: [T; N]| match operands[..] {
            [a, b] => a.middle(b).max(lowest),
            [a] => a.middle(T::ZERO),
            _ => T::ZERO,
        };
        twice(operands, extra, None, cells, half, second);
    } else {
        twice(operands, extra, None, cells, sum, second);
    }
}

/// `-(sum) / by`.
#[inline(always)]
fn wide_part<T: Width, const N: usize>(operands: [T; N], by: u32) -> T::Wide {
    let mut sum = T::Wide::default();
    for operand in operands {
        sum = sum.plus(operand.widen());
    }
    sum.times(-1).divided(by)
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

/// `-(sum)` of any number of them, wrapped: as differences that wrap.
#[inline(always)]
fn wrapped_sum<T: Width, const N: usize>(operands: [T; N]) -> T {
    let mut less = T::ZERO;
    for operand in operands {
        less = less.wrapping_less(operand);
    }
    less
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
            for clip in [false, true] {
                let share = Share { by, part: None };
                let n = values.first().map_or(1, |values| values.len());
                let mut row = vec![T::ZERO; n];
                domain.store_row(values, share, PLACE, clip, &mut row);
                for (i, cell) in row.into_iter().enumerate() {
                    let stored = domain.store(&domain.sum(&values, i), share, PLACE);
                    let expected = if clip { domain.limit(stored) } else { stored };
                    let operands = values.map(|values| values[i]);
                    assert_eq!(cell, expected, "{operands:?} by {by}, {clip}");
                }
                if by == 1 && !clip {
                    masked(&domain, values, n);
                }
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
        if !domain.store_some(values, &words, &mut row) {
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
    fn pairs_agree<T: Width + PartialEq, const N: usize, const M: usize>(
        operands: [&[T]; N],
        extra: [&[T]; M],
    ) {
        let n = operands
            .iter()
            .chain(&extra)
            .map(|v| v.len())
            .next()
            .unwrap_or(70);
        let nought = || vec![T::ZERO; n];
        for overflow in [Overflow::Saturate, Overflow::Wrap] {
            let domain = Fixed::new(Q::<T>::new(0).with_overflow(overflow));
            for by in [1, 2] {
                let (mut first, mut second) = (nought(), nought());
                let share = Share { by, part: None };
                domain.store_row(operands, share, PLACE, false, &mut first);
                let share = Share { by: 1, part: None };
                match extra[..] {
                    [extra] => {
                        domain.store_row([&first, extra], share, PLACE, false, &mut second);
                    }
                    _ => domain.store_row([&first], share, PLACE, false, &mut second),
                }
                let (mut between, mut cells) = (nought(), nought());
                domain.store_pair(operands, by, extra, Some(&mut between), &mut cells);
                assert!(between == first, "{overflow:?} by {by}, the first");
                assert!(cells == second, "{overflow:?} by {by}, the second");
                let mut cells = nought();
                domain.store_pair(operands, by, extra, None, &mut cells);
                assert!(cells == second, "{overflow:?} by {by}, only the second");
            }
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
        pairs_agree::<i16, 0, 0>([], []);
        pairs_agree([], [c]);
        pairs_agree([a], []);
        pairs_agree([a], [c]);
        pairs_agree([a, b], []);
        pairs_agree([a, b], [c]);
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
