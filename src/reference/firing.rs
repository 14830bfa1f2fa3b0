//! Firing: how many cells fire in an interval.

use std::ops::Range;

use multiversion::multiversion;

use crate::{number::Real, sensor::SensorError};

use super::train::{BandSink, Interval, Sink, TrainRow};

/// How many cells have fired in the interval that was told last.
#[derive(Clone, Debug, Default)]
pub struct Firing {
    cells: u64,
    bands: Vec<FiringBand>,
}

/// The cells of a band of rows.
#[derive(Clone, Debug, Default)]
pub struct FiringBand {
    cells: u64,
    /// The events of the row told last: it may be told again.
    row: Vec<i32>,
    last: Option<(usize, usize)>,
}

impl Firing {
    /// Nobody has fired yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Cells, of all kinds, that have fired in the interval that was told last.
    #[must_use]
    pub const fn cells(&self) -> u64 {
        self.cells
    }
}

impl Sink for Firing {
    type Band<'a> = &'a mut FiringBand;

    fn wants_times(&self) -> bool {
        false
    }

    fn begin(&mut self, _: Interval, bands: &[Range<usize>]) -> Vec<&mut FiringBand> {
        self.bands = vec![FiringBand::default(); bands.len()];
        self.bands.iter_mut().collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        self.cells = self.bands.iter().map(|band| band.cells).sum();
        Ok(())
    }
}

impl BandSink for &mut FiringBand {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        if self.last.replace((row.y, row.channel)) == Some((row.y, row.channel)) {
            for (fired, count) in self.row.iter_mut().zip(&row.counts) {
                self.cells += u64::from(*count != 0 && *fired == 0);
                *fired |= count;
            }
        } else {
            self.row.clear();
            self.row.extend_from_slice(&row.counts);
            self.cells += firing(&row.counts);
        }
        Ok(())
    }
}

/// How many are not 0.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn firing(counts: &[i32]) -> u64 {
    let mut all = 0;
    for block in counts.chunks(1 << 12) {
        let mut few = 0u32;
        for &count in block {
            few += u32::from(count != 0);
        }
        all += u64::from(few);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_told_twice_is_one() {
        let mut firing = Firing::new();
        let interval = Interval {
            index: 0,
            from: 0.0,
            to: 1.0,
        };
        let mut row = TrainRow::<f64>::new(4);
        for mut band in firing.begin(interval, &[0..1, 1..2]) {
            row.counts = vec![3, 0, -1, 0];
            band.row(&row).unwrap();
            row.counts = vec![1, 1, 0, 0];
            band.row(&row).unwrap();
        }
        firing.end().unwrap();
        assert_eq!(firing.cells(), 6);
    }
}
