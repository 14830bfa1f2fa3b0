//! Counts: the signed number of events of each cell in an interval.

use std::ops::Range;

use crate::{
    number::Real,
    plane::{Plane, Size},
    sensor::SensorError,
};

use super::{
    sinks::check_shape,
    train::{BandSink, Interval, Sink, TrainRow},
    voxel::split,
};

/// Signed event counts of each cell in the current interval; `[channel][y, x]`.
#[derive(Clone, Debug)]
pub struct Counts {
    planes: Vec<Plane<i32>>,
}

impl Counts {
    /// No events yet.
    #[must_use]
    pub fn new(size: Size, channels: usize) -> Self {
        Self {
            planes: vec![Plane::zeros(size.shape()); channels],
        }
    }

    /// The counts of the current interval, one plane for each channel.
    #[must_use]
    pub fn planes(&self) -> &[Plane<i32>] {
        &self.planes
    }
}

/// The rows that a band fills, for each channel.
#[derive(Debug)]
pub struct CountBand<'a> {
    top: usize,
    width: usize,
    rows: Vec<&'a mut [i32]>,
    /// The row and channel passed last; the same may come again.
    last: Option<(usize, usize)>,
}

impl Sink for Counts {
    type Band<'a> = CountBand<'a>;

    fn check(&self, size: Size, channels: usize) -> Result<(), SensorError> {
        let own = self.planes.first().map_or(size, Size::of);
        check_shape("counts", (own, self.planes.len()), (size, channels))
    }

    fn wants_times(&self) -> bool {
        false
    }

    fn begin(&mut self, _: Interval, bands: &[Range<usize>]) -> Vec<CountBand<'_>> {
        let width = self.planes.first().map_or(0, Plane::ncols);
        let parts = split(&mut self.planes, bands).into_iter().zip(bands);
        parts
            .map(|(rows, band)| CountBand {
                top: band.start,
                width,
                rows,
                last: None,
            })
            .collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        Ok(())
    }
}

impl BandSink for CountBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        let start = (row.y - self.top) * self.width;
        let to = &mut self.rows[row.channel][start..start + self.width];
        if self.last.replace((row.y, row.channel)) == Some((row.y, row.channel)) {
            for (to, count) in to.iter_mut().zip(&row.counts) {
                *to = to.saturating_add(*count);
            }
        } else {
            to.copy_from_slice(&row.counts);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_is_told_again_adds() {
        let mut counts = Counts::new(Size::new(1, 2), 2);
        let interval = Interval {
            index: 0,
            from: 0.0,
            to: 1.0,
        };
        for _ in 0..2 {
            let mut bands = counts.begin(interval, std::slice::from_ref(&(0..1)));
            for (channel, told) in [(0, [1, 2]), (0, [3, -5]), (1, [7, 0])] {
                let mut row = TrainRow::<f32>::new(2);
                row.channel = channel;
                row.counts = told.to_vec();
                bands[0].row(&row).unwrap();
            }
            drop(bands);
            counts.end().unwrap();
            let planes: Vec<_> = counts
                .planes()
                .iter()
                .map(|p| p.as_slice().unwrap().to_vec())
                .collect();
            assert_eq!(planes, [[4, -3], [7, 0]]);
        }
    }
}
