//! Levels: where much changes between few of them.
//!
//! Rounding decides an event where a change equals the threshold to the last digit. In light of many
//! levels that is so by chance, and everywhere alike; in drawn content (text, an overlay) it is so
//! in one place and nowhere else, and a sample of tiles may miss the place.

use super::value::Value;
use crate::{plane::Size, rng::Hash};

/// Pixels along a side of a square that is looked at by itself; small, so that some lie in a place of
/// few levels as a whole.
const SIDE: usize = 4;

/// How much is looked at, about: so many pixels of all frames together. Frames are left out.
const LOOKED_AT: usize = 1 << 20;

/// What was seen in each square.
pub(super) struct Levels {
    size: Size,
    /// One frame in so many is looked at.
    skip: u64,
    squares: Vec<Square>,
}

#[derive(Clone, Copy, Default)]
struct Square {
    /// How much its light changes.
    change: f64,
    /// Which of 256 levels it had where it changed.
    levels: [u64; 4],
}

impl Levels {
    /// Of a sensor that is shown so many frames.
    pub(super) fn new(size: Size, frames: usize) -> Self {
        let squares = size.width.div_ceil(SIDE) * size.height.div_ceil(SIDE);
        Self {
            size,
            skip: (size.pixels() * frames / LOOKED_AT).max(1) as u64,
            squares: vec![Square::default(); squares],
        }
    }

    /// Looks at frame `n`, and at what it was before.
    pub(super) fn see<T: Value>(&mut self, n: usize, before: &[T], now: &[T]) {
        // By chance, so that nothing that comes again and again falls between them.
        if !Hash::new(n as u64).bits().is_multiple_of(self.skip) {
            return;
        }
        let width = self.size.width;
        let across = width.div_ceil(SIDE);
        let rows = before.chunks(width).zip(now.chunks(width)).enumerate();
        for (y, (a, b)) in rows.filter(|(_, (a, b))| a != b) {
            let squares = &mut self.squares[y / SIDE * across..];
            let parts = a.chunks(SIDE).zip(b.chunks(SIDE));
            for ((a, b), square) in parts.zip(squares) {
                for (a, b) in a.iter().zip(b).filter(|(a, b)| a != b) {
                    square.change += (b.light() - a.light()).abs();
                    let bucket = b.bucket();
                    square.levels[usize::from(bucket >> 6)] |= 1 << (bucket & 63);
                }
            }
        }
    }

    /// A pixel of the square in which most changes for each level that it has; none where nothing
    /// changes.
    pub(super) fn fewest(&self) -> Option<usize> {
        let each = |square: &Square| {
            let levels: u32 = square.levels.iter().map(|part| part.count_ones()).sum();
            square.change / f64::from(levels.max(1))
        };
        let changing = self
            .squares
            .iter()
            .enumerate()
            .filter(|(_, s)| s.change > 0.0);
        let (square, _) = changing.max_by(|(_, a), (_, b)| each(a).total_cmp(&each(b)))?;
        let across = self.size.width.div_ceil(SIDE);
        Some(square / across * SIDE * self.size.width + square % across * SIDE)
    }
}
