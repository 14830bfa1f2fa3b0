//! Fixed point in the cells.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use super::{
    Ageing, Domain, Place, RowOps, Share,
    each::{above, each, each_twice, has_wide_vectors, some, summed},
};
use crate::number::{Number, Overflow, Q, Wide, Width};

/// Fixed point in the cells, an integer on the bus that holds every sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed<T> {
    number: Q<T>,
}

impl<T: Width> Fixed<T> {
    /// In this format.
    #[must_use]
    pub const fn new(number: Q<T>) -> Self {
        Self { number }
    }

    #[inline]
    fn saturates(self) -> bool {
        self.number.overflow() == Overflow::Saturate
    }
}

/// Cells that are set at a time.
const BLOCK: usize = 64;

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
    fn square(&self, sum: &T::Wide, gain: f64, _: Place) -> Option<T> {
        let sum: i64 = (*sum).into();
        let sum = sum as f64 / self.number.one() as f64;
        Some(self.number.hold(sum * sum * gain))
    }
    #[inline]
    fn positive(&self, sum: &T::Wide) -> Option<bool> {
        Some(*sum > T::Wide::default())
    }
    #[inline(always)]
    fn limit(&self, cell: T, (low, high): (f64, f64)) -> T {
        // Where the format is narrower than the range, its own ends limit it already.
        let end = |limit: f64| T::saturate((limit * self.number.one() as f64) as i64);
        cell.clamp(end(low), end(high))
    }
}

impl<T: Width> Ageing for Fixed<T> {}

impl<T: Width> RowOps for Fixed<T> {
    #[inline(always)]
    fn hold_row(&self, level: f64, gain: f64, values: &[f64], cells: &mut [T]) {
        let mut done = 0;
        if self.saturates() {
            // By way of wider integers: a loop from the widest to the narrowest is slow.
            let one = self.number.one() as f64;
            let blocks = cells.as_chunks_mut::<BLOCK>().0.iter_mut();
            for (cells, values) in blocks.zip(values.as_chunks::<BLOCK>().0) {
                let mut bits = [0; BLOCK];
                for (bits, value) in bits.iter_mut().zip(values) {
                    *bits = T::nearest((level + gain * value) * one);
                }
                for (cell, bits) in cells.iter_mut().zip(&bits) {
                    *cell = T::low(*bits);
                }
                done += BLOCK;
            }
        }
        for (cell, value) in cells.iter_mut().zip(values).skip(done) {
            *cell = self.hold(level + gain * value);
        }
    }
    fn store_row(&self, operands: &[&[T]], share: Share, _: Place, cells: &mut [T]) {
        if self.saturates() {
            saturated_row(operands, share.by, cells);
        } else {
            wrapped_row(operands, share.by, cells);
        }
    }
    fn store_some(&self, operands: &[&[T]], words: &[u64], cells: &mut [T]) -> bool {
        self.saturates() && saturated_some(operands, words, cells)
    }
    fn fuses(&self) -> bool {
        self.saturates()
    }
    fn store_fused(
        &self,
        operands: &[&[T]],
        own: bool,
        by: u32,
        extra: Option<&[T]>,
        cells: &mut [T],
    ) {
        saturated_pair(operands, own, by, extra, cells);
    }
    #[inline(always)]
    fn choose(&self, old: &T, new: &T, take: u8) -> T {
        T::choose(*old, *new, take)
    }
    fn positives(&self, operands: &[&[T]], bytes: &mut [u8]) -> bool {
        positives(operands, bytes);
        true
    }
    fn positive_words(&self, operands: &[&[T]], words: &mut [u64]) -> bool {
        positive_words(operands, words)
    }
}

// Each of these is compiled for several vector widths. What they hand to a loop has a name, or is
// made by a function that has one: a closure written here would be one of its own for each width,
// and so would the loop.

/// Stores along a row.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn saturated_row<T: Width>(operands: &[&[T]], by: u32, cells: &mut [T]) {
    let wide = has_wide_vectors!();
    match (operands, by) {
        ([], _) => cells.fill(T::ZERO),
        _ if !wide => summed(operands, cells, saturated_part(by)),
        (&[a], 1) => each([a], cells, saturated_sum),
        (&[a], 2) => each([a], cells, saturated_half),
        (&[a, b], 1) => each([a, b], cells, saturated_sum),
        (&[a, b], 2) => each([a, b], cells, saturated_half),
        (&[a, b, c], 1) => each([a, b, c], cells, saturated_three),
        _ => summed(operands, cells, saturated_part(by)),
    }
}

#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn wrapped_row<T: Width>(operands: &[&[T]], by: u32, cells: &mut [T]) {
    summed(operands, cells, wrapped_part(by));
}

/// Stores where the bit is 1; whether the operands are so few.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn saturated_some<T: Width>(operands: &[&[T]], words: &[u64], cells: &mut [T]) -> bool {
    let wide = has_wide_vectors!();
    match *operands {
        _ if !wide => return false,
        [a] => some([a], words, cells, saturated_sum),
        [a, b] => some([a, b], words, cells, saturated_sum),
        _ => return false,
    }
    true
}

/// Two stores at once.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn saturated_pair<T: Width>(
    operands: &[&[T]],
    own: bool,
    by: u32,
    extra: Option<&[T]>,
    cells: &mut [T],
) {
    let wide = has_wide_vectors!();
    if by == 1 {
        let one = (back, back_less);
        each_twice(
            operands,
            own,
            extra,
            cells,
            wide,
            &one,
            &(twice_sum, twice_sum_less),
        );
    } else {
        let one = (half, half_less);
        each_twice(
            operands,
            own,
            extra,
            cells,
            wide,
            &one,
            &(half_sum, half_sum_less),
        );
    }
}

/// Whether each sum is above zero.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn positives<T: Width>(operands: &[&[T]], bytes: &mut [u8]) {
    let wide = has_wide_vectors!();
    match *operands {
        _ if !wide => summed(operands, bytes, positive_wide::<T>),
        [a] => each([a], bytes, positive),
        [a, b] => each([a, b], bytes, positive),
        [a, b, c] => each([a, b, c], bytes, positive),
        _ => summed(operands, bytes, positive_wide::<T>),
    }
}

/// The same in words of bits; whether the operands are so few.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn positive_words<T: Width>(operands: &[&[T]], words: &mut [u64]) -> bool {
    let wide = has_wide_vectors!();
    match *operands {
        _ if !wide => return false,
        [a] => above([a], words, signed),
        [a, b] => above([a, b], words, signed),
        [a, b, c] => above([a, b, c], words, signed),
        _ => return false,
    }
    true
}

/// `-(sum) / by`, saturated.
#[inline(always)]
fn saturated_part<T: Width>(by: u32) -> impl Fn(T::Wide) -> T {
    move |sum| T::saturate_wide(sum.times(-1).divided(by))
}

/// `-(sum) / by`, wrapped.
#[inline(always)]
fn wrapped_part<T: Width>(by: u32) -> impl Fn(T::Wide) -> T {
    move |sum| T::wrap_wide(sum.times(-1).divided(by))
}

/// 1 where the sum of at most three is above zero.
#[inline(always)]
fn positive<T: Width, const N: usize>(operands: [T; N]) -> u8 {
    (signed(operands) > T::ZERO).into()
}

/// The same of the sum of any number.
#[inline(always)]
fn positive_wide<T: Width>(sum: T::Wide) -> u8 {
    (sum > T::Wide::default()).into()
}

// What the second of two stores leaves. What the first stores, taken from nought, is the sum, but
// for the lowest number, or half the sum.

/// What a number is that was stored and taken from nought: all but the lowest come back.
#[inline(always)]
fn back<T: Width>(a: T) -> T {
    a.max(T::ZERO.less(T::LIMITS.1))
}

#[inline(always)]
fn back_less<T: Width>(a: T, c: T) -> T {
    back(a).less(c)
}

#[inline(always)]
fn twice_sum<T: Width>(a: T, b: T) -> T {
    back(a.more(b))
}

#[inline(always)]
fn twice_sum_less<T: Width>(a: T, b: T, c: T) -> T {
    saturated_sum([saturated_sum([a, b]), c])
}

#[inline(always)]
fn half<T: Width>(a: T) -> T {
    a.middle(T::ZERO)
}

#[inline(always)]
fn half_less<T: Width>(a: T, c: T) -> T {
    half(a).less(c)
}

#[inline(always)]
fn half_sum<T: Width>(a: T, b: T) -> T {
    back(a.middle(b))
}

#[inline(always)]
fn half_sum_less<T: Width>(a: T, b: T, c: T) -> T {
    half_sum(a, b).less(c)
}

/// What has the sign of the sum of at most three: saturated, it keeps that.
#[inline(always)]
fn signed<T: Width, const N: usize>(operands: [T; N]) -> T {
    match operands[..] {
        [a] => a,
        [a, b] => a.more(b),
        [a, b, c] => {
            let (outer, middle) = outer([a, b, c]);
            outer.more(middle)
        }
        _ => T::ZERO,
    }
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

/// `-(sum)` of three, saturated; without leaving the width.
#[inline(always)]
fn saturated_three<T: Width>(operands: [T; 3]) -> T {
    // Where the first sum saturates, or its difference is one too low for the lowest number, no
    // two have opposite signs, and the second difference saturates anyway.
    let (outer, middle) = outer(operands);
    T::ZERO.less(outer).less(middle)
}

/// Of three: the sum of the largest and the smallest, and the third.
///
/// The sum saturates only where no two have opposite signs: with the third, it keeps its sign.
#[inline(always)]
fn outer<T: Width>([a, b, c]: [T; 3]) -> (T, T) {
    let (low, high) = (a.min(b), a.max(b));
    let (between, largest) = (high.min(c), high.max(c));
    (low.min(between).more(largest), low.max(between))
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
                masked(domain, values, n);
                positive(domain, values, n);
            }
        }
    }

    /// Some of the row's cells, against the wide sum of each of them.
    fn masked<T: Width + PartialEq, const N: usize>(domain: Fixed<T>, values: [&[T]; N], n: usize) {
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

    /// Which sums are above zero, against the wide sum of each of them.
    fn positive<T: Width, const N: usize>(domain: Fixed<T>, values: [&[T]; N], n: usize) {
        let mut bytes = vec![2; n];
        assert!(domain.positives(&values, &mut bytes));
        let mut words = vec![0; n / 64];
        let in_words = domain.positive_words(&values, &mut words);
        assert_eq!(in_words, (1..=3).contains(&N));
        for (i, byte) in bytes.into_iter().enumerate() {
            let expected = domain.positive(&domain.sum(&values, i));
            assert_eq!(Some(byte == 1), expected, "{:?}", values.map(|v| v[i]));
            if let (true, Some(word)) = (in_words, words.get(i / 64)) {
                assert_eq!(
                    word >> (i % 64) & 1,
                    u64::from(byte),
                    "{:?}",
                    values.map(|v| v[i])
                );
            }
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
            domain.store_fused(operands, false, by, extra, &mut cells);
            assert!(cells == second, "{} by {by}, {extra:?}", operands.len());
            for own in 0..operands.len() {
                let mut others = operands.to_vec();
                let mut cells = others.remove(own).to_vec();
                domain.store_fused(&others, true, by, extra, &mut cells);
                assert!(
                    cells == second,
                    "{own} of {} by {by}, {extra:?}",
                    operands.len()
                );
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
            let [mut a, mut b, mut c] = [vec![], vec![], vec![]];
            for first in &values {
                for second in &values {
                    a.extend(values.iter().map(|_| *first));
                    b.extend(values.iter().map(|_| *second));
                    c.extend(&values);
                }
            }
            formats([&a]);
            formats([&a, &b]);
            formats([&a, &b, &c]);
            formats([&a, &b, &c[..], &a]);
        }
        edges::<i16>();
        edges::<i32>();
    }

    proptest! {
        #[test]
        fn a_row_is_held_as_each_value_is(
            values in prop::collection::vec(
                prop_oneof![-200.0..200.0, prop::num::f64::ANY, Just(1.5 / 256.0)],
                0..200,
            ),
            level in -10.0..10.0f64,
            wraps: bool,
        ) {
            let overflow = if wraps { Overflow::Wrap } else { Overflow::Saturate };
            let domain = Fixed::new(Q::<i16>::new(8).with_overflow(overflow));
            let mut row = vec![0; values.len()];
            domain.hold_row(level, -0.5, &values, &mut row);
            let each: Vec<_> = values.iter().map(|value| domain.hold(level - 0.5 * value)).collect();
            prop_assert_eq!(row, each);
        }

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
