//! The packet behind a readout.

use super::statistics::Statistics;
use crate::event::{Event, Packet};

/// The packet that arrives, and statistics of the readout.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOut {
    /// The packet that arrives: drops of the readout added to those of the packet before it.
    pub packet: Packet,
    /// Statistics of the readout.
    pub statistics: Statistics,
}

impl ReadOut {
    /// `events` in order of time; the span reaches to the last of them.
    pub(super) fn new(before: &Packet, events: Vec<Event>, statistics: Statistics) -> Self {
        let mut dropped = before.dropped;
        dropped += statistics.dropped;
        let last = events.last().map_or(before.span.1, |e| e.t);
        Self {
            packet: Packet {
                size: before.size,
                channels: before.channels,
                names: before.names.clone(),
                span: (before.span.0, before.span.1.max(last)),
                events,
                dropped,
            },
            statistics,
        }
    }
}
