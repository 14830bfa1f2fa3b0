//! Events as a list, in order of time: ties row by row, then by channel.

use std::ops::Range;

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
/// Each band of rows deals its events out to stretches of time; a stretch's events are then
/// sorted by counting. Both keep what they work on in cache, and both can be shared out.
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
        self.clock = Clock::of(pair);
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

impl EventList<'_> {
    /// Appends the events of all parts in order: by time, then row, column, channel.
    fn sort(&mut self) {
        let (clock, parts) = (self.clock, &self.parts);
        let events = &mut self.packet.events;
        let start = events.len();
        let lengths: Vec<usize> = (0..clock.stretches())
            .map(|stretch| parts.iter().map(|part| part.stretches[stretch].len()).sum())
            .collect();
        let Some(&any) = parts.iter().flat_map(|p| &p.stretches).flatten().next() else {
            return;
        };
        events.resize(start + lengths.iter().sum::<usize>(), any);
        let mut fresh = &mut events[start..];
        let mut jobs = Vec::with_capacity(lengths.len());
        for (stretch, length) in lengths.into_iter().enumerate() {
            let (out, rest) = fresh.split_at_mut(length);
            jobs.push((stretch, out));
            fresh = rest;
        }
        let one = |next: &mut Vec<u32>, (stretch, out): (usize, &mut [Event])| {
            let told = parts.iter().map(|part| &part.stretches[stretch][..]);
            sort_stretch(told, clock.starts(stretch), clock.width(), next, out);
        };
        if parts.len() == 1 || super::alone() {
            let mut next = Vec::new();
            jobs.into_iter().for_each(|job| one(&mut next, job));
        } else {
            jobs.into_par_iter().for_each_init(Vec::new, one);
        }
    }
}

/// Sorts the events of one stretch of time, which come in order of row, column and channel.
fn sort_stretch<'a>(
    told: impl Iterator<Item = &'a [Event]> + Clone,
    start: u64,
    width: u64,
    next: &mut Vec<u32>,
    out: &mut [Event],
) {
    if width > 4 * out.len() as u64 {
        for (out, event) in out.iter_mut().zip(told.flatten()) {
            *out = *event;
        }
        out.sort_by_key(|event| event.t);
        return;
    }
    let last = width as usize - 1;
    let bin = |event: &Event| (event.t.0.wrapping_sub(start) as usize).min(last);
    next.clear();
    next.resize(width as usize, 0);
    for event in told.clone().flatten() {
        next[bin(event)] += 1;
    }
    let mut sum = 0;
    for place in &mut *next {
        sum += std::mem::replace(place, sum);
    }
    for event in told.flatten() {
        let place = &mut next[bin(event)];
        out[*place as usize] = *event;
        *place += 1;
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
        part.row.take(row, events as usize, &part.clock);
        Ok(())
    }
}

impl Part {
    fn begin(&mut self, clock: Clock, room: u64) {
        (self.clock, self.room, self.total) = (clock, room, 0);
        self.row.clear();
        self.stretches.resize_with(clock.stretches(), Vec::new);
        for stretch in &mut self.stretches {
            stretch.clear();
        }
    }

    /// Deals the events of the row out to the stretches of time.
    fn deal(&mut self) {
        self.row.merge();
        let last = self.stretches.len() - 1;
        let y = self.row.y as u16;
        for (t, cell) in self
            .row
            .times
            .iter()
            .zip(&self.row.cells)
            .take(self.row.len)
        {
            let stretch = self.clock.stretch(*t).min(last);
            self.stretches[stretch].push(Event {
                t: Micros(*t),
                x: cell.x,
                y,
                polarity: cell.polarity,
                channel: cell.channel,
            });
        }
        self.row.clear();
    }
}

/// The events of one row, all channels.
#[derive(Clone, Debug, Default)]
struct Row {
    y: usize,
    /// How many there are; the buffers are longer.
    len: usize,
    times: Vec<u64>,
    cells: Vec<Cell>,
    /// How often this row was told.
    told: usize,
    /// The columns that fired.
    columns: Vec<u32>,
    /// For merging: where the events of each column go, and the events in order.
    next: Vec<u32>,
    merged: (Vec<u64>, Vec<Cell>),
}

/// Whose event it is.
#[derive(Clone, Copy, Debug)]
struct Cell {
    x: u16,
    polarity: Polarity,
    channel: u8,
}

/// Events that are written at a time, whether there are as many or fewer.
const FEW: usize = 4;

impl Row {
    fn clear(&mut self) {
        (self.len, self.told) = (0, 0);
    }

    /// Adds the events of a row of trains.
    fn take<R: Real>(&mut self, row: &TrainRow<R>, events: usize, clock: &Clock) {
        self.y = row.y;
        self.told += 1;
        let none = Cell {
            x: 0,
            polarity: Polarity::Off,
            channel: 0,
        };
        // Room for a few more than there are.
        let room = self.len + events + FEW;
        if self.times.len() < room {
            self.times.resize(room, 0);
            self.cells.resize(room, none);
        }
        let width = row.counts.len();
        if self.columns.len() < width {
            self.columns.resize(width, 0);
            self.next.resize(width, 0);
        }
        let fired = columns(&row.counts, &mut self.columns);
        for &x in &self.columns[..fired] {
            let x = x as usize;
            let count = row.counts[x];
            let (first, spacing) = (row.first[x].to_f64(), row.spacing[x].to_f64());
            let cell = Cell {
                x: x as u16,
                polarity: if count > 0 {
                    Polarity::On
                } else {
                    Polarity::Off
                },
                channel: row.channel as u8,
            };
            let count = count.unsigned_abs() as usize;
            for start in (0..count).step_by(FEW) {
                let here = self.len + start..self.len + start + FEW;
                clock.few(first, spacing, start, &mut self.times[here.clone()]);
                self.cells[here].fill(cell);
            }
            self.len += count;
        }
    }

    /// Puts the events into order of column where several channels, or one several times, have
    /// told of this row.
    fn merge(&mut self) {
        if self.told < 2 {
            return;
        }
        let (times, cells) = (&self.times[..self.len], &self.cells[..self.len]);
        self.next.fill(0);
        for cell in cells {
            self.next[usize::from(cell.x)] += 1;
        }
        let mut sum = 0;
        for place in &mut self.next {
            sum += std::mem::replace(place, sum);
        }
        self.merged.0.resize(self.times.len(), 0);
        self.merged.1.resize(self.cells.len(), self.cells[0]);
        for (t, cell) in times.iter().zip(cells) {
            let place = &mut self.next[usize::from(cell.x)];
            self.merged.0[*place as usize] = *t;
            self.merged.1[*place as usize] = *cell;
            *place += 1;
        }
        std::mem::swap(&mut self.times, &mut self.merged.0);
        std::mem::swap(&mut self.cells, &mut self.merged.1);
    }
}

/// The columns that have a train, in order; how many. No branch depends on the events.
fn columns(counts: &[i32], out: &mut [u32]) -> usize {
    let mut fired = 0;
    for (x, count) in counts.iter().enumerate() {
        out[fired] = x as u32;
        fired += usize::from(*count != 0);
    }
    fired
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
    /// A stretch is so many powers of two of a microsecond long.
    shift: u32,
    /// The last stretch that has events.
    last: usize,
}

/// Stretches of time that a pair is cut into, at most.
const STRETCHES: u64 = 64;

/// 2^52: the first double after which there are no fractions.
const MAGIC: f64 = 4_503_599_627_370_496.0;

impl Clock {
    const NONE: Self = Self {
        start: 0,
        fraction: 0.0,
        duration: 0.0,
        shift: 0,
        last: 0,
    };

    fn of(pair: Pair) -> Self {
        let from = pair.from * 1e6;
        let clock = Self {
            start: from.floor() as u64,
            fraction: from - from.floor().max(0.0),
            // A hundred years.
            duration: (pair.duration() * 1e6).min(MAGIC / 2.0),
            ..Self::NONE
        };
        let span = clock.at(1.0) - clock.start;
        let shift = (u64::BITS - span.leading_zeros()).saturating_sub(STRETCHES.ilog2());
        Self {
            shift,
            last: (span >> shift) as usize,
            ..clock
        }
    }

    /// The nearest microsecond to a place; none before time 0.
    #[inline]
    fn at(&self, place: f64) -> u64 {
        let since = self.fraction + place.clamp(0.0, 1.0) * self.duration;
        // Added to 2^52, the nearest whole number stands in the lowest bits.
        let whole = (since.max(0.0) + MAGIC).to_bits() - MAGIC.to_bits();
        self.start.saturating_add(whole)
    }

    /// The times of a few events of a train, from number `start` on.
    #[inline]
    fn few(&self, first: f64, spacing: f64, start: usize, out: &mut [u64]) {
        for (i, t) in out.iter_mut().enumerate() {
            *t = self.at(first + spacing * (start + i) as f64);
        }
    }

    const fn stretches(&self) -> usize {
        self.last + 1
    }

    /// Microseconds in a stretch.
    const fn width(&self) -> u64 {
        1 << self.shift
    }

    /// The first microsecond of a stretch.
    const fn starts(&self, stretch: usize) -> u64 {
        self.start.saturating_add((stretch as u64) << self.shift)
    }

    /// The stretch that a time lies in.
    const fn stretch(&self, t: u64) -> usize {
        (t.saturating_sub(self.start) >> self.shift) as usize
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

    proptest! {
        /// Counting and comparing put the same events into the same order.
        #[test]
        fn both_sorts_agree(rows in proptest::collection::vec(proptest::collection::vec(-9i8..9, 7), 1..9), index in 0u64..1000) {
            // The longer pair is too long to be counted: its times are those of the shorter, times 32.
            let pair = |dt: f64| Pair { index, from: index as f64 * dt, to: (index + 1) as f64 * dt };
            let [mut short, mut long] = [Packet::new(Size::new(9, 7), 1), Packet::new(Size::new(9, 7), 1)];
            told(&rows, pair(0.004_096), Limit::default(), &mut short).unwrap();
            told(&rows, pair(0.131_072), Limit::default(), &mut long).unwrap();
            prop_assert!(short.events.is_sorted_by_key(|e| (e.t, e.y, e.x)));
            let total: i64 = rows.iter().flatten().map(|c| i64::from(c.abs())).sum();
            prop_assert_eq!(short.events.len() as i64, total);
            let scaled: Vec<_> = short.canonical().iter().map(|e| (e.t.0 * 32, e.y, e.x, e.polarity)).collect();
            let mut exact: Vec<_> = long.events.iter().map(|e| (e.t.0, e.y, e.x, e.polarity)).collect();
            exact.sort_by_key(|e| (e.0 / 32, e.1, e.2));
            prop_assert_eq!(exact.len(), scaled.len());
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
