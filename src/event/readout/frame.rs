//! Bit maps: the bits of every cell are sent in every frame, whether it fired or not.
//!
//! A frame of `P` pixels and `K` kinds has `2 P K` bits, one plane for ON and one for OFF of
//! each kind (a cell may have fired both ways within a frame). It costs the same at any event
//! rate, and merges what a cell says twice within a frame. Address events of `b` bits each
//! cost less below
//!
//! ```text
//! n* = 2 P K / b   events a frame,      n* / period   events a second
//! ```
//!
//! and more above: [`Frame::crossover`]. At 1280x720, one kind, `b` = 22: 83,782 events a
//! frame. A frame is sent when it ends; its bits take `2 P K` times the time of a bit, and
//! frames wait for each other where that is longer than a frame.

use std::collections::HashSet;

use super::{
    ReadOut, Statistics,
    link::Link,
    statistics::Latencies,
    time::{Window, windows},
};
use crate::{
    event::{Dropped, Event, Packet},
    plane::Size,
    unit::{Micros, Picos},
};

/// A readout by bit maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Length of a frame, whose events are stamped with its end; 0 when each time stamp of the
    /// packet is a frame of its own.
    pub period: Micros,
    /// Time of one bit on the link; 0 when the link is never the limit.
    pub bit: Picos,
}

impl Frame {
    /// Bits of one frame.
    #[must_use]
    pub const fn bits(size: Size, channels: u8) -> u64 {
        2 * size.pixels() as u64 * channels as u64
    }

    /// Events a frame above which address events of `bits_per_event` cost more than a bit map;
    /// infinite for events that cost nothing.
    #[must_use]
    pub fn crossover(size: Size, channels: u8, bits_per_event: f64) -> f64 {
        Self::bits(size, channels) as f64 / bits_per_event
    }

    /// Reads a packet out. Frames without events are sent as well, from the first time watched to
    /// the last.
    #[must_use]
    pub fn read(&self, packet: &Packet) -> ReadOut {
        let mut out = Vec::with_capacity(packet.events.len());
        let mut latencies = Latencies::new(packet);
        let (mut dropped, mut most) = (Dropped::default(), 0);
        let bits = Self::bits(packet.size, packet.channels);
        let frame = u128::from(self.bit.0).saturating_mul(bits.into());
        let mut link = Link::new(self.period, frame, packet);
        for Window { stamp, events } in windows(packet, self.period) {
            let arrival = link.send(stamp);
            let mut set = HashSet::new();
            let before = out.len();
            for e in events {
                if set.insert((e.channel, e.polarity, e.y, e.x)) {
                    latencies.push(e.t, arrival);
                    out.push(Event { t: stamp, ..*e });
                } else {
                    dropped.merged += 1;
                }
            }
            most = most.max(set.len() as u64);
            // Planes one after the other, each row by row.
            if let Some(new) = out.get_mut(before..) {
                new.sort_unstable_by_key(|e| (e.channel, e.polarity, e.y, e.x));
            }
        }
        link.idle_until(packet.span.1);
        let stages = vec![link.stage("link", most)];
        let statistics = Statistics::new("frame", packet, dropped, &latencies, stages, link.free());
        ReadOut::new(packet, out, statistics)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::event::{
        Polarity,
        readout::testing::{event, packet},
    };

    #[test]
    fn the_crossover_of_a_megapixel_sensor() {
        let n = Frame::crossover(Size::new(720, 1280), 1, 22.0);
        assert!((n - 83_781.8).abs() < 0.1, "{n}");
        assert_eq!(Frame::bits(Size::new(720, 1280), 1) * 240, 442_368_000);
        assert_eq!(Frame::bits(Size::new(2, 3), 4), 48);
    }

    #[test]
    fn one_bit_holds_one_event() {
        let off = Event {
            polarity: Polarity::Off,
            ..event(4, 1, 0)
        };
        let events = [event(1, 1, 0), event(3, 1, 0), off, event(11, 1, 0)];
        let frame = Frame {
            period: Micros(10),
            bit: Picos(500_000),
        };
        let read = frame.read(&packet(2, 1, &events));
        let seen: Vec<_> = read
            .packet
            .events
            .iter()
            .map(|e| (e.t.0, e.polarity))
            .collect();
        assert_eq!(
            seen,
            [(10, Polarity::Off), (10, Polarity::On), (20, Polarity::On)]
        );
        assert_eq!(read.packet.dropped.merged, 1);
        assert_eq!(read.packet.span, (Micros(1), Micros(20)));
        // Four bits of 0.5 us: 2 us behind the frame's end; two frames in 1 to 22 us.
        let statistics = read.statistics;
        assert_eq!(
            statistics.latency.unwrap().max.0,
            11_000_000,
            "fired at 1, arrived at 12"
        );
        assert!((statistics.stages[0].busy - 4.0 / 21.0).abs() < 1e-12);
    }

    proptest! {
        /// Frame by frame, the empty ones one by one.
        #[test]
        fn frames_wait_for_each_other(
            times in prop::collection::btree_set(1..400_u64, 1..8),
            period in 1..20_u64,
            bit in 0..12_u64,
            before in 0..90_u64,
        ) {
            let events: Vec<_> = times.iter().map(|t| event(*t, 0, 0)).collect();
            let mut packet = packet(1, 1, &events);
            let start = times.first().unwrap().saturating_sub(before);
            packet.span.0 = Micros(start);
            let frame = Frame { period: Micros(period), bit: Picos(bit * 1_000_000) };
            let read = frame.read(&packet);
            let (mut free, mut worst, mut sent) = (0, 0, 0);
            let last = times.last().unwrap().div_ceil(period);
            for number in start.div_ceil(period)..=last {
                free = free.max(number * period) + 2 * bit;
                sent += 1;
                let inside = |t: &&u64| t.div_ceil(period) == number;
                if let Some(first) = times.iter().find(inside) {
                    worst = worst.max(free - first);
                }
            }
            prop_assert_eq!(read.statistics.latency.unwrap().max.0, worst * 1_000_000);
            let whole = free.max(*times.last().unwrap()) - start;
            if whole > 0 {
                let busy = (2 * bit * sent) as f64 / whole as f64;
                prop_assert!((read.statistics.stages[0].busy - busy).abs() < 1e-12);
            }
        }
    }
}
