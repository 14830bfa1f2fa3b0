//! One bit for every pixel, 64 pixels a word.

use multiversion::multiversion;

use crate::{
    isa::Direction,
    plane::{Plane, Size},
};

/// One bit for every pixel. Rows start at a new word; bits beyond the width are 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitPlane {
    size: Size,
    stride: usize,
    words: Vec<u64>,
}

impl BitPlane {
    /// All pixels 0.
    #[must_use]
    pub fn zeros(size: Size) -> Self {
        let stride = size.width.div_ceil(64);
        Self {
            size,
            stride,
            words: vec![0; stride * size.height],
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
        self.words.fill(if value { !0 } else { 0 });
        self.cut();
    }

    /// How many pixels are 1.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.words.iter().map(|w| u64::from(w.count_ones())).sum()
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
        for row in self.words.chunks_exact(self.stride) {
            for (any, word) in any.iter_mut().zip(row) {
                *any |= word;
            }
        }
        (0..self.size.width)
            .map(|x| any[x / 64] >> (x % 64) & 1 == 1)
            .collect()
    }

    /// Takes the bits out, to be put back.
    pub(super) fn take(&mut self) -> Self {
        Self {
            words: std::mem::take(&mut self.words),
            ..*self
        }
    }

    /// Clears what lies beyond the width.
    fn cut(&mut self) {
        let used = self.size.width % 64;
        if used != 0 {
            for row in self.words.chunks_exact_mut(self.stride) {
                row[self.stride - 1] &= (1 << used) - 1;
            }
        }
    }

    /// Whether all of a row is 1.
    pub(super) fn is_whole(&self, y: usize) -> bool {
        let (last, full) = (self.stride - 1, self.row(y));
        let used = self.size.width - 64 * last;
        full[..last].iter().all(|word| *word == !0) && full[last] == !0 >> (64 - used)
    }

    /// Each pixel becomes 1 where any of `others` is, or it itself where it is `kept`; with
    /// `not` the other way.
    pub(super) fn set_any(&mut self, others: &[&Self], kept: bool, not: bool) {
        let turn = if not { !0 } else { 0 };
        match others {
            [] => or_all(&mut self.words, [], kept, turn),
            [a] => or_all(&mut self.words, [&a.words], kept, turn),
            [a, b] => or_all(&mut self.words, [&a.words, &b.words], kept, turn),
            [a, b, c] => or_all(&mut self.words, [&a.words, &b.words, &c.words], kept, turn),
            [a, b, c, d, more @ ..] => {
                let four = [&a.words, &b.words, &c.words, &d.words].map(Vec::as_slice);
                or_all(&mut self.words, four, kept, 0);
                for more in more {
                    or_all(&mut self.words, [&more.words], true, 0);
                }
                if not {
                    or_all(&mut self.words, [], true, !0);
                }
            }
        }
        if not {
            self.cut();
        }
    }

    /// Each pixel the other way.
    pub(super) fn not(&mut self) {
        self.set_any(&[], true, true);
    }

    /// Takes `new` where `mask` is 1.
    pub(super) fn assign_where(&mut self, new: &Self, mask: &Self) {
        for ((word, new), mask) in self.words.iter_mut().zip(&new.words).zip(&mask.words) {
            *word = (*word & !mask) | (new & mask);
        }
    }

    /// Adds `other` where `mask` is 1.
    pub(super) fn or_where(&mut self, other: &Self, mask: &Self) {
        for ((word, other), mask) in self.words.iter_mut().zip(&other.words).zip(&mask.words) {
            *word |= other & mask;
        }
    }

    /// What each pixel sees at its neighbour; `boundary` lies off the array.
    #[must_use]
    pub(super) fn seen(&self, direction: Direction, boundary: bool) -> Self {
        let mut out = Self::zeros(self.size);
        let (height, width) = self.size.shape();
        let beyond = if boundary { !0 } else { 0 };
        for (y, row) in out.words.chunks_exact_mut(self.stride).enumerate() {
            match direction {
                Direction::North if y > 0 => row.copy_from_slice(self.row(y - 1)),
                Direction::South if y + 1 < height => row.copy_from_slice(self.row(y + 1)),
                Direction::North | Direction::South => row.fill(beyond),
                Direction::West => {
                    let mut carry = u64::from(boundary);
                    for (to, from) in row.iter_mut().zip(self.row(y)) {
                        *to = from << 1 | carry;
                        carry = from >> 63;
                    }
                }
                Direction::East => {
                    let mut carry = 0;
                    for (to, from) in row.iter_mut().zip(self.row(y)).rev() {
                        *to = from >> 1 | carry << 63;
                        carry = from & 1;
                    }
                    let last = width - 1;
                    if boundary {
                        row[last / 64] |= 1 << (last % 64);
                    }
                }
            }
        }
        out.cut();
        out
    }
}

/// OR of `others` and, where kept, of what was there; then XOR `turn`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn or_all<const N: usize>(words: &mut [u64], others: [&[u64]; N], kept: bool, turn: u64) {
    let others = others.map(|other| &other[..words.len()]);
    if kept {
        for (i, word) in words.iter_mut().enumerate() {
            *word = others.iter().fold(*word, |any, other| any | other[i]) ^ turn;
        }
    } else {
        for (i, word) in words.iter_mut().enumerate() {
            *word = others.iter().fold(0, |any, other| any | other[i]) ^ turn;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
                let seen = packed.seen(direction, boundary);
                for y in 0..height {
                    for x in 0..width {
                        let at = (y.wrapping_add_signed(dy), x.wrapping_add_signed(dx));
                        prop_assert_eq!(seen.get(y, x), plane.get(at).copied().unwrap_or(boundary));
                    }
                }
                let inside = (0..height).flat_map(|y| (0..width).map(move |x| (y, x)));
                prop_assert_eq!(seen.count(), inside.filter(|&(y, x)| seen.get(y, x)).count() as u64);
            }
        }
    }
}
