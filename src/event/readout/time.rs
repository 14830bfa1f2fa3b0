//! Time within a readout: picoseconds, and frame periods.

use crate::{
    event::{Event, Packet},
    unit::Micros,
};

/// The events that go into one frame.
pub(super) struct Window<'a> {
    /// The frame's end.
    pub(super) stamp: Micros,
    pub(super) events: &'a [Event],
}

/// Cuts a packet into frames of length `period`: an event at `t` belongs to the frame that ends
/// at the next multiple of `period`, `t` itself included. With period 0 each time stamp is a
/// frame.
pub(super) fn windows(packet: &Packet, period: Micros) -> impl Iterator<Item = Window<'_>> {
    let stamp = move |t: Micros| match period.0 {
        0 => t,
        period => Micros(t.0.div_ceil(period).saturating_mul(period)),
    };
    packet
        .events
        .chunk_by(move |a, b| stamp(a.t) == stamp(b.t))
        .filter_map(move |events| {
            let stamp = stamp(events.first()?.t);
            Some(Window { stamp, events })
        })
}

/// From when on a packet was watched: the span that it states, or its first event where that is
/// earlier.
pub(super) fn span_start(packet: &Packet) -> Micros {
    let first = packet.events.first().map(|e| e.t);
    first.map_or(packet.span.0, |t| t.min(packet.span.0))
}

/// A time stamp in picoseconds. Wide enough for any.
pub(super) fn picos(t: Micros) -> u128 {
    u128::from(t.0) * 1_000_000
}

/// The last whole microsecond before a time in picoseconds.
pub(super) fn micros(picos: u128) -> Micros {
    Micros(u64::try_from(picos / 1_000_000).unwrap_or(u64::MAX))
}

/// The time from firing at `t` to `at`, in picoseconds; at most
/// [`Latency::BEYOND`](super::Latency::BEYOND).
pub(super) fn since(t: Micros, at: u128) -> u64 {
    u64::try_from(at.saturating_sub(picos(t))).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::{super::testing::*, *};

    #[test]
    fn a_frame_ends_with_its_last_microsecond() {
        let all = packet(1, 1, &[0, 1, 10, 11, 20, 35].map(|t| event(t, 0, 0)));
        let cut = |period| {
            windows(&all, Micros(period))
                .map(|f| (f.stamp.0, f.events.len()))
                .collect::<Vec<_>>()
        };
        assert_eq!(cut(10), [(0, 1), (10, 2), (20, 2), (40, 1)]);
        assert_eq!(cut(0).len(), 6);
    }
}
