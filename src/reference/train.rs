//! A train: the events of one cell in one interval.
//!
//! Between two frames the drive is a straight line, so the crossings of equally spaced levels are
//! equally spaced in time, and so are those that a refractory period leaves. The events of a cell
//! in an interval are therefore three numbers: how many, the place of the first, the spacing.
//! Counts, voxels and event lists are all made from these, the voxels in closed form.

use std::ops::Range;

use multiversion::multiversion;

use crate::{event::Polarity, number::Real, plane::Size, sensor::SensorError};

/// Equally spaced events of one cell between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Train {
    /// Sign of all of them.
    pub polarity: Polarity,
    /// How many, one or more.
    pub count: u64,
    /// When the first one happens: 0 at the earlier frame, 1 at the later.
    pub first: f64,
    /// From one event to the next, in the same unit.
    pub spacing: f64,
}

impl Train {
    /// When event `i` happens, from 0: 0 at the earlier frame, 1 at the later.
    #[must_use]
    pub fn at(&self, i: u64) -> f64 {
        (self.first + self.spacing * i as f64).clamp(0.0, 1.0)
    }

    /// When the last one happens.
    #[must_use]
    pub fn last(&self) -> f64 {
        self.at(self.count.saturating_sub(1))
    }
}

/// The trains of a row of cells, one entry for each column; a count of 0 is no train.
#[derive(Clone, Debug)]
pub struct TrainRow<R> {
    /// Kind of cell, from 0.
    pub channel: usize,
    /// Row.
    pub y: usize,
    /// Number of events, with their sign.
    pub counts: Vec<i32>,
    /// As [`Train::first`]; anything where there is no train.
    pub first: Vec<R>,
    /// As [`Train::spacing`]; anything where there is no train.
    pub spacing: Vec<R>,
}

impl<R: Real> TrainRow<R> {
    /// A row of `width` silent cells.
    #[must_use]
    pub fn new(width: usize) -> Self {
        Self {
            channel: 0,
            y: 0,
            counts: vec![0; width],
            first: vec![R::ZERO; width],
            spacing: vec![R::ZERO; width],
        }
    }

    /// The train in column `x`.
    #[must_use]
    pub fn get(&self, x: usize) -> Option<Train> {
        let count = self.counts[x];
        (count != 0).then(|| Train {
            polarity: Polarity::of(count > 0),
            count: count.unsigned_abs().into(),
            first: self.first[x].to_f64(),
            spacing: self.spacing[x].to_f64(),
        })
    }

    /// Sets the train in column `x`, or none.
    pub(super) fn set(&mut self, x: usize, train: Option<Train>) {
        match train {
            None => self.counts[x] = 0,
            Some(train) => {
                let count = i32::try_from(train.count).unwrap_or(i32::MAX);
                self.counts[x] = if train.polarity == Polarity::On {
                    count
                } else {
                    -count
                };
                self.first[x] = R::from_f64(train.first);
                self.spacing[x] = R::from_f64(train.spacing);
            }
        }
    }

    /// Counts, first places and spacings.
    pub(super) fn parts(&self) -> (&[i32], &[R], &[R]) {
        (&self.counts, &self.first, &self.spacing)
    }

    /// All events of the row.
    #[must_use]
    pub fn events(&self) -> u64 {
        events(&self.counts)
    }

    /// The columns with a train, and the trains.
    pub fn trains(&self) -> impl Iterator<Item = (usize, Train)> {
        (0..self.counts.len()).filter_map(|x| Some((x, self.get(x)?)))
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn events(counts: &[i32]) -> u64 {
    let mut sum = 0;
    for block in counts.chunks(256) {
        let (mut few, mut any) = (0u32, 0);
        for count in block {
            few = few.wrapping_add(count.unsigned_abs());
            any |= count.unsigned_abs();
        }
        // Nearly always they fit.
        sum += if any < 1 << 24 {
            u64::from(few)
        } else {
            block.iter().map(|n| u64::from(n.unsigned_abs())).sum()
        };
    }
    sum
}

/// An interval: the time between two frames, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Number of the interval, from 0.
    pub index: u64,
    /// Time of the earlier frame.
    pub from: f64,
    /// Time of the later frame.
    pub to: f64,
}

impl Interval {
    /// The time between the frames, in seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.to - self.from
    }
}

/// A receiver of all trains, interval after interval.
///
/// An interval is passed in bands of rows, which may be passed in parallel.
pub trait Sink {
    /// The part of a sink for one band of rows.
    type Band<'a>: BandSink + Send
    where
        Self: 'a;

    /// Whether it can take the events of a sensor of this size and so many kinds of cells.
    ///
    /// # Errors
    /// [`SensorError::Sink`] when it is for another.
    fn check(&self, _size: Size, _channels: usize) -> Result<(), SensorError> {
        Ok(())
    }

    /// Whether the times of the events matter, or only their number.
    fn wants_times(&self) -> bool;

    /// Begins a new interval; returns one part for each band of rows, in order.
    fn begin(&mut self, interval: Interval, bands: &[Range<usize>]) -> Vec<Self::Band<'_>>;

    /// Ends the interval.
    ///
    /// # Errors
    /// When the sink cannot hold what it has taken.
    fn end(&mut self) -> Result<(), SensorError>;
}

/// The part of a sink for one band of rows.
pub trait BandSink {
    /// Takes one row of one channel. Rows come in order, and for each row the channels in turn. A
    /// row that comes again adds to what came before.
    ///
    /// # Errors
    /// When the sink cannot hold it.
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError>;
}
