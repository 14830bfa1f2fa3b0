//! Binning: events into voxels, in closed form.
//!
//! Bins are centred on the frames. An event at `u` (0 at the earlier frame of its interval, 1 at
//! the later) gives `1 - u` to the earlier bin and `u` to the later, as in the paper's Eq. 5-8
//! (bilinear binning). A train of `N` events at `u_0 + i s` therefore gives, without a loop,
//!
//! ```text
//! later   = N u_0 + s N (N - 1) / 2
//! earlier = N - later
//! ```
//!
//! with the sign of its events. A share is computed in the precision of the train; voxels are
//! added up in double precision.
//!
//! Where a memory in few bits begins an interval beyond its next threshold, a train may end after the
//! later frame. Its events are then at that frame, as in the list ([`Train::at`]).

use std::ops::Range;

use multiversion::multiversion;

use crate::{
    aligned,
    number::Real,
    plane::{Plane, Size},
    sensor::SensorError,
};

use super::{
    sinks::check_shape,
    train::{BandSink, Interval, Sink, Train, TrainRow},
};

/// The two bins between which the current interval lies; `[channel][y, x]`.
#[derive(Clone, Debug)]
pub struct VoxelGrid {
    earlier: Vec<Plane<f64>>,
    later: Vec<Plane<f64>>,
    /// Whether the later bin still holds a bin that is over: it is overwritten, not added to.
    stale: bool,
}

impl VoxelGrid {
    /// Empty bins.
    #[must_use]
    pub fn new(size: Size, channels: usize) -> Self {
        let empty =
            |first| (0..channels).map(move |channel| aligned::zeros(first + 2 * channel, size));
        Self {
            earlier: empty(0).collect(),
            later: empty(1).collect(),
            stale: false,
        }
    }

    /// The bin of the earlier frame, which no later event can reach once the interval is over.
    #[must_use]
    pub fn earlier(&self) -> &[Plane<f64>] {
        &self.earlier
    }

    /// Moves on by one frame: the later bin becomes the earlier.
    pub fn advance(&mut self) {
        if self.stale {
            for plane in &mut self.later {
                plane.fill(0.0);
            }
        }
        std::mem::swap(&mut self.earlier, &mut self.later);
        self.stale = true;
    }
}

/// The shares of a train in the bins of the earlier and the later frame.
#[must_use]
pub fn bins(train: &Train) -> (f64, f64) {
    let n = train.count as f64;
    share_within(
        f64::from(train.polarity.sign()) * n,
        train.first,
        train.spacing,
    )
}

/// The closed form, with a signed count.
#[inline]
fn share<R: Real>(count: R, first: R, spacing: R) -> (R, R) {
    let later = count * first + spacing * (count * (count.abs() - R::ONE) * R::from_f64(0.5));
    (count - later, later)
}

/// The place of a train's last event.
#[inline]
fn last<R: Real>(count: R, first: R, spacing: R) -> R {
    first + spacing * (count.abs() - R::ONE)
}

/// Whether a train ends after the later frame. Less than a thousandth of the interval is rounding: in
/// single precision places are known to about so much.
#[inline]
fn is_beyond<R: Real>(last: R) -> bool {
    last > R::from_f64(1.001)
}

/// The same for a train that may end after the later frame: what lies beyond it is at it.
fn share_within<R: Real>(count: R, first: R, spacing: R) -> (R, R) {
    if is_beyond(last(count, first, spacing)) {
        // A dead time may leave only events beyond the frame, and no spacing.
        let within = if first < R::ONE {
            ((R::ONE - first) / spacing).floor() + R::ONE
        } else {
            R::ZERO
        };
        let (earlier, later) = share(within.mul_sign(count), first, spacing);
        (earlier, later + (count.abs() - within).mul_sign(count))
    } else {
        share(count, first, spacing)
    }
}

/// A band's rows of the two bins.
#[derive(Debug)]
pub struct VoxelBand<'a> {
    top: usize,
    width: usize,
    /// For each channel.
    earlier: Vec<&'a mut [f64]>,
    later: Vec<&'a mut [f64]>,
    stale: bool,
    /// The row and channel passed last; the same may come again.
    last: Option<(usize, usize)>,
}

impl Sink for VoxelGrid {
    type Band<'a> = VoxelBand<'a>;

    fn check(&self, size: Size, channels: usize) -> Result<(), SensorError> {
        let own = self.earlier.first().map_or(size, Size::of);
        check_shape("voxels", (own, self.earlier.len()), (size, channels))
    }

    fn wants_times(&self) -> bool {
        true
    }

    fn begin(&mut self, _: Interval, bands: &[Range<usize>]) -> Vec<VoxelBand<'_>> {
        let width = self.earlier.first().map_or(0, Plane::ncols);
        let earlier = split(&mut self.earlier, bands);
        let later = split(&mut self.later, bands);
        let parts = earlier.into_iter().zip(later).zip(bands);
        parts
            .map(|((earlier, later), rows)| VoxelBand {
                top: rows.start,
                width,
                earlier,
                later,
                stale: self.stale,
                last: None,
            })
            .collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        self.stale = false;
        Ok(())
    }
}

impl BandSink for VoxelBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        let start = (row.y - self.top) * self.width;
        let earlier = &mut self.earlier[row.channel][start..start + self.width];
        let later = &mut self.later[row.channel][start..start + self.width];
        let again = self.last.replace((row.y, row.channel)) == Some((row.y, row.channel));
        if self.stale && !again {
            share_out::<R, true>(row.parts(), earlier, later);
        } else {
            share_out::<R, false>(row.parts(), earlier, later);
        }
        Ok(())
    }
}

/// Adds the shares of a row to its two bins, or with `FRESH` overwrites the later one.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn share_out<R: Real, const FRESH: bool>(
    (counts, first, spacing): (&[i32], &[R], &[R]),
    earlier: &mut [f64],
    later: &mut [f64],
) {
    if end_beyond(counts, first, spacing) {
        let trains = counts.iter().zip(first.iter().zip(spacing));
        let bins = earlier.iter_mut().zip(later);
        for ((&count, (&first, &spacing)), (earlier, later)) in trains.zip(bins) {
            let (e, l) = given(count, first, spacing, share_within);
            *earlier += e.to_f64();
            put::<FRESH>(later, l.to_f64());
        }
        return;
    }
    // First in the precision of the trains, of which more fit in a vector.
    let narrow = size_of::<R>() < size_of::<f64>();
    let whole = if narrow {
        counts.len() / BLOCK * BLOCK
    } else {
        0
    };
    let (counts, last_counts) = counts.split_at(whole);
    let (first, last_first) = first.split_at(whole);
    let (spacing, last_spacing) = spacing.split_at(whole);
    let (earlier, last_earlier) = earlier.split_at_mut(whole);
    let (later, last_later) = later.split_at_mut(whole);
    let (counts, first) = (counts.as_chunks().0, first.as_chunks().0);
    let trains = counts.iter().zip(first).zip(spacing.as_chunks().0);
    let (earlier, later) = (earlier.as_chunks_mut().0, later.as_chunks_mut().0);
    for (((counts, first), spacing), (earlier, later)) in trains.zip(earlier.iter_mut().zip(later))
    {
        share_out_block::<R, FRESH>((counts, first, spacing), earlier, later);
    }
    let trains = last_counts.iter().zip(last_first.iter().zip(last_spacing));
    let bins = last_earlier.iter_mut().zip(last_later);
    for ((&count, (&first, &spacing)), (earlier, later)) in trains.zip(bins) {
        let (e, l) = given(count, first, spacing, share);
        *earlier += e.to_f64();
        put::<FRESH>(later, l.to_f64());
    }
}

/// Whether any train of a row ends after the later frame.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn end_beyond<R: Real>(counts: &[i32], first: &[R], spacing: &[R]) -> bool {
    let mut most = R::ZERO;
    for (&count, (&first, &spacing)) in counts.iter().zip(first.iter().zip(spacing)) {
        most = most.max_nonnegative(given(count, first, spacing, last));
    }
    is_beyond(most)
}

/// The same for a block of columns.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn share_out_block<R: Real, const FRESH: bool>(
    (counts, first, spacing): (&[i32; BLOCK], &[R; BLOCK], &[R; BLOCK]),
    earlier: &mut [f64; BLOCK],
    later: &mut [f64; BLOCK],
) {
    let mut shares = ([R::ZERO; BLOCK], [R::ZERO; BLOCK]);
    for x in 0..BLOCK {
        (shares.0[x], shares.1[x]) = given(counts[x], first[x], spacing[x], share);
    }
    for (earlier, e) in earlier.iter_mut().zip(&shares.0) {
        *earlier += e.to_f64();
    }
    for (later, l) in later.iter_mut().zip(&shares.1) {
        put::<FRESH>(later, l.to_f64());
    }
}

/// What `of` makes of a train; place and spacing are 0 without one, where they may be anything.
#[inline]
fn given<R: Real, T>(count: i32, first: R, spacing: R, of: impl Fn(R, R, R) -> T) -> T {
    let given = |what| if count == 0 { R::ZERO } else { what };
    of(R::from_i32(count), given(first), given(spacing))
}

/// Adds to a bin, or writes it.
#[inline]
fn put<const FRESH: bool>(bin: &mut f64, share: f64) {
    *bin = if FRESH { share } else { *bin + share };
}

/// Trains of a block.
const BLOCK: usize = 64;

/// Cuts planes into bands of rows: `[band][channel]`.
pub(super) fn split<'a, T>(
    planes: &'a mut [Plane<T>],
    bands: &[Range<usize>],
) -> Vec<Vec<&'a mut [T]>> {
    let mut parts: Vec<Vec<&mut [T]>> = bands.iter().map(|_| Vec::new()).collect();
    for plane in planes {
        let width = plane.ncols();
        let mut rest = plane
            .as_slice_mut()
            .expect("planes of the reference are contiguous");
        for (part, rows) in parts.iter_mut().zip(bands) {
            let (band, below) = rest.split_at_mut(rows.len() * width);
            part.push(band);
            rest = below;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::Polarity;
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: event by event. A train may end after the later frame, or begin there.
        #[test]
        fn closed_form_is_the_sum_over_events(count in 1u64..500, first in 0.0f64..1.5, room in 0.0f64..2.0, on: bool) {
            let spacing = room * (1.25 - first).max(0.0) / count as f64;
            let polarity = Polarity::of(on);
            let train = Train { polarity, count, first, spacing };
            let (mut earlier, mut later) = (0.0, 0.0);
            for i in 0..count {
                let u = train.at(i);
                earlier += f64::from(polarity.sign()) * (1.0 - u);
                later += f64::from(polarity.sign()) * u;
            }
            let (e, l) = bins(&train);
            let last = first + spacing * (count - 1) as f64;
            let is_rounding = last > 1.0 && !is_beyond(last);
            let most = if is_rounding { 1e-3 } else { 1e-9 } * count as f64;
            prop_assert!((e - earlier).abs() < most);
            prop_assert!((l - later).abs() < most);
        }

        /// In single precision a share is rounded as such, and then added in double; whatever
        /// the width.
        #[test]
        fn single_precision_is_widened(trains in proptest::collection::vec((-3i32..4, 0f32..0.4, 0f32..0.3), 1..200), fresh: bool, beyond: bool) {
            let mut trains = trains;
            let width = trains.len();
            if beyond {
                // One that ends after the later frame.
                trains[width / 2] = (3, 0.9, 0.3);
            }
            let (counts, first, spacing): (Vec<_>, Vec<_>, Vec<_>) = trains.iter().copied().collect();
            let mut bins = (vec![0.5; width], vec![0.25; width]);
            if fresh {
                share_out::<f32, true>((&counts, &first, &spacing), &mut bins.0, &mut bins.1);
            } else {
                share_out::<f32, false>((&counts, &first, &spacing), &mut bins.0, &mut bins.1);
            }
            for (x, &(count, first, spacing)) in trains.iter().enumerate() {
                let (e, l) = share_within(count as f32, first, spacing);
                prop_assert_eq!(bins.0[x], 0.5 + f64::from(e));
                let before = if fresh { 0.0 } else { 0.25 };
                prop_assert_eq!(bins.1[x], before + f64::from(l));
            }
        }
    }

    /// Rows told once, twice or not at all, and bins that are passed over: as if every train
    /// were added on its own.
    #[test]
    fn bins_pass_from_pair_to_pair() {
        let size = Size::new(2, 3);
        let mut grid = VoxelGrid::new(size, 1);
        let mut slow = vec![Plane::<f64>::zeros(size.shape()); 6];
        // For each pair, the rows that are told, and the first count of each.
        let told: [&[(usize, i32)]; 4] = [
            &[(0, 2), (1, -1)],
            &[(0, 3), (0, 1), (1, 5)],
            &[],
            &[(1, 1)],
        ];
        for (n, rows) in told.into_iter().enumerate() {
            let interval = Interval {
                index: n as u64,
                from: n as f64,
                to: n as f64 + 1.0,
            };
            let mut bands = grid.begin(interval, std::slice::from_ref(&(0..2)));
            // Every row is told in every pair.
            for y in 0..2 {
                let mut counts: Vec<i32> = rows.iter().filter(|r| r.0 == y).map(|r| r.1).collect();
                if counts.is_empty() {
                    counts.push(0);
                }
                for count in counts {
                    let row = TrainRow::<f64> {
                        channel: 0,
                        y,
                        counts: vec![count, 0, -count],
                        first: vec![0.25, f64::NAN, 0.5],
                        spacing: vec![0.125; 3],
                    };
                    for (x, train) in row.trains() {
                        let (e, l) = bins(&train);
                        slow[n][[y, x]] += e;
                        slow[n + 1][[y, x]] += l;
                    }
                    bands[0].row(&row).unwrap();
                }
            }
            drop(bands);
            grid.end().unwrap();
            assert_eq!(grid.earlier()[0], slow[n]);
            grid.advance();
        }
        assert_eq!(grid.earlier()[0], slow[4]);
        grid.advance();
        assert_eq!(grid.earlier()[0], slow[5]);
    }
}
