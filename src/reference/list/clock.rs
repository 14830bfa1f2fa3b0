//! From places between two frames to whole microseconds, and to stretches of them.

use crate::{event::Event, unit::Micros};

use super::{
    super::{MAGIC, train::Pair},
    note::Note,
};

/// Microseconds of a stretch, about: each has a place in memory that is written to, and these
/// should fit into a cache.
const CACHED: u64 = 1 << 15;

/// From places between two frames to microseconds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clock {
    /// The last whole microsecond not after the earlier frame.
    start: u64,
    /// From there to the earlier frame, in microseconds.
    fraction: f64,
    /// From frame to frame, in microseconds.
    duration: f64,
    /// Microseconds from the start to the later frame.
    span: u64,
    /// Microseconds of a stretch; the last has what is left.
    stretch: u64,
}

impl Clock {
    /// The clock of a pair, in equal stretches that so many threads can share.
    pub(super) fn of(pair: Pair, threads: usize) -> Self {
        let from = pair.from * 1e6;
        let clock = Self {
            // So that no sum of times overflows.
            start: (from.floor() as u64).min(1 << 63),
            fraction: from - from.floor().max(0.0),
            // Seventy years.
            duration: (pair.duration() * 1e6).min(MAGIC / 2.0),
            ..Self::default()
        };
        let span = clock.at(1.0);
        let stretches = (span / CACHED).clamp(1, 256) as usize;
        let stretches = stretches.next_multiple_of(threads) as u64;
        Self {
            span,
            stretch: span / stretches + 1,
            ..clock
        }
    }

    /// Whether the pair is too long for notes: eight seconds and more.
    pub(super) const fn is_long(&self) -> bool {
        self.span >> Note::TIME_BITS != 0
    }

    /// How many stretches of time there are.
    pub(super) const fn stretches(&self) -> usize {
        (self.span / self.stretch) as usize + 1
    }

    /// When stretch `k` begins, in microseconds since the start, and how long it is.
    pub(super) fn stretch(&self, k: usize) -> (u64, u64) {
        let since = k as u64 * self.stretch;
        (since, self.stretch.min(self.span + 1 - since))
    }

    /// Microseconds from the start to the nearest to a place; none before time 0.
    #[inline]
    pub(super) fn at(&self, place: f64) -> u64 {
        self.low(place) - MAGIC.to_bits()
    }

    /// The same in the lowest bits, and others above.
    #[inline]
    pub(super) fn low(&self, place: f64) -> u64 {
        let place = if place < 1.0 { place } else { 1.0 };
        let since = self.fraction + place * self.duration;
        let since = if since > 0.0 { since } else { 0.0 };
        // Halves up, as a frame's own time is rounded. Added to 2^52, a whole number stands in
        // the lowest bits.
        ((since + 0.5).floor() + MAGIC).to_bits()
    }

    #[inline]
    pub(super) const fn time(&self, since: u64) -> Micros {
        Micros(self.start + since)
    }

    #[inline]
    pub(super) fn event(&self, note: Note) -> Event {
        note.at(self.time(note.since()))
    }
}
