//! Events as a list, in order of time: within a pair of frames, ties row by row, then by channel.

use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use crate::{
    event::{Event, Packet, Polarity},
    number::Real,
    sensor::SensorError,
    unit::Micros,
};

use super::train::{BandSink, Pair, Sink, TrainRow};

/// What to do when a list would grow beyond its bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WhenFull {
    /// Stop with an error.
    #[default]
    Stop,
    /// Drop further events and count them in [`crate::event::Dropped::over_limit`].
    Drop,
}

/// A bound on the length of an event list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// How many events a packet may hold.
    pub events: usize,
    /// What happens beyond.
    pub when_full: WhenFull,
}

impl Default for Limit {
    /// A hundred million events, 1.6 GB, then an error.
    fn default() -> Self {
        Self {
            events: 100_000_000,
            when_full: WhenFull::Stop,
        }
    }
}

/// Appends trains to a packet as single events.
///
/// A pair of frames whose events do not all fit is an error, or is dropped whole: which
/// events are missing must not depend on how the work was shared out.
///
/// Each band of rows makes its events in order of row, column and channel, and deals them out
/// to stretches of time; the events of a stretch are then sorted by counting.
#[derive(Debug)]
pub struct EventList<'a> {
    packet: &'a mut Packet,
    limit: Limit,
    clock: Clock,
    parts: Vec<Part>,
}

/// What one band of rows has said in the current pair.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    clock: Clock,
    /// How many events fit.
    room: u64,
    /// How many there are.
    total: u64,
    row: Row,
    /// The events of each stretch of time, row by row.
    stretches: Vec<Vec<Event>>,
}

/// The part of a list that one band of rows is told to.
#[derive(Debug)]
pub struct ListBand<'a>(&'a mut Part);

impl<'a> EventList<'a> {
    /// A list that goes on where the packet ends. It may be told of many pairs, and then
    /// makes their events in the same buffers.
    pub const fn new(packet: &'a mut Packet, limit: Limit) -> Self {
        Self::with_parts(packet, limit, Vec::new())
    }

    /// The same, in buffers that were used before.
    pub(super) const fn with_parts(packet: &'a mut Packet, limit: Limit, parts: Vec<Part>) -> Self {
        Self {
            packet,
            limit,
            clock: Clock::NONE,
            parts,
        }
    }

    pub(super) fn into_parts(self) -> Vec<Part> {
        self.parts
    }

    fn room(&self) -> u64 {
        self.limit.events.saturating_sub(self.packet.events.len()) as u64
    }

    /// Appends the events of all parts in order: by time, then row, column, channel.
    fn sort(&mut self) {
        let (clock, parts) = (self.clock, &self.parts);
        let length = |stretch: usize| {
            let events = |part: &Part| part.stretches[stretch].len();
            parts.iter().map(events).sum()
        };
        let lengths: Vec<usize> = (0..clock.stretches).map(length).collect();
        let events = &mut self.packet.events;
        let start = events.len();
        let any = Cell(0).at(Micros(0));
        events.resize(start + lengths.iter().sum::<usize>(), any);
        let mut fresh = &mut events[start..];
        let mut jobs = Vec::with_capacity(lengths.len());
        for (stretch, length) in lengths.into_iter().enumerate() {
            let (out, rest) = fresh.split_at_mut(length);
            jobs.push((stretch, out));
            fresh = rest;
        }
        let one = |next: &mut Vec<u32>, (stretch, out): (usize, &mut [Event])| {
            let told = || parts.iter().flat_map(|part| &part.stretches[stretch]);
            clock.sort(told, stretch, next, out);
        };
        if jobs.len() == 1 {
            for job in jobs {
                one(&mut Vec::new(), job);
            }
        } else {
            jobs.into_par_iter().for_each_init(Vec::new, one);
        }
    }
}

impl Sink for EventList<'_> {
    type Band<'b>
        = ListBand<'b>
    where
        Self: 'b;

    fn wants_times(&self) -> bool {
        true
    }

    fn begin(&mut self, pair: Pair, bands: &[Range<usize>]) -> Vec<ListBand<'_>> {
        // As many events as last time, in stretches that fit into cache.
        let total: u64 = self.parts.iter().map(|part| part.total).sum();
        let shared = bands.len() > 1 && !super::alone();
        let least = if shared { 16 } else { 1 };
        self.clock = Clock::of(pair, (total / CACHED).clamp(least, 256));
        let room = self.room();
        self.parts.resize_with(bands.len(), Part::default);
        for part in &mut self.parts {
            part.begin(self.clock, room);
        }
        self.parts.iter_mut().map(ListBand).collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        let total: u64 = self.parts.iter().map(|part| part.total).sum();
        if total > self.room() {
            return match self.limit.when_full {
                WhenFull::Stop => Err(SensorError::ListFull {
                    limit: self.limit.events,
                }),
                WhenFull::Drop => {
                    self.packet.dropped.over_limit += total;
                    Ok(())
                }
            };
        }
        for part in &mut self.parts {
            part.deal();
        }
        self.sort();
        Ok(())
    }
}

impl BandSink for ListBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        let part = &mut *self.0;
        let events = row.events();
        part.total = part.total.saturating_add(events);
        // What does not fit is not kept: a single cell may say 2^30 events.
        if part.total > part.room {
            return Ok(());
        }
        if part.row.y != row.y {
            part.deal();
        }
        part.row.take(row, events as usize);
        Ok(())
    }
}

impl Part {
    fn begin(&mut self, clock: Clock, room: u64) {
        (self.clock, self.room, self.total) = (clock, room, 0);
        self.row.clear();
        self.stretches.resize_with(clock.stretches, Vec::new);
        for stretch in &mut self.stretches {
            stretch.clear();
        }
    }

    /// Deals the events of the row out to the stretches of time.
    fn deal(&mut self) {
        let Self {
            row,
            clock,
            stretches,
            ..
        } = self;
        row.merge();
        let (times, cells) = row.timed(clock);
        let events = times
            .iter()
            .zip(cells)
            .map(|(t, cell)| clock.event(*t, *cell));
        if let [all] = &mut stretches[..] {
            all.extend(events);
        } else {
            for (event, t) in events.zip(times) {
                stretches[clock.stretch(*t)].push(event);
            }
        }
        row.clear();
    }
}

/// Whose event it is: column, row, sign and channel, as they lie in an [`Event`].
#[derive(Clone, Copy, Debug, Default)]
struct Cell(u64);

impl Cell {
    fn of<R: Real>(row: &TrainRow<R>, x: u32) -> Self {
        let on = u64::from(row.counts[x as usize] > 0);
        Self(u64::from(x) | (row.y as u64) << 16 | on << 32 | (row.channel as u64) << 40)
    }

    const fn at(self, t: Micros) -> Event {
        Event {
            t,
            x: self.0 as u16,
            y: (self.0 >> 16) as u16,
            polarity: if (self.0 >> 32) & 1 == 1 {
                Polarity::On
            } else {
                Polarity::Off
            },
            channel: (self.0 >> 40) as u8,
        }
    }
}

/// The events of one row, all channels.
#[derive(Clone, Debug, Default)]
struct Row {
    y: usize,
    width: usize,
    /// How often it was told.
    told: usize,
    /// How many trains there are, the column of each, and how many events; the buffers are
    /// longer.
    trains: usize,
    columns: Vec<u32>,
    counts: Vec<u32>,
    /// How many events there are.
    len: usize,
    /// Where between the two frames each of them lies, and whose it is.
    places: Vec<f64>,
    cells: Vec<Cell>,
    times: Vec<u64>,
    /// For merging: where the next train of each column goes, where each event goes, and the
    /// events in order.
    next: Vec<u32>,
    target: Vec<u32>,
    merged: (Vec<f64>, Vec<Cell>),
}

/// Events of a train that are written at a time, whether there are as many or fewer.
const FEW: usize = 4;

impl Row {
    fn clear(&mut self) {
        (self.len, self.trains, self.told) = (0, 0, 0);
    }

    /// Adds the events of a row of trains.
    fn take<R: Real>(&mut self, row: &TrainRow<R>, events: usize) {
        self.y = row.y;
        self.told += 1;
        // Room for a few more than there are.
        let room = self.len + events + FEW;
        if self.places.len() < room {
            self.places.resize(room, 0.0);
            self.cells.resize(room, Cell::default());
        }
        let most = self.trains + row.counts.len();
        if self.columns.len() < most {
            self.columns.resize(most, 0);
            self.counts.resize(most, 0);
        }
        let columns = &mut self.columns[self.trains..];
        let fired = fired(&row.counts, columns);
        expand(
            row,
            &columns[..fired],
            &mut self.counts[self.trains..],
            &mut self.places[self.len..],
            &mut self.cells[self.len..],
        );
        self.trains += fired;
        self.len += events;
        self.width = row.counts.len();
    }

    /// Puts the events into order of column where several channels, or one several times, have
    /// told of this row.
    fn merge(&mut self) {
        if self.told < 2 {
            return;
        }
        self.next.clear();
        self.next.resize(self.width, 0);
        let columns = &self.columns[..self.trains];
        let counts = &self.counts[..self.trains];
        for (x, count) in columns.iter().zip(counts) {
            self.next[*x as usize] += count;
        }
        starts(&mut self.next);
        let room = self.places.len();
        self.target.resize(room, 0);
        let mut len = 0;
        for (x, count) in columns.iter().zip(counts) {
            let next = &mut self.next[*x as usize];
            let few: [u32; FEW] = std::array::from_fn(|i| *next + i as u32);
            self.target[len..len + FEW].copy_from_slice(&few);
            for i in FEW..*count as usize {
                self.target[len + i] = *next + i as u32;
            }
            *next += count;
            len += *count as usize;
        }
        let (places, cells) = &mut self.merged;
        places.resize(room, 0.0);
        cells.resize(room, Cell::default());
        let events = self.places.iter().zip(&self.cells);
        for (target, (place, cell)) in self.target[..self.len].iter().zip(events) {
            places[*target as usize] = *place;
            cells[*target as usize] = *cell;
        }
        std::mem::swap(&mut self.places, places);
        std::mem::swap(&mut self.cells, cells);
    }

    /// Times and cells of the events.
    fn timed(&mut self, clock: &Clock) -> (&[u64], &[Cell]) {
        if self.times.len() < self.len {
            self.times.resize(self.len, 0);
        }
        microseconds(clock, &self.places[..self.len], &mut self.times);
        (&self.times[..self.len], &self.cells[..self.len])
    }
}

/// The columns that have a train, in order; how many. No branch depends on the events.
fn fired(counts: &[i32], out: &mut [u32]) -> usize {
    let mut fired = 0;
    for (x, count) in counts.iter().enumerate() {
        out[fired] = x as u32;
        fired += usize::from(*count != 0);
    }
    fired
}

/// The events of the trains in these columns: how many each has, their places, and whose they
/// are.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn expand<R: Real>(
    row: &TrainRow<R>,
    columns: &[u32],
    counts: &mut [u32],
    places: &mut [f64],
    cells: &mut [Cell],
) {
    let mut len = 0;
    for (&x, events) in columns.iter().zip(counts) {
        let cell = Cell::of(row, x);
        let (first, spacing) = (row.first[x as usize], row.spacing[x as usize]);
        let (first, spacing) = (first.to_f64(), spacing.to_f64());
        let few: [f64; FEW] = std::array::from_fn(|i| first + spacing * i as f64);
        *events = row.counts[x as usize].unsigned_abs();
        let count = *events as usize;
        places[len..len + FEW].copy_from_slice(&few);
        cells[len..len + FEW].copy_from_slice(&[cell; FEW]);
        for i in FEW..count {
            places[len + i] = first + spacing * i as f64;
            cells[len + i] = cell;
        }
        len += count;
    }
}

/// From counts to where each begins.
fn starts(counts: &mut [u32]) {
    let mut sum = 0;
    for place in counts {
        sum += std::mem::replace(place, sum);
    }
}

/// From places between two frames to microseconds.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    /// The last whole microsecond not after the earlier frame.
    start: u64,
    /// From there to the earlier frame, in microseconds.
    fraction: f64,
    /// From the earlier frame to the later, in microseconds.
    duration: f64,
    /// How many stretches of time the pair is cut into, at least one.
    stretches: usize,
    /// Each is so many powers of two of a microsecond long, the last what is left.
    shift: u32,
    /// Microseconds from the start to the later frame.
    span: u64,
}

/// Events that one thread sorts at a time, about: as many as a cache holds.
const CACHED: u64 = 1 << 17;

/// 2^52: the first double after which there are no fractions.
const MAGIC: f64 = 4_503_599_627_370_496.0;

impl Clock {
    const NONE: Self = Self {
        start: 0,
        fraction: 0.0,
        duration: 0.0,
        stretches: 1,
        shift: 0,
        span: 0,
    };

    fn of(pair: Pair, stretches: u64) -> Self {
        let from = pair.from * 1e6;
        let clock = Self {
            start: from.floor() as u64,
            fraction: from - from.floor().max(0.0),
            // Seventy years.
            duration: (pair.duration() * 1e6).min(MAGIC / 2.0),
            ..Self::NONE
        };
        let span = clock.at(1.0);
        let shift = (span / stretches + 1).next_power_of_two().ilog2();
        Self {
            span,
            shift,
            stretches: (span >> shift) as usize + 1,
            ..clock
        }
    }

    /// Microseconds from the start to the nearest to a place; none before time 0.
    #[inline]
    fn at(&self, place: f64) -> u64 {
        let place = if place < 1.0 { place } else { 1.0 };
        let since = self.fraction + place * self.duration;
        let since = if since > 0.0 { since } else { 0.0 };
        // Added to 2^52, the nearest whole number stands in the lowest bits.
        (since + MAGIC).to_bits() - MAGIC.to_bits()
    }

    /// The stretch that a time lies in.
    const fn stretch(&self, t: u64) -> usize {
        (t >> self.shift) as usize
    }

    fn event(&self, t: u64, cell: Cell) -> Event {
        cell.at(Micros(self.start.saturating_add(t)))
    }

    /// Sorts the events of one stretch, which come in order of row, column and channel.
    fn sort<'a, I: Iterator<Item = &'a Event>>(
        &self,
        told: impl Fn() -> I,
        stretch: usize,
        next: &mut Vec<u32>,
        out: &mut [Event],
    ) {
        let since = (stretch as u64) << self.shift;
        let bins = (self.span - since).min((1 << self.shift) - 1) + 1;
        if bins > 4 * out.len() as u64 {
            for (out, event) in out.iter_mut().zip(told()) {
                *out = *event;
            }
            out.sort_by_key(|event| event.t);
            return;
        }
        let from = self.start.saturating_add(since);
        next.clear();
        next.resize(bins as usize, 0);
        told().for_each(|event| next[(event.t.0 - from) as usize] += 1);
        starts(next);
        told().for_each(|event| {
            let place = &mut next[(event.t.0 - from) as usize];
            out[*place as usize] = *event;
            *place += 1;
        });
    }
}

/// Microseconds from the clock's start to each of the places.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn microseconds(clock: &Clock, places: &[f64], out: &mut [u64]) {
    for (out, place) in out.iter_mut().zip(places) {
        *out = clock.at(*place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Size;
    use proptest::prelude::*;

    fn told(
        rows: &[Vec<i8>],
        pair: Pair,
        limit: Limit,
        packet: &mut Packet,
    ) -> Result<(), SensorError> {
        let mut list = EventList::new(packet, limit);
        let bands: Vec<_> = (0..rows.len()).map(|y| y..y + 1).collect();
        for (y, (mut band, counts)) in list.begin(pair, &bands).into_iter().zip(rows).enumerate() {
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
    fn one_by_one(rows: &[TrainRow<f64>], pair: Pair) -> Vec<Event> {
        let mut events = Vec::new();
        for row in rows {
            for (x, train) in row.trains() {
                for i in 0..train.count {
                    events.push(Event {
                        t: Micros::from_seconds(pair.from + train.at(i) * pair.duration()),
                        x: x as u16,
                        y: row.y as u16,
                        polarity: train.polarity,
                        channel: row.channel as u8,
                    });
                }
            }
        }
        events.sort_by_key(|e| (e.t, e.y, e.x, e.channel));
        events
    }

    proptest! {
        /// Several channels, rows that are told again, short pairs and long, few events and
        /// many, one thread and two.
        #[test]
        fn events_are_in_order(
            counts in proptest::collection::vec(proptest::collection::vec(-9i32..10, 7), 12),
            sparse: bool,
            channels in 1usize..4,
            index in 0u32..1000,
            duration in proptest::sample::select(vec![1e-6, 7e-4, 1.0 / 240.0, 3.0, 1e5]),
        ) {
            // Each row is told by each channel in turn, and the last channel tells it again.
            let told = channels + 1;
            let rows: Vec<TrainRow<f64>> = counts.iter().enumerate().map(|(n, counts)| {
                let keep = |x: usize| i32::from(!sparse || (n + x).is_multiple_of(5));
                TrainRow {
                    channel: (n % told).min(channels - 1),
                    y: n / told,
                    counts: counts.iter().enumerate().map(|(x, count)| count * keep(x)).collect(),
                    first: (0..7).map(|x| (x * 7 % 10 + n) as f64 / 30.0).collect(),
                    spacing: vec![1.0 / 37.0; 7],
                }
            }).collect();
            let pair = Pair { index: index.into(), from: f64::from(index) * duration, to: f64::from(index + 1) * duration };
            let slow = one_by_one(&rows, pair);
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut packet = Packet::new(Size::new(12, 7), 1);
                let bands: Vec<_> = (0..12).map(|y| y..y + 1).collect();
                let told_twice = pool.install(|| {
                    let mut list = EventList::new(&mut packet, Limit::default());
                    for _ in 0..2 {
                        let mut parts = list.begin(pair, &bands);
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
                    prop_assert!(fast.is_sorted_by_key(|e| (e.t, e.y, e.x, e.channel)));
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
        let pair = Pair {
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
        let full = told(&rows, pair, limit(WhenFull::Stop), &mut packet);
        assert!(matches!(full, Err(SensorError::ListFull { limit: 8 })));
        told(&rows, pair, limit(WhenFull::Drop), &mut packet).unwrap();
        assert_eq!((packet.events.len(), packet.dropped.over_limit), (0, 9));
        told(&[vec![1, -1]], pair, limit(WhenFull::Drop), &mut packet).unwrap();
        assert_eq!(packet.events.len(), 2);
        assert_eq!(packet.events[1].polarity, Polarity::Off);
    }
}
