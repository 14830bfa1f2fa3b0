//! Tally: the total number of events of each kind and sign.

use std::ops::Range;

use multiversion::multiversion;

use crate::{number::Real, plane::Size, sensor::SensorError};

use super::{
    sinks::check_shape,
    train::{BandSink, Interval, Sink, TrainRow},
};

/// Events of each channel, `(on, off)`, over all intervals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tally {
    kinds: Vec<(u64, u64)>,
    bands: Vec<Vec<(u64, u64)>>,
}

/// The part of a tally that a band of rows adds to.
#[derive(Debug)]
pub struct TallyBand<'a>(&'a mut Vec<(u64, u64)>);

impl Tally {
    /// No events yet.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            kinds: vec![(0, 0); channels],
            bands: Vec::new(),
        }
    }

    /// ON and OFF events of each channel.
    #[must_use]
    pub fn kinds(&self) -> &[(u64, u64)] {
        &self.kinds
    }

    /// All events.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.kinds.iter().map(|(on, off)| on + off).sum()
    }
}

impl Sink for Tally {
    type Band<'a> = TallyBand<'a>;

    fn check(&self, size: Size, channels: usize) -> Result<(), SensorError> {
        check_shape("a tally", (size, self.kinds.len()), (size, channels))
    }

    fn wants_times(&self) -> bool {
        false
    }

    fn begin(&mut self, _: Interval, bands: &[Range<usize>]) -> Vec<TallyBand<'_>> {
        let none = vec![(0, 0); self.kinds.len()];
        self.bands = vec![none; bands.len()];
        self.bands.iter_mut().map(TallyBand).collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        for band in &self.bands {
            for (all, own) in self.kinds.iter_mut().zip(band) {
                all.0 += own.0;
                all.1 += own.1;
            }
        }
        Ok(())
    }
}

impl BandSink for TallyBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        let (on, off) = &mut self.0[row.channel];
        let (all, net) = sums(&row.counts);
        *on += i64::midpoint(all, net) as u64;
        *off += i64::midpoint(all, -net) as u64;
        Ok(())
    }
}

/// All events, and ON events less OFF events.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn sums(counts: &[i32]) -> (i64, i64) {
    let (mut all, mut net) = (0, 0);
    for block in counts.chunks(256) {
        let (mut few, mut few_net, mut any) = (0u32, 0i32, 0);
        for &count in block {
            few = few.wrapping_add(count.unsigned_abs());
            few_net = few_net.wrapping_add(count);
            any |= count.unsigned_abs();
        }
        // Nearly always they fit.
        if any < 1 << 22 {
            all += i64::from(few);
            net += i64::from(few_net);
        } else {
            for &count in block {
                all += i64::from(count.unsigned_abs());
                net += i64::from(count);
            }
        }
    }
    (all, net)
}
