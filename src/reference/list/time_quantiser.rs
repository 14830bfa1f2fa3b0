//! Quantising times: from places between two frames to whole microseconds.

use crate::{
    event::Event,
    reference::{rounding::TWO_52, train::Interval},
    unit::Micros,
};

use super::packed_event::PackedEvent;

/// Quantises the times of an interval: places between two frames become whole microseconds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TimeQuantiser {
    /// The last whole microsecond not after the earlier frame, from which times are counted.
    start: u64,
    /// The interval's length, in microseconds.
    duration: f64,
    /// From the start to the earlier frame, in microseconds, plus the rounding bias.
    from: f64,
    /// The least time since the start: `from`, or time 0 if the frame is before that.
    least: f64,
    /// From the start to the later frame, in microseconds, plus the rounding bias.
    to: f64,
    /// From the start to the later frame, in whole microseconds.
    span: u64,
}

/// Added to all times, in microseconds, so that half a microsecond is rounded up, as a frame's own
/// time is, and so is what rounding has left just below a half. In intervals too long for packed
/// times it is lost.
const ROUNDING_BIAS: f64 = 1.0 / (1 << 28) as f64;

impl Interval {
    /// The microsecond at which an event list has an event at `place` of this interval: 0 is the
    /// earlier frame, 1 the later. To the nearest; a half, and what is less than 2^-28 us below
    /// one, to the later; never after the later frame, nor before time 0.
    ///
    /// This is how [`EventList`](super::EventList) rounds; `from + place * duration` in
    /// [`Micros::from_seconds`] may part from it by a microsecond, where rounding of the sum has left
    /// a half just below.
    #[must_use]
    pub fn micros(&self, place: f64) -> Micros {
        let quantiser = TimeQuantiser::new(*self);
        quantiser.time(quantiser.at(place.clamp(0.0, 1.0)))
    }
}

impl TimeQuantiser {
    pub(super) fn new(interval: Interval) -> Self {
        let (from, to) = (interval.from * 1e6, interval.to * 1e6);
        let start = from.floor().max(0.0);
        // 71 years.
        let most = TWO_52 / 2.0;
        let duration = (to - from).clamp(0.0, most);
        let to = (to - start).clamp(0.0, most) + ROUNDING_BIAS;
        let from = to - duration;
        let quantiser = Self {
            // Bounded so that no sum of times overflows.
            start: (start as u64).min(1 << 63),
            duration,
            from,
            least: from.max(0.0),
            to,
            ..Self::default()
        };
        Self {
            span: quantiser.at(1.0),
            ..quantiser
        }
    }

    /// Whether times are not packed: the interval is too long for that, 8 seconds and more, or
    /// begins before time 0.
    pub(super) fn is_long(&self) -> bool {
        self.span >> PackedEvent::TIME_BITS != 0 || self.from < self.least
    }

    /// Number of whole microseconds from the start to the later frame, both included.
    pub(super) const fn microseconds(&self) -> usize {
        self.span as usize + 1
    }

    /// The time of a place (0 to 1), rounded to microseconds since the start; not after the later
    /// frame.
    pub(super) fn at(&self, place: f64) -> u64 {
        (self.since(place).min(self.to) + 0.5).floor() as u64
    }

    /// The time of a place in microseconds since the start, plus the rounding bias, not yet
    /// rounded.
    #[inline]
    pub(super) fn since(&self, place: f64) -> f64 {
        let since = self.from + self.steps(place);
        if since > self.least {
            since
        } else {
            self.least
        }
    }

    /// The length of a stretch of the interval, in microseconds.
    #[inline]
    pub(super) fn steps(&self, places: f64) -> f64 {
        places * self.duration
    }

    /// A time rounded to whole microseconds, not after the later frame, in the lowest bits of the
    /// result; the bits above are those of 2^52.
    #[inline]
    pub(super) fn whole(&self, since: f64) -> u64 {
        let since = if since < self.to { since } else { self.to };
        // Adding 2^52 rounds, and leaves the integer in the lowest bits of the mantissa.
        (since + TWO_52).to_bits()
    }

    #[inline]
    pub(super) const fn time(&self, since: u64) -> Micros {
        Micros(self.start + since)
    }

    #[inline]
    pub(super) fn event(&self, packed: PackedEvent) -> Event {
        packed.at(self.time(packed.since()))
    }

    /// Appends the unpacked events; eight in an iteration, as far as they go.
    pub(super) fn emit(self, packed: &[PackedEvent], events: &mut Vec<Event>) {
        let (eights, rest) = packed.as_chunks::<8>();
        events.reserve(packed.len());
        for eight in eights {
            events.extend(eight.iter().map(|packed| self.event(*packed)));
        }
        events.extend(rest.iter().map(|packed| self.event(*packed)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Among them frames half a microsecond after a whole one.
        #[test]
        fn the_last_place_has_the_time_of_the_later_frame(
            fps in prop_oneof![1.0..1e5f64, (1u32..20_000).prop_map(f64::from), Just(3200.0)],
            index in prop_oneof![0u64..100, 0u64..1_000_000_000],
            place in 0.0..=1.0f64,
        ) {
            let (from, to) = (index as f64 / fps, (index + 1) as f64 / fps);
            let quantiser = TimeQuantiser::new(Interval { index, from, to });
            let time = |place| quantiser.time(quantiser.at(place));
            prop_assert_eq!(time(1.0), Micros::from_seconds(to));
            prop_assert!(time(place) <= time(1.0));
            prop_assert!(time(0.0).0.abs_diff(Micros::from_seconds(from).0) <= 1);
            // What packed events hold.
            prop_assert_eq!(quantiser.whole(quantiser.since(place)) - TWO_52.to_bits(), quantiser.at(place));
        }

        #[test]
        fn a_pair_may_last_as_long_as_times_go(to in 8.0..2.2e9f64, half: bool) {
            let to = if half { (to * 1e6).floor() * 1e-6 + 5e-7 } else { to };
            let quantiser = TimeQuantiser::new(Interval { index: 0, from: 0.0, to });
            prop_assert!(quantiser.is_long());
            prop_assert_eq!(quantiser.time(quantiser.at(1.0)), Micros::from_seconds(to));
            prop_assert!(quantiser.at(0.5).abs_diff(Micros::from_seconds(to / 2.0).0) <= 1);
        }
    }
}
