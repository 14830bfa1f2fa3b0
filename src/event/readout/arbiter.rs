//! Row-column arbitration, a queue, a link: how address events leave most event cameras.
//!
//! ```text
//!  cells ──request──► row arbiter ─► row latched ─► columns one by one ─► queue ─► link ─► packet
//!    one request each    `row`        (burst)         `event` each       `fifo`   `link`
//! ```
//!
//! * A cell that fires raises its request and holds it until it has been read; what it fires
//!   meanwhile, of either sign, is `merged` into that one request, which keeps the sign that
//!   raised it ([`Requests::One`]), or waits its turn ([`Requests::All`], where a model makes
//!   several events at once).
//! * The arbiter chooses a row that has requests, which takes the time `row`. With `burst` all
//!   requests of the row at the end of that time are latched and read column by column, `event`
//!   each (word-serial: the row is sent once); without, only the one that has waited longest.
//!   A cell's request falls when its event has been read and has found a place in the queue.
//! * The link takes `link` for each event; `fifo` events may wait for it. A full queue stalls
//!   the arbiter, or loses the newest or the oldest event (`queue_full`).
//! * The event arrives when the link has sent it. The receiver's clock then stamps it: the
//!   packet has the last whole microsecond of that time, and the latency is from firing to
//!   arrival.
//!
//! With single events served in their order, from many cells that fire at random, this is the
//! queue M/D/1, whose mean wait before service is `rho D / (2 (1 - rho))` for service time `D`
//! and load `rho` (Pollaczek and Khinchin): 0.06, 0.5, 2, 9.5 times `D` at loads 0.1, 0.5, 0.8,
//! 0.95. `tests/packets.rs` holds it to that, and to a twin that goes tick by tick.
//!
//! Not modelled: the time of the arbiter tree depending on which row came before, and analogue
//! effects of a held request on its cell.

use std::collections::{BTreeMap, BTreeSet, HashSet, VecDeque};

use super::{
    ReadOut, Statistics, WhenFull,
    queue::Queue,
    statistics::{Latencies, Stage},
    time::{micros, picos},
};
use crate::{
    event::{Dropped, Event, Packet},
    unit::Picos,
};

/// What a cell's request stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Requests {
    /// One event: what the cell fires before it is read, of either sign, is merged into it.
    #[default]
    One,
    /// Every event waits its turn.
    All,
}

/// Which row is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowOrder {
    /// The one whose request has waited longest.
    #[default]
    Oldest,
    /// The next one below the last, around: what a fair tree comes close to under load.
    Round,
}

/// An arbiter with its times and rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arbiter {
    /// Time to choose a row.
    pub row: Picos,
    /// Time to read one event of it.
    pub event: Picos,
    /// Whether all requests of a row are read when it is chosen.
    pub burst: bool,
    /// Which row is chosen.
    pub order: RowOrder,
    /// What a cell's request stands for.
    pub requests: Requests,
    /// Time to send one event.
    pub link: Picos,
    /// Events that may wait for the link; `None` for any number.
    pub fifo: Option<u64>,
    /// What happens to an event that finds the queue full.
    pub when_full: WhenFull,
}

impl Arbiter {
    /// Reads a packet out: what arrives, and its statistics.
    #[must_use]
    pub fn read(&self, packet: &Packet) -> ReadOut {
        let mut cells = Cells::new(&packet.events, self.requests);
        let mut queue = Queue::new(self.fifo, self.when_full, self.link.0);
        let (mut now, mut busy, mut last) = (0, 0, None);
        loop {
            cells.fire_until(now);
            let Some(row) = cells.choose(self.order, last) else {
                match cells.next_firing() {
                    Some(t) => now = t,
                    None => break,
                }
                continue;
            };
            last = Some(row);
            now += u128::from(self.row.0);
            busy += u128::from(self.row.0);
            cells.fire_until(now);
            for event in cells.latch(row, self.burst) {
                now += u128::from(self.event.0);
                busy += u128::from(self.event.0);
                now = queue.take(now, event);
                cells.fire_until(now);
                cells.acknowledge(event);
            }
        }
        queue.finish();
        let mut out = Vec::with_capacity(queue.sent.len());
        let mut latencies = Latencies::new(packet);
        for (at, event) in &queue.sent {
            if let Some(e) = packet.events.get(*event) {
                latencies.push(e.t, *at);
                let t = micros(*at);
                out.push(Event { t, ..*e });
            }
        }
        let dropped = Dropped {
            queue_full: queue.dropped,
            merged: cells.merged,
            ..Dropped::default()
        };
        let end = queue.sent.last().map_or(now, |(at, _)| now.max(*at));
        let stages = vec![
            Stage::new("arbiter", busy, cells.most),
            Stage::new("link", queue.busy(), queue.most),
        ];
        let statistics = Statistics::new("arbiter", packet, dropped, &latencies, stages, end);
        ReadOut::new(packet, out, statistics)
    }
}

/// The cells' pending requests. Events are known by their index, which is also their age.
struct Cells<'a> {
    events: &'a [Event],
    requests: Requests,
    /// The event that fires next.
    next: usize,
    /// Requests by row, in the order in which they were raised; no row is empty.
    rows: BTreeMap<u16, VecDeque<usize>>,
    /// The oldest request of each row.
    heads: BTreeSet<(usize, u16)>,
    /// Cells whose request is pending, when a request stands for one event.
    up: HashSet<(u16, u16, u8)>,
    waiting: u64,
    most: u64,
    merged: u64,
}

impl<'a> Cells<'a> {
    fn new(events: &'a [Event], requests: Requests) -> Self {
        Self {
            events,
            requests,
            next: 0,
            rows: BTreeMap::new(),
            heads: BTreeSet::new(),
            up: HashSet::new(),
            waiting: 0,
            most: 0,
            merged: 0,
        }
    }

    fn next_firing(&self) -> Option<u128> {
        self.events.get(self.next).map(|e| picos(e.t))
    }

    /// Raises the requests of all events up to `now`, that moment included.
    fn fire_until(&mut self, now: u128) {
        while let Some(e) = self.events.get(self.next)
            && picos(e.t) <= now
        {
            let number = self.next;
            self.next += 1;
            if self.requests == Requests::One && !self.up.insert((e.y, e.x, e.channel)) {
                self.merged += 1;
                continue;
            }
            let row = self.rows.entry(e.y).or_default();
            if row.is_empty() {
                self.heads.insert((number, e.y));
            }
            row.push_back(number);
            self.waiting += 1;
            self.most = self.most.max(self.waiting);
        }
    }

    fn choose(&self, order: RowOrder, last: Option<u16>) -> Option<u16> {
        match order {
            RowOrder::Oldest => self.heads.first().map(|(_, row)| *row),
            RowOrder::Round => {
                let below = last.and_then(|last| last.checked_add(1)).unwrap_or(0);
                let mut after = self.rows.range(below..);
                after
                    .next()
                    .or_else(|| self.rows.first_key_value())
                    .map(|(row, _)| *row)
            }
        }
    }

    /// Takes the requests of a row that are read now, by column.
    fn latch(&mut self, row: u16, burst: bool) -> Vec<usize> {
        let Some(mut waiting) = self.rows.remove(&row) else {
            return Vec::new();
        };
        if let Some(head) = waiting.front() {
            self.heads.remove(&(*head, row));
        }
        let taken = if burst { waiting.len() } else { 1 };
        let mut latched: Vec<usize> = waiting.drain(..taken.min(waiting.len())).collect();
        if let Some(head) = waiting.front() {
            self.heads.insert((*head, row));
            self.rows.insert(row, waiting);
        }
        let events = self.events;
        latched.sort_by_key(|i| events.get(*i).map(|e| (e.x, e.channel, *i)));
        latched
    }

    /// Clears a cell's request.
    fn acknowledge(&mut self, event: usize) {
        self.waiting = self.waiting.saturating_sub(1);
        if let Some(e) = self.events.get(event) {
            self.up.remove(&(e.y, e.x, e.channel));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::{
        Polarity,
        readout::testing::{event, packet},
    };

    fn arbiter() -> Arbiter {
        let us = |n: u64| Picos(n * 1_000_000);
        Arbiter {
            row: us(3),
            event: us(1),
            burst: true,
            order: RowOrder::Oldest,
            requests: Requests::One,
            link: us(0),
            fifo: None,
            when_full: WhenFull::Stall,
        }
    }

    fn arrivals(arbiter: Arbiter, events: &[(u64, u16, u16)]) -> Vec<(u64, u16, u16)> {
        let events: Vec<_> = events.iter().map(|(t, x, y)| event(*t, *x, *y)).collect();
        let read = arbiter.read(&packet(8, 8, &events));
        read.packet
            .events
            .iter()
            .map(|e| (e.t.0, e.x, e.y))
            .collect()
    }

    #[test]
    fn a_row_is_chosen_once_for_a_burst() {
        // Row 2 asks first. While it is chosen (10 to 13) column 1 joins; column 0 comes too
        // late for the burst. Row 1 has waited since 11, longer than column 0.
        let events = [(10, 5, 2), (11, 7, 1), (12, 1, 2), (14, 0, 2)];
        assert_eq!(
            arrivals(arbiter(), &events),
            [(14, 1, 2), (15, 5, 2), (19, 7, 1), (23, 0, 2)]
        );
        let single = Arbiter {
            burst: false,
            ..arbiter()
        };
        assert_eq!(
            arrivals(single, &events),
            [(14, 5, 2), (18, 7, 1), (22, 1, 2), (26, 0, 2)]
        );
    }

    #[test]
    fn rows_in_turn() {
        let round = Arbiter {
            order: RowOrder::Round,
            ..arbiter()
        };
        // After row 3 come 5 and then, around, 1, however long they have waited.
        let events = [(0, 0, 3), (1, 0, 1), (2, 0, 5)];
        let rows: Vec<_> = arrivals(round, &events).iter().map(|e| e.2).collect();
        assert_eq!(rows, [3, 5, 1]);
    }

    #[test]
    fn a_request_stands_for_one_event_until_it_is_read() {
        // Read at 4: what fires up to then is merged, of the other sign too.
        let mut events = [0, 2, 4, 5].map(|t| event(t, 0, 0));
        events[1].polarity = Polarity::Off;
        let read = arbiter().read(&packet(1, 1, &events));
        assert_eq!(read.packet.dropped.merged, 2);
        let times: Vec<_> = read.packet.events.iter().map(|e| e.t.0).collect();
        assert_eq!(times, [4, 9]);
        let all = Arbiter {
            requests: Requests::All,
            ..arbiter()
        };
        let read = all.read(&packet(1, 1, &events));
        assert_eq!(
            (read.packet.events.len(), read.packet.dropped.total()),
            (4, 0)
        );
    }

    #[test]
    fn arrivals_are_stamped_with_the_last_whole_microsecond() {
        let fast = Arbiter {
            row: Picos(36_000),
            event: Picos(36_000),
            ..arbiter()
        };
        let read = fast.read(&packet(4, 1, &[event(5, 0, 0), event(5, 1, 0)]));
        assert!(read.packet.events.iter().all(|e| e.t.0 == 5));
        let latency = read.statistics.latency.unwrap();
        assert_eq!((latency.p50.0, latency.max.0), (72_000, 108_000));
    }

    #[test]
    fn a_stage_falls_behind_where_events_are_lost_or_wait_longer_and_longer() {
        let behind = |arbiter: Arbiter, events: u64| {
            let events: Vec<_> = (0..events)
                .map(|t| event(t, t as u16 % 8, t as u16 / 8 % 8))
                .collect();
            let read = arbiter.read(&packet(8, 8, &events));
            let link = &read.statistics.stages[1];
            assert!(link.busy > 0.99);
            link.falls_behind
        };
        let slow = Arbiter {
            row: Picos(0),
            event: Picos(0),
            link: Picos(10_000_000),
            requests: Requests::All,
            ..arbiter()
        };
        // However slow, with whole rows at once or without: most of what waits is not in the queue.
        let links = [1_050_000, 10_000_000, u64::MAX / 4].map(Picos);
        for (link, burst) in links.into_iter().flat_map(|l| [(l, true), (l, false)]) {
            let slower = Arbiter {
                burst,
                link,
                ..slow
            };
            assert!(behind(slower, 300), "{link:?} {burst}");
        }
        // As fast as the events, it keeps up.
        let fast = Arbiter {
            link: Picos(999_000),
            ..slow
        };
        assert!(!behind(fast, 3000));
        let full = Arbiter {
            fifo: Some(2),
            when_full: WhenFull::DropNewest,
            ..slow
        };
        assert!(behind(full, 300));
        assert!(!behind(slow, 1));
    }
}
