//! One bit for every pixel, 64 pixels a word.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use crate::{
    aligned::Aligned,
    isa::Direction,
    plane::{Plane, Size},
};

/// One bit for every pixel. Rows start at a new word; bits beyond the width are 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitPlane {
    size: Size,
    stride: usize,
    words: Aligned<u64>,
}

impl BitPlane {
    /// All pixels 0.
    #[must_use]
    pub fn zeros(size: Size) -> Self {
        Self::apart(size, 0)
    }

    /// All pixels 0; the plane number `k` of several that are worked on together.
    pub(super) fn apart(size: Size, k: usize) -> Self {
        let stride = size.width.div_ceil(64);
        Self {
            size,
            stride,
            words: Aligned::new(k, 0, stride * size.height),
        }
    }

    /// All pixels 1.
    #[must_use]
    pub fn ones(size: Size) -> Self {
        let mut plane = Self::zeros(size);
        plane.fill(true);
        plane
    }

    /// From a plane of booleans.
    #[must_use]
    pub fn from_plane(plane: &Plane<bool>) -> Self {
        let mut bits = Self::zeros(Size::of(plane));
        for ((y, x), bit) in plane.indexed_iter() {
            bits.set(y, x, *bit);
        }
        bits
    }

    /// As a plane of booleans.
    #[must_use]
    pub fn to_plane(&self) -> Plane<bool> {
        Plane::from_shape_fn(self.size.shape(), |(y, x)| self.get(y, x))
    }

    /// The bit of one pixel of the array.
    #[must_use]
    pub fn get(&self, y: usize, x: usize) -> bool {
        self.row(y)[x / 64] >> (x % 64) & 1 == 1
    }

    /// Sets the bit of one pixel of the array.
    pub fn set(&mut self, y: usize, x: usize, value: bool) {
        let word = &mut self.words[y * self.stride + x / 64];
        let mask = 1 << (x % 64);
        *word = if value { *word | mask } else { *word & !mask };
    }

    /// Sets all pixels.
    pub fn fill(&mut self, value: bool) {
        fill(&mut self.words, self.size.width, value);
    }

    /// How many pixels are 1.
    #[must_use]
    pub fn count(&self) -> u64 {
        count(&self.words)
    }

    /// The words of one row.
    #[must_use]
    pub fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.stride..][..self.stride]
    }

    /// The words of one row, to be written; bits beyond the width stay 0.
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [u64] {
        &mut self.words[y * self.stride..][..self.stride]
    }

    /// Which columns hold a pixel that is 1.
    #[must_use]
    pub fn columns(&self) -> Vec<bool> {
        let mut any = vec![0; self.stride];
        // Rows of no pixels have no words.
        for row in self.words.chunks_exact(self.stride.max(1)) {
            for (any, word) in any.iter_mut().zip(row) {
                *any |= word;
            }
        }
        (0..self.size.width)
            .map(|x| any[x / 64] >> (x % 64) & 1 == 1)
            .collect()
    }

    /// Whether all pixels are 1.
    pub(super) fn is_full(&self) -> bool {
        let beyond = 64 * self.stride - self.size.width;
        if beyond == 0 {
            return self.words.iter().fold(!0, |all, word| all & word) == !0;
        }
        let last = |i: usize| i % self.stride == self.stride - 1;
        let full = |(i, word): (usize, &u64)| *word == if last(i) { !0 >> beyond } else { !0 };
        self.words.iter().enumerate().all(full)
    }

    /// The words of all rows.
    pub(super) fn words(&self) -> &[u64] {
        &self.words
    }

    /// The words of all rows, to be written; bits beyond the width stay 0.
    pub(super) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// Each pixel the other way.
    pub(super) fn not(&mut self) {
        or_any(&mut self.words, &[], true, true);
        cut(&mut self.words, self.size.width);
    }
}

/// How many bits are 1.
#[multiversion(targets("x86_64+avx2+popcnt", "aarch64+neon"))]
fn count(words: &[u64]) -> u64 {
    let mut count = 0;
    for word in words {
        count += u64::from(word.count_ones());
    }
    count
}

/// Clears what lies beyond the width, in all rows.
pub(super) fn cut(words: &mut [u64], width: usize) {
    let used = width % 64;
    if used != 0 {
        for last in words.iter_mut().skip(width / 64).step_by(width / 64 + 1) {
            *last &= (1 << used) - 1;
        }
    }
}

/// Sets all pixels of these rows.
pub(super) fn fill(words: &mut [u64], width: usize, value: bool) {
    words.fill(if value { !0 } else { 0 });
    cut(words, width);
}

/// Takes `new` where `mask` is 1.
pub(super) fn assign_where(words: &mut [u64], new: &[u64], mask: &[u64]) {
    for ((word, new), mask) in words.iter_mut().zip(new).zip(mask) {
        *word = (*word & !mask) | (new & mask);
    }
}

/// Takes 0 where `mask` is 1.
pub(super) fn clear_where(words: &mut [u64], mask: &[u64]) {
    for (word, mask) in words.iter_mut().zip(mask) {
        *word &= !mask;
    }
}

/// What the word `i` of a row sees at its neighbours in the row `there`, which is the row
/// above, below, or the same; `boundary` lies beyond its ends.
#[inline]
pub(super) fn seen(
    there: &[u64],
    i: usize,
    direction: Direction,
    width: usize,
    boundary: bool,
) -> u64 {
    match direction {
        Direction::North | Direction::South => there[i],
        Direction::West => {
            let carry = if i == 0 {
                u64::from(boundary)
            } else {
                there[i - 1] >> 63
            };
            there[i] << 1 | carry
        }
        Direction::East => {
            let last = i == (width - 1) / 64;
            let carry = there.get(i + 1).map_or(0, |next| next << 63);
            let beyond = u64::from(boundary && last) << ((width - 1) % 64);
            there[i] >> 1 | carry | beyond
        }
    }
}

/// Adds to a row what it sees in one direction, where that is enabled; no row `there`: what
/// lies off the array.
pub(super) fn or_seen(
    row: &mut [u64],
    there: Option<&[u64]>,
    direction: Direction,
    width: usize,
    boundary: bool,
    enabled: &[u64],
) {
    for (i, (word, enabled)) in row.iter_mut().zip(enabled).enumerate() {
        let seen = match there {
            Some(there) => seen(there, i, direction, width, boundary),
            None if boundary => !0,
            None => 0,
        };
        *word |= seen & enabled;
    }
}

/// OR of at most four `others` and, where kept, of what was there; with `not` the other way.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn or_any(words: &mut [u64], others: &[&[u64]], kept: bool, not: bool) {
    match *others {
        [] => or(words, [], kept, not),
        [a] => or(words, [a], kept, not),
        [a, b] => or(words, [a, b], kept, not),
        [a, b, c] => or(words, [a, b, c], kept, not),
        [a, b, c, d, ..] => or(words, [a, b, c, d], kept, not),
    }
}

/// The same of so many.
#[inline(always)]
fn or<const N: usize>(words: &mut [u64], others: [&[u64]; N], kept: bool, not: bool) {
    let turn = if not { !0 } else { 0 };
    if kept {
        or_all::<N, true>(words, others, turn);
    } else {
        or_all::<N, false>(words, others, turn);
    }
}

/// The same; then XOR `turn`.
#[inline(always)]
fn or_all<const N: usize, const KEPT: bool>(words: &mut [u64], others: [&[u64]; N], turn: u64) {
    let (blocks, last) = words.as_chunks_mut::<16>();
    let done = 16 * blocks.len();
    let mut whole: [&[[u64; 16]]; N] = [&[]; N];
    for (whole, other) in whole.iter_mut().zip(others) {
        *whole = &other.as_chunks().0[..blocks.len()];
    }
    for (k, block) in blocks.iter_mut().enumerate() {
        let mut any = if KEPT { *block } else { [0; 16] };
        for whole in &whole {
            for (any, other) in any.iter_mut().zip(&whole[k]) {
                *any |= other;
            }
        }
        for any in &mut any {
            *any ^= turn;
        }
        *block = any;
    }
    for (i, word) in last.iter_mut().enumerate() {
        let mut any = if KEPT { *word } else { 0 };
        for other in &others {
            any |= other[done + i];
        }
        *word = any ^ turn;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_plane_of_no_pixels_has_no_columns() {
        assert_eq!(BitPlane::zeros(Size::new(3, 0)).columns(), [false; 0]);
        assert_eq!(BitPlane::zeros(Size::new(0, 3)).columns(), [false; 3]);
    }

    proptest! {
        #[test]
        fn a_neighbour_is_seen_where_it_is(
            (height, width) in (1usize..5, 1usize..140), boundary: bool, bits in prop::collection::vec(prop::bool::ANY, 700)
        ) {
            let plane = Plane::from_shape_fn((height, width), |(y, x)| bits[y * width + x]);
            let packed = BitPlane::from_plane(&plane);
            prop_assert_eq!(&packed.to_plane(), &plane);
            for direction in Direction::ALL {
                let (dy, dx) = direction.step();
                for y in 0..height {
                    let to = y.wrapping_add_signed(dy);
                    let there = (to < height).then(|| packed.row(to));
                    let mut row = vec![0; width.div_ceil(64)];
                    let enabled = BitPlane::ones(Size::new(1, width));
                    or_seen(&mut row, there, direction, width, boundary, enabled.words());
                    for x in 0..64 * row.len() {
                        let at = (to, x.wrapping_add_signed(dx));
                        let expected = plane.get(at).copied().unwrap_or(boundary) && x < width;
                        prop_assert_eq!(row[x / 64] >> (x % 64) & 1 == 1, expected);
                    }
                }
            }
        }
    }
}
