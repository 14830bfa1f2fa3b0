//! A train: the events of one cell in one pair of frames.
//!
//! Between two frames the drive is a straight line, so the crossings of equally spaced
//! levels are equally spaced in time, and so are those that a refractory period leaves.
//! Every model therefore says the same thing about a cell and a pair: how many events, the
//! first one's place, the spacing. Counts, voxels and event lists are all made from that,
//! the voxels in closed form.

use crate::{event::Polarity, sensor::SensorError};

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
        self.at(self.count - 1)
    }

    /// The number of events with the sign of the events.
    #[must_use]
    pub const fn signed_count(&self) -> i128 {
        self.polarity.sign() as i128 * self.count as i128
    }
}

/// Where and in which channel a train happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Kind of cell, from 0.
    pub channel: usize,
    /// Row.
    pub y: usize,
    /// Column.
    pub x: usize,
}

/// The two frames a train lies between, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Number of the pair, from 0.
    pub index: u64,
    /// Time of the earlier frame.
    pub from: f64,
    /// Time of the later frame.
    pub to: f64,
}

impl Pair {
    /// The time between the frames, in seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.to - self.from
    }
}

/// Something that is told of every train, pair after pair.
///
/// Within a pair, trains come channel by channel, row by row.
pub trait Sink {
    /// A new pair begins.
    fn begin(&mut self, pair: Pair);

    /// One train of the current pair.
    ///
    /// # Errors
    /// When the sink cannot hold it.
    fn train(&mut self, cell: Cell, train: Train) -> Result<(), SensorError>;
}

/// A sink that may not be wanted.
impl<S: Sink> Sink for Option<S> {
    fn begin(&mut self, pair: Pair) {
        if let Some(sink) = self {
            sink.begin(pair);
        }
    }

    fn train(&mut self, cell: Cell, train: Train) -> Result<(), SensorError> {
        self.as_mut().map_or(Ok(()), |sink| sink.train(cell, train))
    }
}

impl<S: Sink> Sink for &mut S {
    fn begin(&mut self, pair: Pair) {
        S::begin(self, pair);
    }

    fn train(&mut self, cell: Cell, train: Train) -> Result<(), SensorError> {
        S::train(self, cell, train)
    }
}

/// Three sinks that are told the same.
impl<A: Sink, B: Sink, C: Sink> Sink for (A, B, C) {
    fn begin(&mut self, pair: Pair) {
        self.0.begin(pair);
        self.1.begin(pair);
        self.2.begin(pair);
    }

    fn train(&mut self, cell: Cell, train: Train) -> Result<(), SensorError> {
        self.0.train(cell, train)?;
        self.1.train(cell, train)?;
        self.2.train(cell, train)
    }
}
