//! Between the pixels and the packet: what a readout loses, merges and delays.
//!
//! ```text
//!  cells that fired ─► readout ─► events that arrive ─► packet
//!                        └─► drops by reason, latency, utilisation
//! ```
//!
//! | type | what it is | physics |
//! |---|---|---|
//! | [`Ideal`] | nothing is lost, nothing takes time | |
//! | [`Scan`] | SCAMP-5's: set pixels found one by one into slots | [`scan`] |
//! | [`Arbiter`] | rows and columns arbitrated, a queue, a link | [`arbiter`] |
//! | [`Frame`] | bit maps: every cell's bits, frame by frame | [`frame`] |
//!
//! A readout takes a packet as the cells made it, each event at the time it fired, and gives
//! the packet that arrives. What is dropped is counted in the packet's
//! [`Dropped`](crate::event::Dropped), by reason. Times within a readout are integer
//! picoseconds; arrivals are stamped with the last whole microsecond.
//!
//! Settings are text, from files in `readouts/` in which each number has its source and its
//! evidence: [`settings`].

pub mod arbiter;
pub mod frame;
mod queue;
pub mod scan;
pub mod settings;
mod statistics;

pub use arbiter::{Arbiter, Requests, RowOrder};
pub use frame::Frame;
pub use queue::WhenFull;
pub use scan::Scan;
pub use statistics::{Latency, Stage, Statistics};

use super::{Event, Packet};
use crate::unit::Micros;

/// What arrives, and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOut {
    /// The packet that arrives: drops of the readout added to those of the packet before it.
    pub packet: Packet,
    /// What the readout did.
    pub statistics: Statistics,
}

impl ReadOut {
    /// `events` in order of time; the span reaches to the last of them.
    fn new(before: &Packet, events: Vec<Event>, statistics: Statistics) -> Self {
        let mut dropped = before.dropped;
        dropped += statistics.dropped;
        let last = events.last().map_or(before.span.1, |e| e.t);
        Self {
            packet: Packet {
                size: before.size,
                channels: before.channels,
                span: (before.span.0, before.span.1.max(last)),
                events,
                dropped,
            },
            statistics,
        }
    }
}

/// One of the readouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readout {
    /// Every event arrives when it fired.
    Ideal(Ideal),
    /// SCAMP-5's scan.
    Scan(Scan),
    /// Row-column arbitration.
    Arbiter(Arbiter),
    /// Bit maps, frame by frame.
    Frame(Frame),
}

impl Readout {
    /// What of `packet` arrives, and when.
    ///
    /// Events must be ordered by time, as a packet's are.
    #[must_use]
    pub fn read(&self, packet: &Packet) -> ReadOut {
        match self {
            Self::Ideal(ideal) => ideal.read(packet),
            Self::Scan(scan) => scan.read(packet),
            Self::Arbiter(arbiter) => arbiter.read(packet),
            Self::Frame(frame) => frame.read(packet),
        }
    }
}

/// Every event arrives when it fired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ideal;

impl Ideal {
    /// The packet as it was.
    #[must_use]
    pub fn read(&self, packet: &Packet) -> ReadOut {
        let latencies = vec![0; packet.events.len()];
        let nothing = super::Dropped::default();
        let statistics = Statistics::new("ideal", packet, nothing, &latencies, Vec::new(), 0);
        ReadOut::new(packet, packet.events.clone(), statistics)
    }
}

/// The events that one frame's bits stand for.
struct Window<'a> {
    /// The frame's end.
    stamp: Micros,
    events: &'a [Event],
}

/// Cuts a packet into frames of length `period`: an event at `t` belongs to the frame that ends
/// at the next multiple of `period`, `t` itself included. With period 0 each time stamp is a
/// frame.
fn windows(packet: &Packet, period: Micros) -> impl Iterator<Item = Window<'_>> {
    let stamp = move |t: Micros| match period.0 {
        0 => t,
        period => Micros(t.0.div_ceil(period).saturating_mul(period)),
    };
    packet
        .events
        .chunk_by(move |a, b| stamp(a.t) == stamp(b.t))
        .filter_map(move |events| {
            let stamp = stamp(events.first()?.t);
            Some(Window { stamp, events })
        })
}

/// A time stamp in picoseconds. Wide enough for any.
fn picos(t: Micros) -> u128 {
    u128::from(t.0) * 1_000_000
}

/// The last whole microsecond before a time in picoseconds.
fn micros(picos: u128) -> Micros {
    Micros(u64::try_from(picos / 1_000_000).unwrap_or(u64::MAX))
}

/// From when an event fired to `picos`, in picoseconds; at most [`Latency::BEYOND`].
fn since(t: Micros, at: u128) -> u64 {
    u64::try_from(at.saturating_sub(picos(t))).unwrap_or(u64::MAX)
}

#[cfg(test)]
pub(crate) mod testing {
    use crate::{
        event::{Event, Packet, Polarity},
        plane::Size,
        unit::Micros,
    };

    /// An ON event of kind 0.
    pub fn event(t: u64, x: u16, y: u16) -> Event {
        Event {
            t: Micros(t),
            x,
            y,
            polarity: Polarity::On,
            channel: 0,
        }
    }

    /// Of one kind; watched from the first to the last event.
    pub fn packet(width: usize, height: usize, events: &[Event]) -> Packet {
        let mut packet = Packet::new(Size::new(height, width), 1);
        packet.events = events.to_vec();
        if let (Some(first), Some(last)) = (events.first(), events.last()) {
            packet.span = (first.t, last.t);
        }
        packet
    }
}

#[cfg(test)]
mod tests {
    use super::{testing::*, *};

    #[test]
    fn ideal_is_the_identity() {
        let before = packet(4, 4, &[event(3, 0, 0), event(3, 1, 1), event(9, 0, 0)]);
        let read = Ideal.read(&before);
        assert_eq!(read.packet, before);
        let latency = read.statistics.latency.unwrap();
        assert_eq!((latency.max.0, read.statistics.dropped.total()), (0, 0));
        assert_eq!(read.statistics.events, [3, 3]);
    }

    #[test]
    fn a_frame_ends_with_its_last_microsecond() {
        let all = packet(1, 1, &[0, 1, 10, 11, 20, 35].map(|t| event(t, 0, 0)));
        let cut = |period| {
            windows(&all, Micros(period))
                .map(|f| (f.stamp.0, f.events.len()))
                .collect::<Vec<_>>()
        };
        assert_eq!(cut(10), [(0, 1), (10, 2), (20, 2), (40, 1)]);
        assert_eq!(cut(0).len(), 6);
    }
}
