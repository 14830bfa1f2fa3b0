//! A link that sends frames: each takes as long, whether or not there are events in it.

use super::{
    statistics::Stage,
    time::{picos, span_start},
};
use crate::{event::Packet, unit::Micros};

/// The link: frames are sent one after the other. With a period there is a frame at each of its
/// multiples, from the first time watched to the last, empty ones included; without, each time
/// stamp of the packet is one.
pub(super) struct Link {
    /// Microseconds; 0 when only frames with events are sent.
    period: u64,
    /// Picoseconds that a frame takes.
    frame: u128,
    /// Number of the frame that is sent next.
    next: u64,
    free: u128,
    busy: u128,
}

impl Link {
    /// For frames of `packet`, `frame` picoseconds each.
    pub(super) fn new(period: Micros, frame: u128, packet: &Packet) -> Self {
        Self {
            period: period.0,
            frame,
            next: span_start(packet).0.div_ceil(period.0.max(1)),
            free: 0,
            busy: 0,
        }
    }

    /// Sends the frame that ends at `stamp`, after the empty ones before it; returns its arrival.
    pub(super) fn send(&mut self, stamp: Micros) -> u128 {
        if let Some(number) = stamp.0.checked_div(self.period) {
            self.skip(number.saturating_sub(self.next));
            self.next = number.saturating_add(1);
        }
        self.free = self.free.max(picos(stamp)).saturating_add(self.frame);
        self.busy = self.busy.saturating_add(self.frame);
        self.free
    }

    /// Sends the empty frames up to `end`.
    pub(super) fn idle_until(&mut self, end: Micros) {
        if self.period > 0 {
            let last = end.0.div_ceil(self.period);
            self.skip(last.saturating_add(1).saturating_sub(self.next));
        }
    }

    /// When it has sent all.
    pub(super) const fn free(&self) -> u128 {
        self.free
    }

    /// As a stage, in which at most `most` events were at once.
    pub(super) const fn stage(&self, name: &'static str, most: u64) -> Stage {
        Stage::new(name, self.busy, most)
    }

    /// The next `n` frames are empty. Each begins when it has ended and the one before it has
    /// been sent; the last is done when the slowest of three chains is: all of them behind what
    /// went before, all behind the end of the first, or the last alone behind its own end.
    fn skip(&mut self, n: u64) {
        if n == 0 {
            return;
        }
        let end = |number: u64| picos(Micros(number.saturating_mul(self.period)));
        let all = self.frame.saturating_mul(n.into());
        let last = self.next.saturating_add(n - 1);
        self.free = (self.free.saturating_add(all))
            .max(end(self.next).saturating_add(all))
            .max(end(last).saturating_add(self.frame));
        self.busy = self.busy.saturating_add(all);
        self.next = last.saturating_add(1);
    }
}
