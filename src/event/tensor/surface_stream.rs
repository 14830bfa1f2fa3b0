//! Time surfaces of a recording that comes part by part.

use super::{
    error::{TensorError, check_room},
    last_event::LastEvents,
    surface::TimeSurface,
    windows::Windows,
};
use crate::{
    event::{Event, outside},
    plane::Size,
    unit::Micros,
};

/// The time surfaces of events that come part by part, one at the end of each window.
///
/// They are those that [`TimeSurface::of`] makes at these times, to the bit.
#[derive(Clone, Debug)]
pub struct SurfaceStream {
    how: TimeSurface,
    windows: Windows,
    size: Size,
    channels: u8,
    /// The number of the next surface.
    next: u64,
    last: LastEvents,
}

impl SurfaceStream {
    /// No events yet, of a sensor of this size with so many kinds of cells.
    ///
    /// # Errors
    /// When the times of the last events are more than this machine holds.
    pub fn new(
        how: TimeSurface,
        windows: Windows,
        size: Size,
        channels: u8,
    ) -> Result<Self, TensorError> {
        check_room(1, "time surfaces", how.held(size, channels, 1))?;
        Ok(Self {
            how,
            windows,
            size,
            channels,
            next: 0,
            last: LastEvents::new(how, size, channels),
        })
    }

    /// Takes in the next events, in the order of their times, and passes on each surface whose time
    /// is before that of an event: the next events may be of the last one's time, too.
    ///
    /// # Errors
    /// When an event lies outside of the sensor; the first of `pass`.
    pub fn pass<E: From<TensorError>>(
        &mut self,
        events: &[Event],
        mut pass: impl FnMut(&[f32]) -> Result<(), E>,
    ) -> Result<(), E> {
        outside::check(events, self.size, self.channels).map_err(TensorError::from)?;
        let mut rest = events;
        while let Some(last) = rest.last() {
            let now = self.time();
            // The last surface that there can be sees all that comes later, too.
            if last.t <= now || now == Micros(i64::MAX.cast_unsigned()) {
                break;
            }
            let (seen, later) = rest.split_at(rest.partition_point(|event| event.t <= now));
            self.last.take(seen);
            pass(&self.surface())?;
            rest = later;
        }
        self.last.take(rest);
        Ok(())
    }

    /// The next surface, if any is left of a recording that ends at `end`.
    pub fn next_left(&mut self, end: Micros) -> Option<Vec<f32>> {
        let left = self.next < self.windows.count(end);
        left.then(|| self.surface())
    }

    /// The time of the next surface.
    #[must_use]
    pub fn time(&self) -> Micros {
        Micros(self.windows.bounds(self.next).1.max(0).cast_unsigned())
    }

    /// The next surface, whose events are all in.
    fn surface(&mut self) -> Vec<f32> {
        let mut out = vec![0.0; self.how.len(self.size, self.channels)];
        self.last.surface(self.time(), &mut out);
        self.next += 1;
        out
    }
}
