//! Baselines: packets that are right by chance, so that a metric's value can be judged.
//!
//! - A **redraw** keeps where the reference has events, and forgets when: each cell has as many
//!   events as in the reference, at times drawn, with replacement, from the times at which all
//!   *other* cells have theirs. So both its map of rates and its rate over time are the reference's.
//!   Uniform times would flatter the judged packet: events that fall on the frames of a clip, as a
//!   chip's do, match by chance much more often than uniform ones. Where only one cell has events,
//!   the times are uniform between its first and last.
//! - A **permutation** keeps when, and forgets where: all cells of a pixel move to another pixel,
//!   each pixel to exactly one, silent ones too.
//!
//! Random numbers are a hash of the seed, the cell and the event's number in it.

use std::sync::Arc;

use rayon::{
    iter::{IntoParallelIterator, ParallelIterator},
    slice::ParallelSliceMut,
};

use super::{Cell, Pair, trains::Trains};
use crate::rng::{GOLDEN, Hash, mix};

/// Keys of the random numbers.
const REDRAW: u64 = 0x7265_6472_6177;
const PERMUTE: u64 = 0x7065_726D_7574_6521;

/// The redraw of a pair's reference, as the judged packet.
#[must_use]
pub fn redraw(pair: &Pair, seed: u64) -> Pair {
    let all = pair.reference();
    let root = Hash::new(seed).with_mixed(REDRAW);
    let cells: Vec<_> = pair.reference_cells().collect();
    let drawn: Vec<(Cell, Vec<u64>)> = cells
        .into_par_iter()
        .map(|(cell, own)| {
            let place = root.with_mixed(Hash::new(cell.word()).bits());
            let others = all.len() - own.len();
            let first = all.get(own.start).copied().unwrap_or(0);
            let last = all.get(own.end - 1).copied().unwrap_or(0);
            let mut times: Vec<u64> = (0..own.len() as u64)
                .map(|k| {
                    let word = place.nth(k).bits();
                    if others == 0 {
                        first + below(word, u128::from(last - first) + 1)
                    } else {
                        // The others lie after this cell, and on from the start.
                        let at = own.end + below(word, others as u128) as usize;
                        let at = if at < all.len() { at } else { at - all.len() };
                        all.get(at).copied().unwrap_or(first)
                    }
                })
                .collect();
            times.sort_unstable();
            (cell, times)
        })
        .collect();
    let mut trains = Trains::default();
    for (cell, times) in drawn {
        trains.push(cell, times);
    }
    pair.with_judged(Arc::new(trains))
}

/// The permutation of a pair's reference, as the judged packet.
#[must_use]
pub fn permute(pair: &Pair, seed: u64) -> Pair {
    let all = pair.reference();
    let pixels = Shuffle::new(pair, seed);
    let mut cells: Vec<_> = pair
        .reference_cells()
        .map(|(cell, own)| (pixels.moved(cell), own))
        .collect();
    cells.par_sort_unstable_by_key(|(cell, _)| *cell);
    let mut moved = Trains::default();
    for (cell, own) in cells {
        moved.push(cell, all.get(own).unwrap_or_default().iter().copied());
    }
    pair.with_judged(Arc::new(moved))
}

/// A number from 0 to `end - 1` by a random word; `end` is at most 2^64.
const fn below(word: u64, end: u128) -> u64 {
    ((word as u128 * end) >> 64) as u64
}

/// A permutation of all pixels that needs no table: a Feistel network over the next even power
/// of two, walked until it is back among the pixels (Black and Rogaway, CT-RSA 2002).
struct Shuffle {
    width: u64,
    pixels: u64,
    /// Half of the bits of a number.
    half: u32,
    root: u64,
}

impl Shuffle {
    fn new(pair: &Pair, seed: u64) -> Self {
        // Events have 16 bits for each coordinate.
        let side = |pixels: usize| (pixels as u64).clamp(1, 1 << 16);
        let (height, width) = (side(pair.size().height), side(pair.size().width));
        let pixels = height * width;
        let bits = u64::BITS - (pixels - 1).leading_zeros();
        Self {
            width,
            pixels,
            half: bits.div_ceil(2),
            root: Hash::new(seed).with_mixed(PERMUTE).bits(),
        }
    }

    fn moved(&self, cell: Cell) -> Cell {
        let mut pixel = u64::from(cell.y()) * self.width + u64::from(cell.x());
        loop {
            pixel = self.round_trip(pixel);
            if pixel < self.pixels {
                return cell.moved_to((pixel % self.width) as u16, (pixel / self.width) as u16);
            }
        }
    }

    const fn round_trip(&self, number: u64) -> u64 {
        let mask = (1 << self.half) - 1;
        let (mut left, mut right) = (number >> self.half, number & mask);
        let mut round = 1;
        while round <= 4 {
            let key = Hash::raw(self.root.wrapping_add(GOLDEN.wrapping_mul(round)));
            let word = key.with_mixed(mix(right)).bits();
            (left, right) = (right, left ^ word & mask);
            round += 1;
        }
        left << self.half | right
    }
}
