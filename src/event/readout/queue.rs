//! A queue in front of a link that sends one event after the other.

use std::collections::VecDeque;

/// What happens to an event that finds the queue full.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WhenFull {
    /// The arbiter waits until there is room: the handshake of AER. Nothing is lost, the cells
    /// wait longer.
    #[default]
    Stall,
    /// The event that comes is lost.
    DropNewest,
    /// The event that has waited longest is lost, and the one that comes takes its place.
    DropOldest,
}

/// The queue and the link, in picoseconds; events are known by their number.
#[derive(Debug)]
pub(super) struct Queue {
    /// How many may wait, besides the one being sent; `None` for any number.
    depth: Option<u64>,
    when_full: WhenFull,
    /// Time to send one event.
    link: u128,
    waiting: VecDeque<usize>,
    /// When the link is free again.
    free: u128,
    /// Arrival and number of what was sent.
    pub sent: Vec<(u128, usize)>,
    pub dropped: u64,
    /// The most that waited at once.
    pub most: u64,
}

impl Queue {
    pub fn new(depth: Option<u64>, when_full: WhenFull, link: u64) -> Self {
        Self {
            depth,
            when_full,
            link: link.into(),
            waiting: VecDeque::new(),
            free: 0,
            sent: Vec::new(),
            dropped: 0,
            most: 0,
        }
    }

    /// Takes an event at `now`, no earlier than the one before; returns the time at which it was
    /// taken, later than `now` only when it had to wait for room.
    pub fn take(&mut self, now: u128, event: usize) -> u128 {
        self.go_on(now);
        if self.waiting.is_empty() && self.free <= now {
            self.send(now, event);
            return now;
        }
        if self.depth.is_none_or(|d| (self.waiting.len() as u64) < d) {
            self.wait(event);
            return now;
        }
        match self.when_full {
            WhenFull::Stall => {
                // At that moment there is room, or the link itself is free.
                let room = self.free;
                self.take(room, event)
            }
            WhenFull::DropNewest => {
                self.dropped += 1;
                now
            }
            WhenFull::DropOldest => {
                self.dropped += 1;
                // Without any room to wait, the one that comes is the one that has waited longest.
                if self.waiting.pop_front().is_some() {
                    self.wait(event);
                }
                now
            }
        }
    }

    /// Sends all that still waits.
    pub fn finish(&mut self) {
        while let Some(event) = self.waiting.pop_front() {
            self.send(self.free, event);
        }
    }

    /// How long the link was busy.
    pub fn busy(&self) -> u128 {
        self.sent.len() as u128 * self.link
    }

    /// Sends the events whose turn comes up to `now`.
    fn go_on(&mut self, now: u128) {
        while self.free <= now
            && let Some(event) = self.waiting.pop_front()
        {
            self.send(self.free, event);
        }
    }

    fn send(&mut self, start: u128, event: usize) {
        self.free = start + self.link;
        self.sent.push((self.free, event));
    }

    fn wait(&mut self, event: usize) {
        self.waiting.push_back(event);
        self.most = self.most.max(self.waiting.len() as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One event each at 0, 1, 2, 3; the link takes 10.
    fn four(depth: Option<u64>, when_full: WhenFull) -> (Vec<u128>, Vec<(u128, usize)>, u64) {
        let mut queue = Queue::new(depth, when_full, 10);
        let mut now = 0;
        let taken = (0..4)
            .map(|i| {
                now = queue.take(now.max(i as u128), i);
                now
            })
            .collect();
        queue.finish();
        (taken, queue.sent, queue.dropped)
    }

    #[test]
    fn a_full_queue_does_what_it_says() {
        let all = vec![(10, 0), (20, 1), (30, 2), (40, 3)];
        assert_eq!(
            four(None, WhenFull::DropNewest),
            (vec![0, 1, 2, 3], all.clone(), 0)
        );
        assert_eq!(
            four(Some(1), WhenFull::Stall),
            (vec![0, 1, 10, 20], all.clone(), 0)
        );
        assert_eq!(
            four(Some(0), WhenFull::Stall),
            (vec![0, 10, 20, 30], all, 0)
        );
        let taken = vec![0, 1, 2, 3];
        let newest = vec![(10, 0), (20, 1)];
        assert_eq!(
            four(Some(1), WhenFull::DropNewest),
            (taken.clone(), newest, 2)
        );
        let oldest = vec![(10, 0), (20, 3)];
        assert_eq!(
            four(Some(1), WhenFull::DropOldest),
            (taken.clone(), oldest, 2)
        );
        assert_eq!(
            four(Some(0), WhenFull::DropOldest),
            (taken, vec![(10, 0)], 3)
        );
    }
}
