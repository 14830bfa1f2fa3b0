//! Composite sinks: an optional one, and several at once.

use std::ops::Range;

use crate::{number::Real, plane::Size, sensor::SensorError};

use super::train::{BandSink, Interval, Sink, TrainRow};

impl<S: Sink> Sink for &mut S {
    type Band<'a>
        = S::Band<'a>
    where
        Self: 'a;

    fn check(&self, size: Size, channels: usize) -> Result<(), SensorError> {
        S::check(self, size, channels)
    }

    fn wants_times(&self) -> bool {
        S::wants_times(self)
    }

    fn begin(&mut self, interval: Interval, bands: &[Range<usize>]) -> Vec<S::Band<'_>> {
        S::begin(self, interval, bands)
    }

    fn end(&mut self) -> Result<(), SensorError> {
        S::end(self)
    }
}

impl<S: Sink> Sink for Option<S> {
    type Band<'a>
        = Option<S::Band<'a>>
    where
        Self: 'a;

    fn check(&self, size: Size, channels: usize) -> Result<(), SensorError> {
        self.as_ref()
            .map_or(Ok(()), |sink| sink.check(size, channels))
    }

    fn wants_times(&self) -> bool {
        self.as_ref().is_some_and(S::wants_times)
    }

    fn begin(&mut self, interval: Interval, bands: &[Range<usize>]) -> Vec<Self::Band<'_>> {
        match self {
            Some(sink) => sink.begin(interval, bands).into_iter().map(Some).collect(),
            None => bands.iter().map(|_| None).collect(),
        }
    }

    fn end(&mut self) -> Result<(), SensorError> {
        self.as_mut().map_or(Ok(()), S::end)
    }
}

impl<B: BandSink> BandSink for Option<B> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        self.as_mut().map_or(Ok(()), |sink| sink.row(row))
    }
}

impl<A: Sink, B: Sink> Sink for (A, B) {
    type Band<'a>
        = (A::Band<'a>, B::Band<'a>)
    where
        Self: 'a;

    fn check(&self, size: Size, channels: usize) -> Result<(), SensorError> {
        self.0.check(size, channels)?;
        self.1.check(size, channels)
    }

    fn wants_times(&self) -> bool {
        self.0.wants_times() || self.1.wants_times()
    }

    fn begin(&mut self, interval: Interval, bands: &[Range<usize>]) -> Vec<Self::Band<'_>> {
        let first = self.0.begin(interval, bands);
        first
            .into_iter()
            .zip(self.1.begin(interval, bands))
            .collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        self.0.end()?;
        self.1.end()
    }
}

impl<A: BandSink, B: BandSink> BandSink for (A, B) {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        self.0.row(row)?;
        self.1.row(row)
    }
}

/// Refuses a sink that is for a sensor of another shape.
pub(super) fn check_shape(
    sink: &'static str,
    (got, got_kinds): (Size, usize),
    (want, want_kinds): (Size, usize),
) -> Result<(), SensorError> {
    if (got, got_kinds) == (want, want_kinds) {
        return Ok(());
    }
    Err(SensorError::Sink {
        sink,
        got,
        got_kinds,
        want,
        want_kinds,
    })
}
