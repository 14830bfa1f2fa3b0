//! SCAMP-5's readout: set pixels found one by one, into a list of slots.
//!
//! ```text
//!   image            chip
//!   (0,0)──► x       column ◄──(0,0)
//!     │                          │
//!     ▼ y                        ▼ row
//! ```
//!
//! A priority encoder finds the first column that holds a set pixel, then the first row in it,
//! clears that pixel and goes on: columns outside, rows inside, from the top right. The time is
//! that of all slots, used or not. An unused slot reads as (0,0), so a true event at (0,0)
//! cannot be told from the end of the list.
//!
//! [`Scan`] puts a packet through it: for each frame and kind the pixels of ON, then those of
//! OFF, are scanned; the frames wait for each other where they come too fast. With a period every
//! frame is read, whether or not there are events in it. The host stamps
//! what it reads with the frame's time, as it knows which frame it reads; how long after that
//! an event was read is its latency.

use super::{ReadOut, Statistics, link::Link, statistics::Latencies, time::windows};
use crate::{
    event::{Dropped, Event, Packet, Polarity},
    plane::{At, Size},
    unit::{Micros, Picos},
};

/// The most slots of one scan: what the list of the chip's host holds.
pub const SLOTS: u32 = 4000;

/// A pixel's address as the chip counts: from the top right corner, columns leftwards.
///
/// This is the one place where chip addresses and image coordinates are converted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// Counted leftwards from the right.
    pub column: usize,
    /// Counted down from the top.
    pub row: usize,
}

impl Address {
    /// Where the count starts.
    pub const ORIGIN: Self = Self { column: 0, row: 0 };

    /// Of a pixel of an array of this size.
    #[must_use]
    pub const fn from_pixel(at: At, size: Size) -> Self {
        Self {
            column: size.width - 1 - at.x,
            row: at.y,
        }
    }

    /// Where it lies in the image; `None` off the array.
    #[must_use]
    pub const fn at(self, size: Size) -> Option<At> {
        if self.column < size.width && self.row < size.height {
            Some(At {
                y: self.row,
                x: size.width - 1 - self.column,
            })
        } else {
            None
        }
    }
}

/// The order of the scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Order {
    /// Columns from the left of the image instead of the right.
    pub from_left: bool,
    /// Rows from the bottom instead of the top.
    pub from_bottom: bool,
}

impl Order {
    /// The columns of the image, in the order in which they are looked at.
    pub fn columns(self, size: Size) -> impl Iterator<Item = usize> {
        let flip = !self.from_left;
        (0..size.width).map(move |x| if flip { size.width - 1 - x } else { x })
    }

    /// The rows of the image, in the order in which they are looked at within a column.
    pub fn rows(self, size: Size) -> impl Iterator<Item = usize> {
        let flip = self.from_bottom;
        (0..size.height).map(move |y| if flip { size.height - 1 - y } else { y })
    }

    /// The sort key of an event's pixel in this order.
    fn key(self, event: &Event) -> (u16, u16) {
        let flip = |flip: bool, at: u16| if flip { u16::MAX - at } else { at };
        (
            flip(!self.from_left, event.x),
            flip(self.from_bottom, event.y),
        )
    }
}

/// A readout by SCAMP-5's event scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scan {
    /// Slots of one scan: of one sign of one kind in one frame.
    pub slots: u32,
    /// Time of one slot, used or not.
    pub slot: Picos,
    /// Length of a frame, whose events are stamped with its end; 0 when each time stamp of the
    /// packet is a frame of its own.
    pub period: Micros,
    /// Which pixel is found first.
    pub order: Order,
}

impl Scan {
    /// Reads a packet out: what arrives, and its statistics.
    /// Frames of a period that are empty are read as well, from the first time watched to the last.
    #[must_use]
    pub fn read(&self, packet: &Packet) -> ReadOut {
        let mut out = Vec::with_capacity(packet.events.len());
        let mut latencies = Latencies::new(packet);
        let (mut dropped, mut ambiguous) = (Dropped::default(), 0);
        let mut most = 0;
        let scan = u128::from(self.slot.0) * u128::from(self.slots);
        // A scan that finds nothing takes as long.
        let all = 2 * u128::from(packet.channels) * scan;
        let mut link = Link::new(self.period, all, packet);
        for frame in windows(packet, self.period) {
            let start = link.send(frame.stamp) - all;
            let mut set: Vec<&Event> = frame.events.iter().collect();
            // The first event of a pixel sets its bit.
            set.sort_by_key(|e| (number(e), self.order.key(e)));
            set.dedup_by_key(|e| (number(e), e.x, e.y));
            dropped.merged += (frame.events.len() - set.len()) as u64;
            for plane in set.chunk_by(|a, b| number(a) == number(b)) {
                most = most.max(plane.len() as u64);
                let slots = plane.len().min(self.slots as usize);
                dropped.no_slot += (plane.len() - slots) as u64;
                for (e, slot) in plane.iter().take(slots).zip(1..) {
                    let read = start + number(e) * scan + slot * u128::from(self.slot.0);
                    latencies.push(e.t, read);
                    let at = At {
                        y: e.y.into(),
                        x: e.x.into(),
                    };
                    ambiguous += u64::from(Address::ORIGIN.at(packet.size) == Some(at));
                    let t = frame.stamp;
                    out.push(Event { t, ..**e });
                }
            }
        }
        link.idle_until(packet.span.1);
        let stages = vec![link.stage("scan", most)];
        let statistics = Statistics::new("scan", packet, dropped, &latencies, stages, link.free());
        ReadOut::new(
            packet,
            out,
            Statistics {
                ambiguous,
                ..statistics
            },
        )
    }
}

/// The number of the scan of a frame to which an event belongs: kind by kind, ON before OFF.
fn number(event: &Event) -> u128 {
    let off = u128::from(event.polarity == Polarity::Off);
    2 * u128::from(event.channel) + off
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::readout::testing::{event, packet};

    fn scan(slots: u32) -> Scan {
        Scan {
            slots,
            slot: "1us".parse().unwrap(),
            period: Micros(0),
            order: Order::default(),
        }
    }

    #[test]
    fn columns_from_the_right_rows_from_the_top() {
        let events = [(10, 0, 0), (10, 3, 2), (10, 3, 1), (10, 1, 0)];
        let packet = packet(4, 3, &events.map(|(t, x, y)| event(t, x, y)));
        let places = |order| {
            let read = Scan { order, ..scan(9) }.read(&packet);
            read.packet
                .events
                .iter()
                .map(|e| (e.x, e.y))
                .collect::<Vec<_>>()
        };
        let [far, near] = [(true, true), (false, false)].map(|(from_left, from_bottom)| Order {
            from_left,
            from_bottom,
        });
        assert_eq!(places(near), [(3, 1), (3, 2), (1, 0), (0, 0)]);
        assert_eq!(places(far), [(0, 0), (1, 0), (3, 2), (3, 1)]);
        let columns: Vec<_> = near.columns(packet.size).collect();
        assert_eq!(columns, [3, 2, 1, 0]);
        assert_eq!(far.rows(packet.size).collect::<Vec<_>>(), [2, 1, 0]);
    }

    #[test]
    fn all_slots_take_time_and_what_finds_none_is_counted() {
        // Two frames, the second while the first is still being read: 4 slots for ON, 4 for OFF.
        let events = [
            event(10, 0, 0),
            event(10, 0, 0),
            event(10, 1, 0),
            event(15, 2, 0),
        ];
        let read = scan(4).read(&packet(8, 1, &events));
        let s = &read.statistics;
        assert_eq!((s.dropped.merged, s.dropped.total()), (1, 1));
        // Slot 1 and 2 of the frame at 10, slot 1 of the frame that begins at 18.
        let latency = s.latency.as_ref().unwrap();
        assert_eq!((latency.p50.0, latency.max.0), (2_000_000, 4_000_000));
        assert_eq!(
            read.packet.events.iter().map(|e| e.t.0).max(),
            Some(15),
            "stamps are the frame's"
        );
        // Busy from 10 to 26, of a span from 10 to 26.
        assert_eq!(s.stages[0].busy, 1.0);
        let read = scan(1).read(&packet(8, 1, &events));
        let dropped = read.statistics.dropped;
        assert_eq!((dropped.no_slot, dropped.merged), (1, 1));
        assert_eq!(read.packet.dropped.total(), 2);
        assert_eq!(read.statistics.ambiguous, 0);
        let corner = scan(1).read(&packet(8, 1, &[event(0, 7, 0)]));
        assert_eq!(corner.statistics.ambiguous, 1);
    }

    #[test]
    fn empty_frames_take_their_time() {
        // Each frame takes 18 us, one ends every 10: those at 20 and 30 are empty, and the one at
        // 40 waits for them, from 10 + 3 x 18 = 64 on.
        let read = |period| {
            let scan = Scan {
                period: Micros(period),
                ..scan(9)
            };
            scan.read(&packet(8, 1, &[event(10, 0, 0), event(40, 0, 0)]))
                .statistics
        };
        let statistics = read(10);
        assert_eq!(statistics.latency.unwrap().max.0, 25_000_000);
        // From 10 to 82 without a pause.
        assert_eq!(statistics.stages[0].busy, 1.0);
        let statistics = read(0);
        assert_eq!(statistics.latency.unwrap().max.0, 1_000_000);
        assert_eq!(statistics.stages[0].busy, 36.0 / 48.0);
    }
}
