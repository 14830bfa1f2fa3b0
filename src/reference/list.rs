//! Events as a list, in order of time: ties row by row, then by channel.

use std::ops::Range;

use crate::{
    event::{Event, Packet},
    number::Real,
    sensor::SensorError,
    unit::Micros,
};

use super::train::{BandSink, Pair, Sink, TrainRow};

/// What to do when a list would grow beyond its bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WhenFull {
    /// Stop with an error.
    #[default]
    Stop,
    /// Drop further events and count them in [`crate::event::Dropped::over_limit`].
    Drop,
}

/// A bound on the length of an event list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// How many events a packet may hold.
    pub events: usize,
    /// What happens beyond.
    pub when_full: WhenFull,
}

impl Default for Limit {
    /// A hundred million events, 1.6 GB, then an error.
    fn default() -> Self {
        Self {
            events: 100_000_000,
            when_full: WhenFull::Stop,
        }
    }
}

/// Appends trains to a packet as single events.
///
/// A pair of frames whose events do not all fit is an error, or is dropped whole: which
/// events are missing must not depend on how the work was shared out.
#[derive(Debug)]
pub struct EventList<'a> {
    packet: &'a mut Packet,
    limit: Limit,
    pair: Pair,
    parts: Vec<Part>,
}

/// What one band of rows has said in the current pair.
#[derive(Debug)]
struct Part {
    pair: Pair,
    /// As many as fit.
    events: Vec<Event>,
    room: u64,
    /// All of them.
    total: u64,
}

/// The part of a list that one band of rows is told to.
#[derive(Debug)]
pub struct ListBand<'a>(&'a mut Part);

impl<'a> EventList<'a> {
    /// A list that goes on where the packet ends.
    pub const fn new(packet: &'a mut Packet, limit: Limit) -> Self {
        let pair = Pair {
            index: 0,
            from: 0.0,
            to: 0.0,
        };
        Self {
            packet,
            limit,
            pair,
            parts: Vec::new(),
        }
    }
}

impl Sink for EventList<'_> {
    type Band<'b>
        = ListBand<'b>
    where
        Self: 'b;

    fn wants_times(&self) -> bool {
        true
    }

    fn begin(&mut self, pair: Pair, bands: &[Range<usize>]) -> Vec<ListBand<'_>> {
        self.pair = pair;
        let room = self.limit.events.saturating_sub(self.packet.events.len()) as u64;
        let empty = || Part {
            pair,
            events: Vec::new(),
            room,
            total: 0,
        };
        self.parts.resize_with(bands.len(), empty);
        for part in &mut self.parts {
            part.events.clear();
            (part.pair, part.room, part.total) = (pair, room, 0);
        }
        self.parts.iter_mut().map(ListBand).collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        let room = self.limit.events.saturating_sub(self.packet.events.len()) as u64;
        let total: u64 = self.parts.iter().map(|part| part.total).sum();
        if total <= room {
            let (from, to) = (
                Micros::from_seconds(self.pair.from),
                Micros::from_seconds(self.pair.to),
            );
            sort_into(&mut self.packet.events, &self.parts, from, to);
            return Ok(());
        }
        match self.limit.when_full {
            WhenFull::Stop => Err(SensorError::ListFull {
                limit: self.limit.events,
            }),
            WhenFull::Drop => {
                self.packet.dropped.over_limit += total;
                Ok(())
            }
        }
    }
}

impl BandSink for ListBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        let part = &mut *self.0;
        let start = part.pair.from * 1e6;
        let duration = part.pair.duration() * 1e6;
        for (x, train) in row.trains() {
            part.total = part.total.saturating_add(train.count);
            if part.total > part.room {
                continue;
            }
            for i in 0..train.count {
                // Half up by truncation: times are not negative here, and rounding is slow.
                let t = Micros((start + train.at(i) * duration + 0.5) as u64);
                let (x, y, channel) = (x as u16, row.y as u16, row.channel as u8);
                part.events.push(Event {
                    t,
                    x,
                    y,
                    polarity: train.polarity,
                    channel,
                });
            }
        }
        Ok(())
    }
}

/// Longest pair, in microseconds, that is sorted by counting.
const COUNTED: u64 = 1 << 16;

/// Appends the events of all parts in order: by time, then row, column, channel.
fn sort_into(events: &mut Vec<Event>, parts: &[Part], from: Micros, to: Micros) {
    let start = events.len();
    let span = to.0.saturating_sub(from.0);
    let one_channel = parts
        .iter()
        .flat_map(|part| &part.events)
        .all(|event| event.channel == 0);
    if span > COUNTED || !one_channel {
        events.extend(parts.iter().flat_map(|part| &part.events));
        events[start..].sort_unstable_by_key(|e| (e.t, e.y, e.x, e.channel));
        return;
    }
    // One channel comes row by row, so a stable sort by time is enough.
    let bin = |event: &Event| event.t.0.saturating_sub(from.0).min(span) as usize;
    let mut next = vec![0u32; span as usize + 2];
    for event in parts.iter().flat_map(|part| &part.events) {
        next[bin(event) + 1] += 1;
    }
    let mut sum = 0;
    for count in &mut next {
        sum += *count;
        *count = sum;
    }
    let Some(&filler) = parts.iter().find_map(|part| part.events.first()) else {
        return;
    };
    events.resize(start + sum as usize, filler);
    let fresh = &mut events[start..];
    for event in parts.iter().flat_map(|part| &part.events) {
        let place = &mut next[bin(event)];
        fresh[*place as usize] = *event;
        *place += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Polarity, plane::Size};
    use proptest::prelude::*;

    fn told(
        rows: &[Vec<i8>],
        pair: Pair,
        limit: Limit,
        packet: &mut Packet,
    ) -> Result<(), SensorError> {
        let mut list = EventList::new(packet, limit);
        let bands: Vec<_> = (0..rows.len()).map(|y| y..y + 1).collect();
        for (y, (mut band, counts)) in list.begin(pair, &bands).into_iter().zip(rows).enumerate() {
            let width = counts.len();
            band.row(&TrainRow::<f64> {
                channel: 0,
                y,
                counts: counts.iter().map(|c| f64::from(*c)).collect(),
                first: (0..width).map(|x| (x * 7 % 10) as f64 / 20.0).collect(),
                spacing: vec![1.0 / 256.0; width],
            })?;
        }
        list.end()
    }

    proptest! {
        /// Counting and comparing put the same events into the same order.
        #[test]
        fn both_sorts_agree(rows in proptest::collection::vec(proptest::collection::vec(-9i8..9, 7), 1..9), index in 0u64..1000) {
            // The longer pair is too long to be counted: its times are those of the shorter, times 32.
            let pair = |dt: f64| Pair { index, from: index as f64 * dt, to: (index + 1) as f64 * dt };
            let [mut short, mut long] = [Packet::new(Size::new(9, 7), 1), Packet::new(Size::new(9, 7), 1)];
            told(&rows, pair(0.004_096), Limit::default(), &mut short).unwrap();
            told(&rows, pair(0.131_072), Limit::default(), &mut long).unwrap();
            prop_assert!(short.events.is_sorted_by_key(|e| (e.t, e.y, e.x)));
            let total: i64 = rows.iter().flatten().map(|c| i64::from(c.abs())).sum();
            prop_assert_eq!(short.events.len() as i64, total);
            let scaled: Vec<_> = short.canonical().iter().map(|e| (e.t.0 * 32, e.y, e.x, e.polarity)).collect();
            let mut exact: Vec<_> = long.events.iter().map(|e| (e.t.0, e.y, e.x, e.polarity)).collect();
            exact.sort_by_key(|e| (e.0 / 32, e.1, e.2));
            prop_assert_eq!(exact.len(), scaled.len());
        }
    }

    #[test]
    fn a_pair_that_does_not_fit_stops_or_is_dropped_whole() {
        let pair = Pair {
            index: 0,
            from: 0.0,
            to: 0.001,
        };
        let rows = vec![vec![3, -2], vec![0, 4]];
        let limit = |when_full| Limit {
            events: 8,
            when_full,
        };
        let mut packet = Packet::new(Size::new(2, 2), 1);
        let full = told(&rows, pair, limit(WhenFull::Stop), &mut packet);
        assert!(matches!(full, Err(SensorError::ListFull { limit: 8 })));
        told(&rows, pair, limit(WhenFull::Drop), &mut packet).unwrap();
        assert_eq!((packet.events.len(), packet.dropped.over_limit), (0, 9));
        told(&[vec![1, -1]], pair, limit(WhenFull::Drop), &mut packet).unwrap();
        assert_eq!(packet.events.len(), 2);
        assert_eq!(packet.events[1].polarity, Polarity::Off);
    }
}
