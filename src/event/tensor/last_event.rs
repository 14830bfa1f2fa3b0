//! When each cell fired last: what time surfaces are made of.

use super::surface::TimeSurface;
use crate::{event::Event, plane::Size, unit::Micros};

/// A cell that has not fired.
const NEVER: u64 = u64::MAX;

/// When a cell fired last, and the sign of that event.
pub(super) type LastEvent = (u64, f32);

/// The last event of every cell.
#[derive(Clone, Debug)]
pub(super) struct LastEvents {
    how: TimeSurface,
    size: Size,
    cells: Vec<LastEvent>,
}

impl LastEvents {
    /// No events yet.
    pub(super) fn new(how: TimeSurface, size: Size, channels: u8) -> Self {
        let cells = vec![(NEVER, 0.0); how.len(size, channels)];
        Self { how, size, cells }
    }

    /// Takes in events, in the order of their times, all of them on the sensor.
    pub(super) fn take(&mut self, events: &[Event]) {
        let sides = self.how.sides;
        for event in events {
            if let Some(cell) = self.cells.get_mut(sides.place(event, self.size)) {
                *cell = (event.t.0, sides.sign(event.polarity) as f32);
            }
        }
    }

    /// The surface at a time at or after the last event, where all values are 0 before.
    pub(super) fn surface(&self, now: Micros, out: &mut [f32]) {
        for (out, (when, sign)) in out.iter_mut().zip(&self.cells) {
            if *when != NEVER {
                *out = sign * self.how.left(Micros(now.0.saturating_sub(*when)));
            }
        }
    }
}
