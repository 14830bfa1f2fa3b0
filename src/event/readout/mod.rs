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
mod arrival;
pub mod frame;
mod ideal;
mod link;
mod queue;
pub mod scan;
pub mod settings;
mod statistics;
mod time;

pub use arbiter::{Arbiter, Requests, RowOrder};
pub use arrival::ReadOut;
pub use frame::Frame;
pub use ideal::Ideal;
pub use queue::WhenFull;
pub use scan::Scan;
pub use statistics::{Latency, Stage, Statistics};

use super::Packet;

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
    /// Reads a packet out: what of it arrives, and when.
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
