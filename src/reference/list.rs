//! Events as a list, in order of time: within a pair of frames, ties row by row, then by
//! channel, then by column.

use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use crate::{
    bits,
    event::{Event, Packet, Polarity},
    number::Real,
    sensor::SensorError,
    unit::Micros,
};

use super::{
    MAGIC,
    train::{BandSink, Pair, Sink, TrainRow},
};

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
/// Each band of rows notes its events as it is told of them, 8 bytes each, and deals them out
/// to stretches of time; a stretch is then sorted by counting, which keeps what happens in the
/// same microsecond in the order in which it was told.
#[derive(Debug)]
pub struct EventList<'a> {
    packet: &'a mut Packet,
    limit: Limit,
    clock: Clock,
    buffers: Buffers,
}

/// What lists are made in.
#[derive(Clone, Debug, Default)]
pub(super) struct Buffers {
    parts: Vec<Part>,
    /// The notes of all parts in order; the buffer is longer.
    sorted: Vec<Note>,
}

/// What one band of rows has said in the current pair.
#[derive(Clone, Debug, Default)]
struct Part {
    clock: Clock,
    /// How many events fit.
    room: u64,
    /// How many there are.
    total: u64,
    row: Vec<Note>,
    stretches: Vec<Stretch>,
    /// The events of a pair that is too long for notes.
    events: Vec<Event>,
}

/// The part of a list that one band of rows is told to.
#[derive(Debug)]
pub struct ListBand<'a>(&'a mut Part);

impl<'a> EventList<'a> {
    /// A list that goes on where the packet ends. It may be told of many pairs, and then
    /// makes their events in the same buffers.
    pub fn new(packet: &'a mut Packet, limit: Limit) -> Self {
        Self::with_buffers(packet, limit, Buffers::default())
    }

    /// The same, in buffers that were used before.
    pub(super) const fn with_buffers(
        packet: &'a mut Packet,
        limit: Limit,
        buffers: Buffers,
    ) -> Self {
        Self {
            packet,
            limit,
            clock: Clock::NONE,
            buffers,
        }
    }

    pub(super) fn into_buffers(self) -> Buffers {
        self.buffers
    }

    fn room(&self) -> u64 {
        self.limit.events.saturating_sub(self.packet.events.len()) as u64
    }

    /// Appends the events of all parts in order.
    fn sort(&mut self) {
        let clock = self.clock;
        let Buffers { parts, sorted } = &mut self.buffers;
        let events = &mut self.packet.events;
        if clock.is_long() {
            let start = events.len();
            for part in parts {
                events.append(&mut part.events);
            }
            events[start..].sort_by_key(|event| event.t);
            return;
        }
        let length = |stretch: usize| parts.iter().map(|part| part.stretches[stretch].len).sum();
        let lengths: Vec<usize> = (0..clock.stretches).map(length).collect();
        let total = lengths.iter().sum();
        if sorted.len() < total {
            sorted.resize(total, Note::default());
        }
        let sorted = &mut sorted[..total];
        let mut rest = &mut *sorted;
        let jobs = lengths.into_iter().enumerate().map(|(stretch, length)| {
            let (out, after) = std::mem::take(&mut rest).split_at_mut(length);
            rest = after;
            (stretch, out)
        });
        let one = |next: &mut Vec<u32>, (stretch, out): (usize, &mut [Note])| {
            let told = || parts.iter().map(|part| part.stretches[stretch].notes());
            clock.sort(told, stretch, next, out);
        };
        if super::alone() || total < ENOUGH {
            let mut next = Vec::new();
            jobs.for_each(|job| one(&mut next, job));
            events.extend(sorted.iter().map(|note| clock.event(*note)));
        } else {
            let jobs: Vec<_> = jobs.collect();
            jobs.into_par_iter().for_each_init(Vec::new, one);
            let sorted = sorted.par_iter().with_min_len(ENOUGH);
            events.par_extend(sorted.map(|note| clock.event(*note)));
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
        let threads = if bands.len() > 1 {
            rayon::current_num_threads()
        } else {
            1
        };
        self.clock = Clock::of(pair, threads);
        let room = self.room();
        let parts = &mut self.buffers.parts;
        parts.resize_with(bands.len(), Part::default);
        for part in &mut *parts {
            part.begin(self.clock, room);
        }
        parts.iter_mut().map(ListBand).collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        let parts = self.buffers.parts.iter();
        let total: u64 = parts.map(|part| part.total).sum();
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
        if part.total <= part.room {
            part.take(row, events as usize);
        }
        Ok(())
    }
}

impl Part {
    fn begin(&mut self, clock: Clock, room: u64) {
        (self.clock, self.room, self.total) = (clock, room, 0);
        self.events.clear();
        self.stretches
            .resize_with(clock.stretches, Stretch::default);
        for stretch in &mut self.stretches {
            stretch.len = 0;
        }
    }

    /// Notes the events of a row of trains.
    fn take<R: Real>(&mut self, row: &TrainRow<R>, events: usize) {
        let Self {
            clock,
            stretches,
            row: notes,
            ..
        } = self;
        if clock.is_long() {
            for (x, train) in row.trains() {
                let note = Note::of(row.channel, row.y).column(x, row.counts[x]);
                let event = |i| note.at(clock.time(clock.at(train.at(i))));
                self.events.extend((0..train.count).map(event));
            }
            return;
        }
        if let [all] = &mut stretches[..] {
            expand(row, clock, all.room(events + FEW));
            all.len += events;
            return;
        }
        notes.resize(notes.len().max(events + FEW), Note::default());
        expand(row, clock, notes);
        for (k, stretch) in stretches.iter_mut().enumerate() {
            let out = stretch.room(events);
            stretch.len += pick(&notes[..events], clock.shift, k as u64, out);
        }
    }
}

/// Copies the notes of stretch `k`; how many they are. No branch depends on them.
fn pick(notes: &[Note], shift: u32, k: u64, out: &mut [Note]) -> usize {
    let mut len = 0;
    for note in notes {
        out[len] = *note;
        len += usize::from(note.since() >> shift == k);
    }
    len
}

/// The notes of a stretch of time, row by row; the buffer is longer.
#[derive(Clone, Debug, Default)]
struct Stretch {
    notes: Vec<Note>,
    len: usize,
}

impl Stretch {
    fn notes(&self) -> &[Note] {
        &self.notes[..self.len]
    }

    /// Room for so many more.
    fn room(&mut self, more: usize) -> &mut [Note] {
        let end = self.len + more;
        if self.notes.len() < end {
            self.notes.resize(end.next_power_of_two(), Note::default());
        }
        &mut self.notes[self.len..end]
    }
}

/// An event in 8 bytes, from the lowest bit on: 16 bits each for column and row, 8 for the
/// channel, one for the sign (1 is ON), 23 for the microseconds since the clock's start.
#[derive(Clone, Copy, Debug, Default)]
struct Note(u64);

/// An event of every channel and sign: copied from here, the two are written at once.
static KINDS: [Event; 512] = kinds();

const fn kinds() -> [Event; 512] {
    let mut kinds = [Event {
        t: Micros(0),
        x: 0,
        y: 0,
        polarity: Polarity::Off,
        channel: 0,
    }; 512];
    let mut kind = 0;
    while kind < 512 {
        kinds[kind].channel = kind as u8;
        if kind >= 256 {
            kinds[kind].polarity = Polarity::On;
        }
        kind += 1;
    }
    kinds
}

impl Note {
    /// Where the sign stands, and below it all of who fired.
    const SIGN: u32 = 40;
    /// Where the time stands, and how many bits it has.
    const TIME: u32 = 41;
    const TIME_BITS: u32 = 64 - Self::TIME;

    /// At the clock's start, in column 0, and ON.
    fn of(channel: usize, y: usize) -> Self {
        Self((y as u64) << 16 | (channel as u64) << 32 | 1 << Self::SIGN)
    }

    /// With a column, and the sign of a count.
    #[inline]
    const fn column(self, x: usize, count: i32) -> Self {
        let off = (count as u32 >> 31) as u64;
        Self((self.0 + x as u64) ^ off << Self::SIGN)
    }

    /// What more bits there are in `since` than a time has are lost.
    #[inline]
    const fn after(self, since: u64) -> Self {
        Self(self.0.wrapping_add(since << Self::TIME))
    }

    #[inline]
    const fn since(self) -> u64 {
        self.0 >> Self::TIME
    }

    #[inline]
    fn at(self, t: Micros) -> Event {
        Event {
            t,
            x: self.0 as u16,
            y: (self.0 >> 16) as u16,
            ..KINDS[(self.0 >> 32) as usize % KINDS.len()]
        }
    }
}

/// Events of a train that are written at a time, whether there are as many or fewer.
const FEW: usize = 4;

/// Notes the events of a row of trains; `out` has room for a few more than there are.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn expand<R: Real>(row: &TrainRow<R>, clock: &Clock, out: &mut [Note]) {
    let (counts, first, spacing) = row.parts();
    let mut len = 0;
    let (blocks, rest) = counts.as_chunks();
    let (blocks_first, rest_first) = first.as_chunks();
    let (blocks_spacing, rest_spacing) = spacing.as_chunks();
    let note = Note::of(row.channel, row.y);
    let blocks = blocks.iter().zip(blocks_first.iter().zip(blocks_spacing));
    for (block, (counts, (first, spacing))) in blocks.enumerate() {
        let note = note.column(BLOCK * block, 0);
        len += expand_block(counts, first, spacing, note, clock, &mut out[len..]);
    }
    let mut last = ([0; BLOCK], [R::ZERO; BLOCK], [R::ZERO; BLOCK]);
    last.0[..rest.len()].copy_from_slice(rest);
    last.1[..rest.len()].copy_from_slice(rest_first);
    last.2[..rest.len()].copy_from_slice(rest_spacing);
    let note = note.column(counts.len() - rest.len(), 0);
    expand_block(&last.0, &last.1, &last.2, note, clock, &mut out[len..]);
}

/// Trains that are expanded at a time.
const BLOCK: usize = 64;

/// Those of some columns; how many events they have. No branch depends on how many each has,
/// few as they mostly are.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn expand_block<R: Real>(
    counts: &[i32; BLOCK],
    first: &[R; BLOCK],
    spacing: &[R; BLOCK],
    note: Note,
    clock: &Clock,
    out: &mut [Note],
) -> usize {
    let mut fired = fired(counts);
    let mut len = 0;
    while fired != 0 {
        let x = fired.trailing_zeros() as usize % BLOCK;
        fired &= fired - 1;
        let note = note.column(x, counts[x]);
        let (first, spacing) = (first[x].to_f64(), spacing[x].to_f64());
        let event = |i: usize| note.after(clock.low(first + spacing * i as f64));
        out[len..len + FEW].copy_from_slice(&std::array::from_fn::<_, FEW, _>(event));
        let count = counts[x].unsigned_abs() as usize;
        for i in FEW..count {
            out[len + i] = event(i);
        }
        len += count;
    }
    len
}

/// A bit for each count that is not 0.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn fired(counts: &[i32; BLOCK]) -> u64 {
    bits::packed(&counts.map(|count| u8::from(count != 0)))
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

/// Microseconds of a stretch, about: each has a place in memory that is written to, and these
/// should fit into a cache.
const CACHED: u64 = 1 << 15;

/// Fewer events are not worth sharing out.
const ENOUGH: usize = 1 << 12;

impl Clock {
    const NONE: Self = Self {
        start: 0,
        fraction: 0.0,
        duration: 0.0,
        stretches: 1,
        shift: 0,
        span: 0,
    };

    fn of(pair: Pair, threads: usize) -> Self {
        let from = pair.from * 1e6;
        let clock = Self {
            // So that no sum of times overflows.
            start: (from.floor() as u64).min(1 << 63),
            fraction: from - from.floor().max(0.0),
            // Seventy years.
            duration: (pair.duration() * 1e6).min(MAGIC / 2.0),
            ..Self::NONE
        };
        let span = clock.at(1.0);
        let stretches = (span / CACHED).clamp(1, 256) as usize;
        let stretches = stretches.next_multiple_of(threads) as u64;
        let shift = (span / stretches + 1).next_power_of_two().ilog2();
        Self {
            span,
            shift,
            stretches: (span >> shift) as usize + 1,
            ..clock
        }
    }

    /// Whether the pair is too long for notes: eight seconds and more.
    const fn is_long(&self) -> bool {
        self.span >> Note::TIME_BITS != 0
    }

    /// Microseconds from the start to the nearest to a place; none before time 0.
    #[inline]
    fn at(&self, place: f64) -> u64 {
        self.low(place) - MAGIC.to_bits()
    }

    /// The same in the lowest bits, and others above.
    #[inline]
    fn low(&self, place: f64) -> u64 {
        let place = if place < 1.0 { place } else { 1.0 };
        let since = self.fraction + place * self.duration;
        let since = if since > 0.0 { since } else { 0.0 };
        // Halves up, as a frame's own time is rounded. Added to 2^52, a whole number stands in
        // the lowest bits.
        ((since + 0.5).floor() + MAGIC).to_bits()
    }

    #[inline]
    const fn time(&self, since: u64) -> Micros {
        Micros(self.start + since)
    }

    #[inline]
    fn event(&self, note: Note) -> Event {
        note.at(self.time(note.since()))
    }

    /// Sorts the notes of one stretch by time; those of one microsecond stay in order.
    fn sort<'a, I: Iterator<Item = &'a [Note]>>(
        &self,
        told: impl Fn() -> I,
        stretch: usize,
        next: &mut Vec<u32>,
        out: &mut [Note],
    ) {
        let since = (stretch as u64) << self.shift;
        let bins = (self.span - since).min((1 << self.shift) - 1) + 1;
        if bins > 4 * out.len() as u64 {
            for (out, note) in out.iter_mut().zip(told().flatten()) {
                *out = *note;
            }
            out.sort_by_key(|note| note.since());
            return;
        }
        next.clear();
        next.resize(bins as usize, 0);
        for notes in told() {
            for note in notes {
                next[(note.since() - since) as usize] += 1;
            }
        }
        starts(next);
        for notes in told() {
            for note in notes {
                let place = &mut next[(note.since() - since) as usize];
                out[*place as usize] = *note;
                *place += 1;
            }
        }
    }
}

/// From counts to where each begins.
fn starts(counts: &mut [u32]) {
    let mut sum = 0;
    for place in counts {
        sum += std::mem::replace(place, sum);
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
        events.sort_by_key(|e| (e.t, e.y, e.channel, e.x));
        events
    }

    proptest! {
        /// Several channels, rows that are told again, short pairs and long, few events and
        /// many, one thread and two.
        #[test]
        fn events_are_in_order(
            counts in proptest::collection::vec(proptest::collection::vec(-9i32..10, 7), 12),
            sparse: bool,
            again: bool,
            channels in 1usize..4,
            index in 0u32..1000,
            duration in proptest::sample::select(vec![1e-6, 7e-4, 1.0 / 240.0, 3.0, 1e5]),
        ) {
            // Each row is told by each channel in turn, and the last channel may tell it again.
            let told = channels + usize::from(again);
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
