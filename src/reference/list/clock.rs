//! From places between two frames to whole microseconds.

use crate::{event::Event, unit::Micros};

use super::{
    super::{MAGIC, train::Pair},
    note::Note,
};

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
}

impl Clock {
    pub(super) fn of(pair: Pair) -> Self {
        let from = pair.from * 1e6;
        let clock = Self {
            // So that no sum of times overflows.
            start: (from.floor() as u64).min(1 << 63),
            fraction: from - from.floor().max(0.0),
            // Seventy years.
            duration: (pair.duration() * 1e6).clamp(0.0, MAGIC / 2.0),
            ..Self::default()
        };
        Self {
            span: clock.at(1.0),
            ..clock
        }
    }

    /// Whether the pair is too long for notes: eight seconds and more.
    pub(super) const fn is_long(&self) -> bool {
        self.span >> Note::TIME_BITS != 0
    }

    /// How many microseconds there are, from the start to the later frame.
    pub(super) const fn microseconds(&self) -> usize {
        self.span as usize + 1
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

    /// Appends the events of some notes.
    pub(super) fn tell(self, notes: &[Note], events: &mut Vec<Event>) {
        events.extend(notes.iter().map(|note| self.event(*note)));
    }
}
