//! Events as a list, in order of time.

use crate::{
    event::{Event, Packet},
    sensor::SensorError,
    unit::Micros,
};

use super::train::{Cell, Pair, Sink, Train};

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
#[derive(Debug)]
pub struct EventList<'a> {
    packet: &'a mut Packet,
    limit: Limit,
    pair: Pair,
    /// Where the current pair's events begin.
    start: usize,
}

impl<'a> EventList<'a> {
    /// A list that ends where the packet ends.
    pub fn new(packet: &'a mut Packet, limit: Limit) -> Self {
        let start = packet.events.len();
        Self {
            packet,
            limit,
            pair: Pair {
                index: 0,
                from: 0.0,
                to: 0.0,
            },
            start,
        }
    }

    /// Puts the events of the current pair in order: time, row, column, channel.
    pub fn finish(self) {
        self.packet.events[self.start..]
            .sort_unstable_by_key(|e| (e.t, e.y, e.x, e.channel, e.polarity));
    }
}

impl Sink for EventList<'_> {
    fn begin(&mut self, pair: Pair) {
        self.pair = pair;
        self.start = self.packet.events.len();
    }

    fn train(&mut self, cell: Cell, train: Train) -> Result<(), SensorError> {
        let room = (self.limit.events - self.packet.events.len().min(self.limit.events)) as u64;
        let kept = train.count.min(room);
        if kept < train.count {
            match self.limit.when_full {
                WhenFull::Stop => {
                    return Err(SensorError::ListFull {
                        limit: self.limit.events,
                    });
                }
                WhenFull::Drop => self.packet.dropped.over_limit += train.count - kept,
            }
        }
        for i in 0..kept {
            let seconds = self.pair.from + train.at(i) * self.pair.duration();
            self.packet.events.push(Event {
                t: Micros::from_seconds(seconds),
                x: cell.x as u16,
                y: cell.y as u16,
                polarity: train.polarity,
                channel: cell.channel as u8,
            });
        }
        Ok(())
    }
}
