//! Pieces: some rows of a clip, all its pairs. A piece is one task of a thread, and its sums are taken
//! in one order, so that results do not depend on how many threads there are.

use std::ops::Range;

use crate::plane::Size;

/// Rows of a piece: few enough that a piece's cells stay in cache, enough to be worth a task.
const ROWS: usize = 32;

/// Which rows of which clip.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) clip: usize,
    pub(super) rows: Range<usize>,
}

impl Piece {
    /// All pieces of a batch, clip by clip and from the top down.
    pub(super) fn all(clips: usize, size: Size) -> Vec<Self> {
        let cut = |clip| {
            let tops = (0..size.height).step_by(ROWS);
            tops.map(move |top| Self {
                clip,
                rows: top..(top + ROWS).min(size.height),
            })
        };
        (0..clips).flat_map(cut).collect()
    }
}

/// Cuts an array of planes of `size`, `each` of them a clip, into the rows of its pieces:
/// `[piece][plane]`.
pub(super) fn split<T>(values: &mut [T], each: usize, size: Size) -> Vec<Vec<&mut [T]>> {
    let bands = size.height.div_ceil(ROWS);
    let clips = values.len() / (each * size.pixels()).max(1);
    let mut parts: Vec<Vec<&mut [T]>> = (0..clips * bands)
        .map(|_| Vec::with_capacity(each))
        .collect();
    for (n, plane) in values.chunks_mut(size.pixels()).enumerate() {
        let first = n / each * bands;
        let bands = parts[first..first + bands].iter_mut();
        for (part, rows) in bands.zip(plane.chunks_mut(ROWS * size.width)) {
            part.push(rows);
        }
    }
    parts
}
