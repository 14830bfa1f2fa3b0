//! The packed events of one band of rows in an interval.

use crate::{event::Event, number::Real, reference::train::TrainRow};

use super::{
    block::{FEW, expand},
    packed_event::PackedEvent,
    time_quantiser::TimeQuantiser,
};

/// The events of one band in the current interval, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    quantiser: TimeQuantiser,
    /// The packed events; the buffer is longer.
    packed: Vec<PackedEvent>,
    /// The number of packed events.
    len: usize,
    /// The events of an interval that is too long for packed times.
    pub(super) events: Vec<Event>,
}

impl Part {
    /// Clears it for a new interval.
    pub(super) fn begin(&mut self, quantiser: TimeQuantiser) {
        (self.quantiser, self.len) = (quantiser, 0);
        self.events.clear();
    }

    /// Packs the events of a row of trains.
    pub(super) fn take<R: Real>(&mut self, row: &TrainRow<R>) {
        if self.quantiser.is_long() {
            self.take_long(row);
            return;
        }
        let end = self.len + row.events() as usize;
        if self.packed.len() < end + FEW {
            let room = (end + FEW).next_power_of_two();
            self.packed.resize(room, PackedEvent::default());
        }
        expand(row, &self.quantiser, &mut self.packed[self.len..end + FEW]);
        self.len = end;
    }

    pub(super) fn packed(&self) -> &[PackedEvent] {
        &self.packed[..self.len]
    }

    fn take_long<R: Real>(&mut self, row: &TrainRow<R>) {
        let quantiser = self.quantiser;
        for (x, train) in row.trains() {
            let packed = PackedEvent::new(row.channel, row.y).column(x, row.counts[x]);
            let event = |i| packed.at(quantiser.time(quantiser.at(train.at(i))));
            self.events.extend((0..train.count).map(event));
        }
    }
}
