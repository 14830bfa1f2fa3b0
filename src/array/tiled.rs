//! Bands of rows that go through many words while they are in the cache.
//!
//! ```text
//!            rows ─►                       word i works on rows [b·R - s, (b+1)·R - s), where
//!   word 0   ▐ band 0 ▐ band 1 ▐ band 2    s grows by the reach of a word, before and after
//!   word 1   ▐ band 0▐ band 1 ▐ band 2     it: what a word reads has been written by the words
//!   word 2   ▐ band 0▐ band 1 ▐ band 2     before it, and by none after it.
//!   word 3   ▐band 0 ▐ band 1▐ band 2
//! ```
//!
//! Each thread has rows of its own. Where they meet, both keep away by `s` from the seam, and
//! what is left open there is done when all have ended:
//!
//! ```text
//!   word 0   ▐ thread 0        ▌s▐        thread 1 ▐
//!   word 1   ▐ thread 0      ▌ seam ▐     thread 1 ▐
//! ```

use std::ops::Range;

use rayon::prelude::*;

use super::{
    Domain, State, Undecided,
    band::{Band, Constants, Copies},
    rows::Link,
    segment::Piece,
    semantics::Array,
};
use crate::plane::Size;

/// Bands move up by so many rows at most: what is behind them leaves the cache.
const FARTHEST: usize = 16;

/// Bytes of a register in one band, so that all registers fit into a core's larger cache.
const BAND: usize = 16384;

/// The rows of a band.
pub(super) fn rows(size: Size, cell: usize) -> usize {
    (BAND / (size.width * cell)).max(1)
}

/// A number of pieces, and how far the bands have moved up at each.
pub(super) struct Walk<'a, 'b> {
    pieces: &'b [Piece<'a>],
    shifts: Vec<usize>,
    /// Words of chains, and for each piece that begins one, how many pieces and which words.
    links: Vec<Link>,
    chains: Vec<Option<(usize, Range<usize>)>>,
    rows: usize,
}

impl<'a, 'b> Walk<'a, 'b> {
    /// As many of the pieces as can go together, in bands of so many rows.
    pub(super) fn new(pieces: &'b [Piece<'a>], rows: usize) -> Self {
        let mut shifts: Vec<usize> = Vec::with_capacity(pieces.len());
        let mut before = 0;
        for piece in pieces {
            let reach = piece.reach();
            let shift = shifts.last().map_or(reach, |last| last + reach.max(before));
            if shift > FARTHEST && !shifts.is_empty() {
                break;
            }
            shifts.push(shift);
            before = reach;
        }
        let pieces = &pieces[..shifts.len()];
        let (mut links, mut chains) = (Vec::new(), vec![None; pieces.len()]);
        let mut first = 0;
        while first < pieces.len() {
            let begin = links.len();
            let mut end = first;
            while end < pieces.len() && shifts[end] == shifts[first] && pieces[end].link(&mut links)
            {
                end += 1;
            }
            if end > first {
                chains[first] = Some((end - first, begin..links.len()));
            }
            first = end.max(first + 1);
        }
        Self {
            pieces,
            shifts,
            links,
            chains,
            rows,
        }
    }

    /// How many they are.
    pub(super) const fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Runs them on the whole array.
    pub(super) fn run<D: Domain>(
        &self,
        array: Array<'_, D>,
        threads: usize,
        state: &mut State<D::Cell>,
        copies: &mut Copies<D::Cell>,
        constants: &Constants<D::Cell>,
    ) -> Result<(), (u32, Undecided)> {
        let height = state.layout.size.height;
        let farthest = self.shifts.last().copied().unwrap_or(0);
        let parts = threads.min(height / (2 * farthest + self.rows)).max(1);
        let mut band = Band::whole(state, copies, constants);
        if parts == 1 {
            return self.part(array, &mut band, 0..height);
        }
        let seams: Vec<usize> = (1..parts).map(|part| part * height / parts).collect();
        let mut bands = Vec::with_capacity(parts);
        for seam in &seams {
            let (above, below) = band.split(*seam);
            bands.push(above);
            band = below;
        }
        bands.push(band);
        bands.into_par_iter().try_for_each(|mut band| {
            let rows = band.rows.clone();
            self.part(array, &mut band, rows)
        })?;
        let mut band = Band::whole(state, copies, constants);
        for seam in seams {
            for (piece, shift) in self.pieces.iter().zip(&self.shifts) {
                piece.run(array, &mut band, seam - shift..seam + shift)?;
            }
        }
        Ok(())
    }

    /// One thread's rows, band after band.
    fn part<D: Domain>(
        &self,
        array: Array<'_, D>,
        band: &mut Band<'_, D::Cell>,
        part: Range<usize>,
    ) -> Result<(), (u32, Undecided)> {
        let height = band.layout.size.height;
        let mut top = part.start;
        while top < part.end {
            let bottom = top + self.rows;
            let mut k = 0;
            while k < self.pieces.len() {
                let shift = &self.shifts[k];
                let from = if top == part.start {
                    top
                } else {
                    top.saturating_sub(*shift)
                };
                let to = if bottom >= part.end {
                    part.end
                } else {
                    bottom.saturating_sub(*shift)
                };
                // Away from the seams; the array's own borders are none.
                let first = part.start + if part.start == 0 { 0 } else { *shift };
                let last = part.end - if part.end == height { 0 } else { *shift };
                let rows = from.max(first)..to.min(last);
                let (pieces, links) = self.chains[k].clone().unwrap_or((1, 0..0));
                let links = &self.links[links];
                let chained =
                    !links.is_empty() && !rows.is_empty() && array.chain(band, links, rows.clone());
                if rows.is_empty() || chained {
                    k += pieces;
                    continue;
                }
                for piece in &self.pieces[k..k + pieces] {
                    piece.run(array, band, rows.clone())?;
                }
                k += pieces;
            }
            top = bottom;
        }
        Ok(())
    }
}
