//! The real chip's arithmetic: every store errs a little, as `isa/errors.rs` has it.
//!
//! - Mismatch belongs to one cell of one pixel and never changes; noise is drawn anew for every
//!   word. Both are hashes of the seed and the place.
//! - All numbers are the device's, each with its source: `[figure.error]` of `device.toml`.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use super::{Ageing, Domain, Layout, Place, RowOps, Share, each::has_wide_vectors};
use crate::{
    isa::{self, Digital, Errors, StoreTerms},
    plane::At,
    rng::row::{Draws, hash, normal},
};

/// Kinds of chance.
const GAIN: u64 = 0;
const OFFSET: u64 = 1;
const SPLIT: u64 = 2;
const NOISE: u64 = 3;
const RETENTION: u64 = 4;

/// A split of a pixel's bus, of which it has many.
fn split_of(errors: &Errors, seed: u64, number: u8, pixel: u64) -> f32 {
    let drawn = normal(hash(seed, SPLIT, number, 0, pixel));
    (errors.division_mismatch * f64::from(drawn)) as f32
}

/// Where the pixels of an array lie on the chip: parts of it, equally wide, side by side.
#[derive(Clone, Debug, PartialEq)]
struct ChipPosition {
    /// The upper left pixel of each part.
    corners: Vec<At>,
    /// Columns of a part.
    across: usize,
    /// Columns of the chip.
    columns: usize,
    /// Columns of the array.
    width: usize,
}

impl ChipPosition {
    /// The number on the chip of a pixel of the array.
    #[inline]
    fn pixel(&self, y: usize, x: usize) -> usize {
        let At { y: down, x: right } = self.corners[x / self.across];
        (y + down) * self.columns + x % self.across + right
    }

    /// Whether its rows are the chip's, one after the other.
    #[inline]
    const fn is_whole_rows(&self) -> bool {
        self.corners.len() == 1 && self.width == self.columns
    }
}

/// One chip: its errors, and the mismatch of each of its cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Silicon {
    errors: Errors,
    seed: u64,
    /// Where the array lies.
    position: ChipPosition,
    /// `-(1 - loss + mismatch)` and `Δ + mismatch` of every cell, by register, row by row.
    gain: Vec<Vec<f32>>,
    offset: Vec<Vec<f32>>,
    /// The first two splits of every pixel. Those of buses to more than three targets, which are
    /// rare, are drawn where they are wanted.
    split: [Vec<f32>; 2],
}

impl Silicon {
    /// The chip of this seed.
    #[must_use]
    pub fn new(errors: Errors, seed: u64, layout: &Layout) -> Self {
        let whole = [At { y: 0, x: 0 }];
        Self::parts(errors, seed, layout, &whole, layout.size.width)
    }

    /// Parts of the chip of this seed, which has so many columns: equally wide arrays side by side
    /// as one, each with its upper left pixel at one of these places of the chip, and with the
    /// errors that its pixels have there.
    ///
    /// # Panics
    /// Without a part.
    #[must_use]
    pub fn parts(
        errors: Errors,
        seed: u64,
        layout: &Layout,
        corners: &[At],
        columns: usize,
    ) -> Self {
        let width = layout.size.width;
        let position = ChipPosition {
            across: width.div_ceil(corners.len()).max(1),
            corners: corners.to_vec(),
            columns,
            width,
        };
        let pixel = |y, x| position.pixel(y, x) as u64;
        let numbers = || {
            let rows = 0..layout.size.height;
            rows.flat_map(|y| (0..width).map(move |x| pixel(y, x)))
        };
        let draw = |kind, register, pixel| f64::from(normal(hash(seed, kind, register, 0, pixel)));
        let planes = |value: &dyn Fn(u8, u64) -> f64| -> Vec<Vec<f32>> {
            (0..layout.analog)
                .map(|register| numbers().map(|p| value(register, p) as f32).collect())
                .collect()
        };
        let split = |number: u8| {
            numbers()
                .map(|pixel| split_of(&errors, seed, number, pixel))
                .collect()
        };
        Self {
            gain: planes(&|register, pixel| errors.gain(draw(GAIN, register, pixel))),
            offset: planes(&|register, pixel| {
                errors.offset(draw(GAIN, register, pixel), draw(OFFSET, register, pixel))
            }),
            split: [split(0), split(1)],
            errors,
            seed,
            position,
        }
    }

    /// What it errs by.
    #[must_use]
    pub const fn errors(&self) -> &Errors {
        &self.errors
    }

    #[inline]
    fn saturated(&self, value: f32) -> f32 {
        value.clamp(self.errors.range.0 as f32, self.errors.range.1 as f32)
    }

    #[inline]
    fn pixel(&self, place: Place) -> usize {
        place.y * self.position.width + place.x
    }

    /// What splits behind the first two, each so often, add in a cell of the array.
    fn others(&self, splits: &[(u8, f32)], cell: usize) -> f32 {
        let (y, x) = (cell / self.position.width, cell % self.position.width);
        let pixel = self.position.pixel(y, x) as u64;
        let each = splits
            .iter()
            .map(|(number, times)| times * split_of(&self.errors, self.seed, *number, pixel));
        each.sum()
    }

    /// Cells beside each other, from `place` on.
    #[inline]
    fn run(&self, share: Share, place: Place, cells: usize) -> Run<'_> {
        let StoreTerms {
            division,
            noise,
            // In the planes.
            transfer: _,
            loss: _,
            gain_mismatch: _,
            offset_mismatch: _,
            mismatch_correlation: _,
            division_mismatch: _,
        } = self.errors.of_a_store();
        let (first, register) = (self.pixel(place), usize::from(place.register.0));
        let targets = share.by as usize;
        let uneven = |part: u8, split| isa::uneven(part.into(), targets, split);
        Run {
            first,
            position: &self.position,
            by: share.by as f32,
            gain: &self.gain[register][first..][..cells],
            offset: &self.offset[register][first..][..cells],
            split: self.split.each_ref().map(|split| &split[first..][..cells]),
            more: (share.part).map(|part| [0, 1].map(|split| uneven(part, split))),
            others: match share.part {
                Some(part) if targets > 3 => {
                    let splits = 2..targets - 1;
                    let splits: Vec<_> = splits.map(|it| (it as u8, uneven(part, it))).collect();
                    let cells = first..first + cells;
                    cells.map(|cell| self.others(&splits, cell)).collect()
                }
                _ => Vec::new(),
            },
            division: division as f32,
            draws: Draws::new(self.seed, NOISE, place.register.0, place.step),
            noise: noise as f32,
            range: (self.errors.range.0 as f32, self.errors.range.1 as f32),
        }
    }
}

/// What all cells of a run have in common, and what is each one's own.
struct Run<'a> {
    /// The number of the first cell in the array; rows follow each other.
    first: usize,
    position: &'a ChipPosition,
    by: f32,
    gain: &'a [f32],
    offset: &'a [f32],
    split: [&'a [f32]; 2],
    /// How much more than its share a cell gets of a bus that splits: so often these two.
    more: Option<[f32; 2]>,
    /// What further splits add to that in each cell; nothing where there are none.
    others: Vec<f32>,
    division: f32,
    draws: Draws,
    noise: f32,
    range: (f32, f32),
}

/// Cells of a row that are worked on at once.
const BLOCK: usize = 256;

/// Stores the bus of each cell. A cell costs so many instructions that the call does not matter.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
fn store_run(run: &Run<'_>, operands: &[&[f32]], cells: &mut [f32]) {
    let wide = has_wide_vectors!();
    let n = cells.len();
    match *operands {
        [a] if wide => {
            let a = &a[..n];
            run.store::<BLOCK>(|i, _| 0.0 + a[i], cells);
        }
        [a, b] if wide => {
            let (a, b) = (&a[..n], &b[..n]);
            run.store::<BLOCK>(|i, _| 0.0 + a[i] + b[i], cells);
        }
        [a, b, c] if wide => {
            let (a, b, c) = (&a[..n], &b[..n], &c[..n]);
            run.store::<BLOCK>(|i, _| 0.0 + a[i] + b[i] + c[i], cells);
        }
        _ => {
            cells.fill(0.0);
            for operand in operands {
                for (sum, operand) in cells.iter_mut().zip(&operand[..n]) {
                    *sum += operand;
                }
            }
            run.store::<BLOCK>(|_, sum| sum, cells);
        }
    }
}

impl Run<'_> {
    /// The error of a cell, from its offset and its chance.
    #[inline(always)]
    fn error(&self, offset: f32, drawn: u32) -> f32 {
        offset + self.noise * Draws::normal(drawn)
    }

    /// Draws for cells beside each other, from that number of the run on.
    #[inline(always)]
    fn draw(&self, from: usize, drawn: &mut [u32]) {
        let (mut at, position) = (self.first + from, self.position);
        let ChipPosition { across, width, .. } = *position;
        if position.is_whole_rows() {
            let first = position.corners[0].y * width;
            return self.draws.draw((first + at) as u32, drawn);
        }
        // On the chip the next row and the next part do not follow.
        let mut rest = drawn;
        while !rest.is_empty() {
            let (y, x) = (at / width, at % width);
            let left = (across - x % across).min(width - x);
            let (row, more) = rest.split_at_mut(left.min(rest.len()));
            self.draws.draw(position.pixel(y, x) as u32, row);
            at += row.len();
            rest = more;
        }
    }

    /// Stores what is on the bus of each cell, so many cells at once: `sum`, of its number and
    /// what it holds.
    #[inline(always)]
    fn store<const BLOCK: usize>(&self, sum: impl Fn(usize, f32) -> f32, cells: &mut [f32]) {
        if let Some([one, two]) = self.more {
            let [first, second] = self.split;
            if self.others.is_empty() {
                self.each::<BLOCK>(cells, |i, held, error| {
                    self.parted(i, sum(i, held), error, one * first[i] + two * second[i])
                });
            } else {
                self.each::<BLOCK>(cells, |i, held, error| {
                    let more = one * first[i] + two * second[i] + self.others[i];
                    self.parted(i, sum(i, held), error, more)
                });
            }
        } else {
            self.each::<BLOCK>(cells, |i, held, error| {
                isa::stored(sum(i, held) / self.by, self.gain[i], error)
            });
        }
    }

    /// What a cell gets of a bus that splits: so much more than its share of the sum.
    #[inline(always)]
    fn parted(&self, i: usize, sum: f32, error: f32, more: f32) -> f32 {
        let current = isa::split(sum / self.by, more);
        isa::stored(current, self.gain[i], error + self.division)
    }

    /// Each cell, from its number, what it holds and its error; limited to the range.
    #[inline(always)]
    fn each<const BLOCK: usize>(&self, cells: &mut [f32], value: impl Fn(usize, f32, f32) -> f32) {
        // What makes a normal number of 0.
        let mut drawn = [1020; BLOCK];
        for (k, cells) in cells.chunks_mut(BLOCK).enumerate() {
            let from = k * BLOCK;
            let drawn = &mut drawn[..cells.len()];
            if self.noise != 0.0 {
                self.draw(from, drawn);
            }
            for (j, cell) in cells.iter_mut().enumerate() {
                let error = self.error(self.offset[from + j], drawn[j]);
                *cell = value(from + j, *cell, error).clamp(self.range.0, self.range.1);
            }
        }
    }
}

impl Domain for Silicon {
    type Cell = f32;
    type Sum = f32;

    fn name(&self) -> String {
        "silicon".into()
    }

    fn hold(&self, value: f64) -> f32 {
        value as f32
    }

    /// The converter steps. The host's table is calibrated; raw codes are not.
    fn input(&self, value: f64, calibrated: bool) -> f32 {
        let held = self.errors.held(value);
        if calibrated {
            self.errors.calibrated(held) as f32
        } else {
            held as f32
        }
    }

    fn value(&self, cell: &f32) -> f64 {
        f64::from(*cell)
    }

    #[inline]
    fn nothing(&self) -> f32 {
        0.0
    }

    #[inline]
    fn add(&self, sum: &mut f32, cell: &f32, times: i32) {
        *sum += cell * times as f32;
    }

    #[inline]
    fn join(&self, sum: &mut f32, other: &f32) {
        *sum += other;
    }

    #[inline]
    fn store(&self, sum: &f32, share: Share, place: Place) -> f32 {
        let mut cell = [0.0];
        self.run(share, place, 1).store::<1>(|_, _| *sum, &mut cell);
        cell[0]
    }

    /// The squarer has no calibration; only the transfer error of its store is modelled.
    fn square(&self, sum: &f32, gain: f64, place: Place) -> Option<f32> {
        let run = self.run(Share::new(1, 0), place, 1);
        let mut drawn = [0];
        run.draw(0, &mut drawn);
        let error = run.error(run.offset[0], drawn[0]);
        Some(self.saturated(sum * sum * gain as f32 + error))
    }

    #[inline]
    fn positive(&self, sum: &f32) -> Option<bool> {
        Some(*sum > 0.0)
    }

    #[inline(always)]
    fn limit(&self, cell: f32, (low, high): (f64, f64)) -> f32 {
        cell.clamp(low as f32, high as f32)
    }
}

impl Ageing for Silicon {
    fn aged(&self, cell: &f32, seconds: f64) -> Option<f32> {
        if self.errors.decay == 0.0 {
            return None;
        }
        let (level, way) = (self.errors.reset_level, self.errors.decay * seconds);
        let above = f64::from(*cell) - level;
        Some((level + above.signum() * (above.abs() - way).max(0.0)) as f32)
    }

    fn retention(&self) -> Option<f64> {
        Some(self.errors.retention)
    }

    fn holds(&self, register: Digital, pixel: usize, seconds: f64) -> bool {
        let ChipPosition { width, .. } = self.position;
        let pixel = self.position.pixel(pixel / width, pixel % width);
        let draw = normal(hash(self.seed, RETENTION, register.0, 0, pixel as u64));
        let longer = self.errors.retention_spread * f64::from(draw.abs());
        seconds <= self.errors.retention * (1.0 + longer)
    }
}

impl RowOps for Silicon {
    fn is_steady(&self) -> bool {
        false
    }

    fn store_row(&self, operands: &[&[f32]], share: Share, place: Place, cells: &mut [f32]) {
        store_run(&self.run(share, place, cells.len()), operands, cells);
    }

    #[inline(always)]
    fn choose(&self, old: &f32, new: &f32, take: u8) -> f32 {
        super::Single.choose(old, new, take)
    }

    #[inline(always)]
    fn positives(&self, operands: &[&[f32]], bytes: &mut [u8]) -> bool {
        super::Single.positives(operands, bytes)
    }
}
