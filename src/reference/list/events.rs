//! The list of events as a sink: bands pack their events, which are then sorted interval by
//! interval.

use std::{
    ops::Range,
    sync::atomic::{AtomicU64, Ordering},
};

use crate::{
    event::{Event, Packet},
    number::Real,
    plane::{At, Size},
    reference::{
        sinks::check_shape,
        train::{BandSink, Interval, Sink, TrainRow},
    },
    sensor::SensorError,
};

use super::{
    buffers::Buffers,
    limit::{Limit, WhenFull},
    part::Part,
    time_quantiser::TimeQuantiser,
};

/// Appends trains to a packet as single events.
///
/// An interval whose events do not all fit is an error, or is dropped whole: which events are
/// missing must not depend on how the work was divided between threads.
///
/// Each band of rows packs its events into 8 bytes each as they come. They are sorted by a counting
/// sort, which is stable: what happens in the same microsecond stays in the order in which it came.
/// It sorts all at once, or, where there are more than a core's cache takes or several threads, in
/// slices of time.
#[derive(Debug)]
pub struct EventList<'a> {
    packet: &'a mut Packet,
    limit: Limit,
    /// How many events the packet may hold, whatever was passed on.
    held: usize,
    /// How many were passed on.
    passed: usize,
    /// What of the packet's sensor is watched, and where its first cell is in it.
    part: (Size, At),
    quantiser: TimeQuantiser,
    buffers: Buffers,
    /// How many events the interval has so far, in all bands.
    total: AtomicU64,
}

/// The sink of one band of rows.
#[derive(Debug)]
pub struct ListBand<'a> {
    part: &'a mut Part,
    total: &'a AtomicU64,
    room: u64,
}

impl<'a> EventList<'a> {
    /// A list that continues the packet. It may take many intervals, and reuses its buffers.
    pub fn new(packet: &'a mut Packet, limit: Limit) -> Self {
        Self::with_buffers(packet, limit, Buffers::default())
    }

    /// The same, in buffers that were used before.
    pub(in crate::reference) fn with_buffers(
        packet: &'a mut Packet,
        limit: Limit,
        buffers: Buffers,
    ) -> Self {
        Self {
            part: (packet.size, At { y: 0, x: 0 }),
            packet,
            limit,
            held: usize::MAX,
            passed: 0,
            quantiser: TimeQuantiser::default(),
            buffers,
            total: AtomicU64::new(0),
        }
    }

    pub(in crate::reference) fn into_buffers(self) -> Buffers {
        self.buffers
    }

    /// The list of which the packet holds so many events at most, those of a pair of frames; the
    /// others are [passed on](Self::pass).
    #[must_use]
    pub fn holding(self, held: usize) -> Self {
        Self { held, ..self }
    }

    /// The list of a sensor of this size that is a part of the packet's: its first cell is at
    /// `corner` there, if it is not the packet's first.
    #[must_use]
    pub fn of_part(self, size: Size, corner: Option<At>) -> Self {
        let part = (size, corner.unwrap_or(At { y: 0, x: 0 }));
        Self { part, ..self }
    }

    /// Gives the events in the packet to `to`, and takes them out; they still count against the
    /// limit.
    ///
    /// # Errors
    /// What `to` says.
    pub fn pass<E>(&mut self, to: impl FnOnce(&[Event]) -> Result<(), E>) -> Result<(), E> {
        to(&self.packet.events)?;
        self.passed = self.passed.saturating_add(self.packet.events.len());
        self.packet.events.clear();
        Ok(())
    }

    /// How many more events fit, and what is said where there are more.
    fn room(&self) -> (u64, SensorError) {
        let held = self.packet.events.len();
        let all = self.passed.saturating_add(held);
        let of_list = self.limit.events.saturating_sub(all);
        let of_pair = self.held.saturating_sub(held);
        if of_pair < of_list {
            return (of_pair as u64, SensorError::PairFull { room: self.held });
        }
        let limit = self.limit.events;
        (of_list as u64, SensorError::ListFull { limit })
    }

    /// Appends the events of all bands in order of time.
    fn sort(&mut self) {
        let (quantiser, events) = (self.quantiser, &mut self.packet.events);
        if quantiser.is_long() {
            let start = events.len();
            for part in &mut self.buffers.parts {
                events.append(&mut part.events);
            }
            events[start..].sort_by_key(|event| event.t);
            return;
        }
        self.buffers.in_order(quantiser, events);
    }
}

impl Sink for EventList<'_> {
    type Band<'b>
        = ListBand<'b>
    where
        Self: 'b;

    fn check(&self, size: Size, channels: usize) -> Result<(), SensorError> {
        let own = (self.part.0, self.packet.channels.into());
        check_shape("a packet", own, (size, channels))
    }

    fn wants_times(&self) -> bool {
        true
    }

    fn begin(&mut self, interval: Interval, bands: &[Range<usize>]) -> Vec<ListBand<'_>> {
        self.quantiser = TimeQuantiser::new(interval);
        self.total = AtomicU64::new(0);
        let (room, _) = self.room();
        let (quantiser, total) = (self.quantiser, &self.total);
        let parts = &mut self.buffers.parts;
        parts.resize_with(bands.len(), Part::default);
        { parts.iter_mut() }
            .map(|part| {
                part.begin(quantiser);
                ListBand { part, total, room }
            })
            .collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        let total = *self.total.get_mut();
        let (room, full) = self.room();
        if total > room {
            return match self.limit.when_full {
                WhenFull::Stop => Err(full),
                WhenFull::Drop => {
                    self.packet.dropped.over_limit += total;
                    Ok(())
                }
            };
        }
        let before = self.packet.events.len();
        self.sort();
        let (_, At { y, x }) = self.part;
        if (y, x) != (0, 0) {
            for event in &mut self.packet.events[before..] {
                event.y += y as u16;
                event.x += x as u16;
            }
        }
        Ok(())
    }
}

impl BandSink for ListBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        // A single cell may have 2^30: what does not fit in all bands together is never held.
        let events = row.events();
        let before = self.total.fetch_add(events, Ordering::Relaxed);
        if before.saturating_add(events) <= self.room {
            self.part.take(row);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Polarity, unit::Micros};
    use proptest::prelude::*;

    fn told(
        rows: &[Vec<i8>],
        interval: Interval,
        limit: Limit,
        packet: &mut Packet,
    ) -> Result<(), SensorError> {
        let mut list = EventList::new(packet, limit);
        let bands: Vec<_> = (0..rows.len()).map(|y| y..y + 1).collect();
        for (y, (mut band, counts)) in list
            .begin(interval, &bands)
            .into_iter()
            .zip(rows)
            .enumerate()
        {
            let width = counts.len();
            band.row(&TrainRow::<f64> {
                channel: 0,
                y,
                counts: counts.iter().map(|c| i32::from(*c)).collect(),
                first: (0..width).map(|x| (x * 7 % 10) as f64 / 20.0).collect(),
                spacing: vec![1.0 / 256.0; width],
            })?;
        }
        list.end()
    }

    /// The slow twin: every event by itself, put into order by comparison.
    fn one_by_one(rows: &[TrainRow<f64>], interval: Interval) -> Vec<Event> {
        let mut events = Vec::new();
        for row in rows {
            for (x, train) in row.trains() {
                for i in 0..train.count {
                    events.push(Event {
                        t: Micros::from_seconds(interval.from + train.at(i) * interval.duration()),
                        x: x as u16,
                        y: row.y as u16,
                        polarity: train.polarity,
                        channel: row.channel as u8,
                    });
                }
            }
        }
        events.sort_by_key(|e| (e.t, e.y, e.channel, e.x));
        events
    }

    proptest! {
        /// Several channels, rows that are told again, trains that end after the pair, short
        /// pairs and long, few events and many, so many that threads share them, one thread and
        /// two.
        #[test]
        fn events_are_in_order(
            counts in proptest::collection::vec(proptest::collection::vec(-9i32..10, 70), 12),
            width in proptest::sample::select(vec![7, 70]),
            often in proptest::sample::select(vec![0, 1, 1, 30]),
            again: bool,
            channels in 1usize..4,
            index in 0u32..1000,
            duration in proptest::sample::select(vec![1e-6, 7e-4, 1.0 / 240.0, 3.0, 1e5]),
        ) {
            // Each row is told by each channel in turn, and the last channel may tell it again.
            let told = channels + usize::from(again);
            let rows: Vec<TrainRow<f64>> = counts.iter().enumerate().map(|(n, counts)| {
                let keep = |x: usize| often.max(i32::from((n + x).is_multiple_of(5)));
                TrainRow {
                    channel: (n % told).min(channels - 1),
                    y: n / told,
                    counts: counts[..width].iter().enumerate().map(|(x, count)| count * keep(x)).collect(),
                    first: (0..width).map(|x| (x * 7 % 10 + n) as f64 / 25.0).collect(),
                    spacing: vec![1.0 / 37.0 / f64::from(often.max(1)); width],
                }
            }).collect();
            let interval = Interval { index: index.into(), from: f64::from(index) * duration, to: f64::from(index + 1) * duration };
            let slow = one_by_one(&rows, interval);
            for threads in [1, 2, 5] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut packet = Packet::new(Size::new(12, width), 1);
                let bands: Vec<_> = (0..12).map(|y| y..y + 1).collect();
                let told_twice = pool.install(|| {
                    let mut list = EventList::new(&mut packet, Limit::default());
                    for _ in 0..2 {
                        let mut parts = list.begin(interval, &bands);
                        for row in &rows {
                            parts[row.y].row(row).unwrap();
                        }
                        drop(parts);
                        list.end().unwrap();
                    }
                    packet.events.len()
                });
                prop_assert_eq!(told_twice, 2 * slow.len());
                for fast in packet.events.chunks(slow.len().max(1)) {
                    prop_assert!(fast.is_sorted_by_key(|e| (e.t, e.y, e.channel)));
                    if !again {
                        prop_assert!(fast.is_sorted_by_key(|e| (e.t, e.y, e.channel, e.x)));
                    }
                    // Halves of a microsecond may be rounded either way, and the order with them.
                    let by_cell = |events: &[Event]| {
                        let mut events = events.to_vec();
                        events.sort_by_key(|e| (e.y, e.x, e.channel, e.polarity, e.t));
                        events
                    };
                    for (fast, slow) in by_cell(fast).iter().zip(by_cell(&slow)) {
                        prop_assert!(fast.t.0.abs_diff(slow.t.0) <= 1);
                        prop_assert_eq!(Event { t: slow.t, ..*fast }, slow);
                    }
                }
            }
        }
    }

    #[test]
    fn a_pair_that_does_not_fit_stops_or_is_dropped_whole() {
        let interval = Interval {
            index: 0,
            from: 0.0,
            to: 0.001,
        };
        let rows = vec![vec![3, -2], vec![0, 4]];
        let limit = |when_full| Limit {
            events: 8,
            when_full,
        };
        let mut packet = Packet::new(Size::new(2, 2), 1);
        let full = told(&rows, interval, limit(WhenFull::Stop), &mut packet);
        assert!(matches!(full, Err(SensorError::ListFull { limit: 8 })));
        told(&rows, interval, limit(WhenFull::Drop), &mut packet).unwrap();
        assert_eq!((packet.events.len(), packet.dropped.over_limit), (0, 9));
        told(&[vec![1, -1]], interval, limit(WhenFull::Drop), &mut packet).unwrap();
        assert_eq!(packet.events.len(), 2);
        assert_eq!(packet.events[1].polarity, Polarity::Off);
    }

    /// What was passed on is no longer held, but counts.
    #[test]
    fn what_is_passed_on_makes_room() {
        let mut packet = Packet::new(Size::new(1, 2), 1);
        let limit = Limit {
            events: 9,
            when_full: WhenFull::Stop,
        };
        let mut list = EventList::new(&mut packet, limit).holding(4);
        let mut passed = Vec::new();
        let mut tell = |list: &mut EventList<'_>, index: u64, counts: [i32; 2]| {
            let interval = Interval {
                index,
                from: index as f64,
                to: index as f64 + 1.0,
            };
            let mut row = TrainRow::<f64>::new(2);
            row.counts = counts.to_vec();
            list.begin(interval, std::slice::from_ref(&(0..1)))[0].row(&row)?;
            list.end()?;
            list.pass(|events| {
                passed.extend_from_slice(events);
                Ok(())
            })
        };
        let held = tell(&mut list, 0, [5, 0]);
        assert!(matches!(held, Err(SensorError::PairFull { room: 4 })));
        tell(&mut list, 1, [4, 0]).unwrap();
        tell(&mut list, 2, [-2, 2]).unwrap();
        let all = tell(&mut list, 3, [2, 0]);
        assert!(matches!(all, Err(SensorError::ListFull { limit: 9 })));
        assert_eq!((passed.len(), packet.events.len()), (8, 0));
        assert!(passed.is_sorted_by_key(|event| event.t));
    }
}
