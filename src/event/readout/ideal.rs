//! The ideal readout: nothing is lost or delayed.

use super::{
    arrival::ReadOut,
    statistics::{Latencies, Statistics},
    time::picos,
};
use crate::event::{Dropped, Packet};

/// Every event arrives when it fired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ideal;

impl Ideal {
    /// The packet as it was.
    #[must_use]
    pub fn read(&self, packet: &Packet) -> ReadOut {
        let mut latencies = Latencies::new(packet);
        for e in &packet.events {
            latencies.push(e.t, picos(e.t));
        }
        let nothing = Dropped::default();
        let statistics = Statistics::new("ideal", packet, nothing, &latencies, Vec::new(), 0);
        ReadOut::new(packet, packet.events.clone(), statistics)
    }
}

#[cfg(test)]
mod tests {
    use super::{super::testing::*, *};

    #[test]
    fn ideal_is_the_identity() {
        let before = packet(4, 4, &[event(3, 0, 0), event(3, 1, 1), event(9, 0, 0)]);
        let read = Ideal.read(&before);
        assert_eq!(read.packet, before);
        let latency = read.statistics.latency.unwrap();
        assert_eq!((latency.max.0, read.statistics.dropped.total()), (0, 0));
        assert_eq!(read.statistics.events, [3, 3]);
    }
}
