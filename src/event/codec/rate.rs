//! The bit rate of a packet: what a link must carry.

use crate::{
    event::{Event, Packet, readout::Frame},
    unit::Micros,
};

/// Bits of a packet over time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Rate {
    /// All bits.
    pub bits: u64,
    /// Bits an event; `None` without events.
    pub bits_per_event: Option<f64>,
    /// Bits a second over the time watched; `None` when no time was.
    #[serde(rename = "mean_bits_per_s")]
    pub mean: Option<f64>,
    /// Bits a second in the busiest window.
    #[serde(rename = "peak_bits_per_s")]
    pub peak: f64,
    /// When that window begins.
    #[serde(rename = "peak_from_us")]
    pub peak_from: Option<Micros>,
    /// Events a window at which a bit map costs as much: above, address events do not pay.
    #[serde(rename = "crossover_events_per_window")]
    pub crossover: Option<f64>,
    /// Windows in which these events cost more than a bit map.
    #[serde(rename = "windows_above")]
    pub above: u64,
}

/// The frame of a packet in which a time lies, frames being sent at whole multiples of `window`,
/// which is above 0: a frame has what is after its start and up to its end, the first one what is at
/// its start, too.
const fn frame(packet: &Packet, t: Micros, window: Micros) -> u64 {
    let first = packet.span.0.0 / window.0 + 1;
    let own = t.0.div_ceil(window.0);
    if own > first { own } else { first }
}

/// How many frames of a length a packet was watched for: at least one. A window of 0 counts as 1 us.
#[must_use]
pub fn frames(packet: &Packet, window: Micros) -> u64 {
    let window = Micros(window.0.max(1));
    let (from, to) = packet.span;
    frame(packet, to.max(from), window) - from.0 / window.0
}

impl Rate {
    /// Of a packet whose events, in any order, take `costs` bits each. The busiest window is the one with the
    /// most bits of all `from <= t < from + window`; a window of 0 counts as 1 us. Bit maps are
    /// sent at whole multiples of `window`.
    #[must_use]
    pub fn from_packet(packet: &Packet, costs: &[u32], window: Micros) -> Self {
        if !packet.events.is_sorted_by_key(|event| event.t) {
            let (packet, costs) = in_order(packet, costs);
            return Self::from_packet(&packet, &costs, window);
        }
        let window = Micros(window.0.max(1));
        let bits: u64 = costs.iter().map(|c| u64::from(*c)).sum();
        let per_event = (!costs.is_empty()).then(|| bits as f64 / costs.len() as f64);
        let seconds = Micros(packet.span.1.0.saturating_sub(packet.span.0.0)).seconds();
        let (most, from) = busiest(&packet.events, costs, window);
        let map = Frame::bits(packet.size, packet.channels);
        let number = |e: &Event| frame(packet, e.t, window);
        let mut left = costs;
        let above = packet
            .events
            .chunk_by(|a, b| number(a) == number(b))
            .filter(|frame| {
                let (own, rest) = left.split_at_checked(frame.len()).unwrap_or((left, &[]));
                left = rest;
                own.iter().map(|c| u64::from(*c)).sum::<u64>() > map
            })
            .count();
        Self {
            bits,
            bits_per_event: per_event,
            mean: (seconds > 0.0).then(|| bits as f64 / seconds),
            // What is shorter than the window has no more in it.
            peak: most as f64
                / if seconds > 0.0 {
                    window.seconds().min(seconds)
                } else {
                    window.seconds()
                },
            peak_from: from,
            crossover: per_event.map(|b| Frame::crossover(packet.size, packet.channels, b)),
            above: above as u64,
        }
    }
}

/// The same in the order of time, each event with what it takes.
fn in_order(packet: &Packet, costs: &[u32]) -> (Packet, Vec<u32>) {
    let mut packet = packet.clone();
    let mut both: Vec<_> = packet.events.drain(..).zip(costs.iter().copied()).collect();
    both.sort_by_key(|(event, _)| event.t);
    let costs;
    (packet.events, costs) = both.into_iter().unzip();
    (packet, costs)
}

/// The most bits in a window, and the start of that window.
fn busiest(events: &[Event], costs: &[u32], window: Micros) -> (u64, Option<Micros>) {
    let (mut most, mut from, mut inside) = (0, None, 0);
    let mut first = events.iter().zip(costs).peekable();
    for (e, cost) in events.iter().zip(costs) {
        inside += u64::from(*cost);
        while let Some((_, gone)) = first.next_if(|(old, _)| e.t.0 - old.t.0 >= window.0) {
            inside -= u64::from(*gone);
        }
        if inside > most {
            most = inside;
            from = first.peek().map(|(e, _)| e.t);
        }
    }
    (most, from)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::event::readout::testing::{event, packet};

    #[test]
    fn mean_and_peak_of_a_burst() {
        let times = [0, 500, 501, 502, 503, 600, 1000];
        let packet = packet(8, 8, &times.map(|t| event(t, 0, 0)));
        let rate = Rate::from_packet(&packet, &[10; 7], Micros(100));
        assert_eq!((rate.bits, rate.bits_per_event), (70, Some(10.0)));
        assert!((rate.mean.unwrap() - 70_000.0).abs() < 1e-6);
        // Four in 500 to 599; 600 is no longer inside.
        assert!((rate.peak - 400_000.0).abs() < 1e-6);
        assert_eq!(rate.peak_from, Some(Micros(500)));
        // 128 bits a map: 12.8 events of 10 bits.
        assert_eq!((rate.crossover, rate.above), (Some(12.8), 0));
        // At 40 bits an event, the four of 501 to 600 cost more than a map.
        assert_eq!(Rate::from_packet(&packet, &[40; 7], Micros(100)).above, 1);
    }

    #[test]
    fn the_order_does_not_matter() {
        let times = [0, 500, 501, 502, 503, 600, 1000];
        let costs = [10, 20, 30, 40, 50, 60, 70];
        let of = |order: [usize; 7]| {
            let events = order.map(|n| event(times[n], 0, 0));
            let costs = order.map(|n| costs[n]);
            let mut packet = packet(8, 8, &events);
            packet.span = (Micros(0), Micros(1000));
            Rate::from_packet(&packet, &costs, Micros(100))
        };
        assert_eq!(of([6, 1, 3, 0, 2, 5, 4]), of([0, 1, 2, 3, 4, 5, 6]));
    }

    #[test]
    fn an_event_at_the_very_end_makes_no_frame() {
        let mut packet = packet(8, 8, &[event(0, 0, 0), event(100, 0, 0)]);
        for (span, window, want) in [
            ((0, 100), 10, 10),
            ((0, 101), 10, 11),
            ((0, 99), 10, 10),
            ((50, 100), 10, 5),
            ((55, 100), 10, 5),
            ((100, 100), 10, 1),
            ((0, 0), 0, 1),
        ] {
            packet.span = (Micros(span.0), Micros(span.1));
            assert_eq!(frames(&packet, Micros(window)), want, "{span:?}");
        }
    }

    #[test]
    fn nothing_costs_nothing() {
        let rate = Rate::from_packet(&packet(8, 8, &[]), &[], Micros(0));
        assert_eq!((rate.bits, rate.bits_per_event, rate.mean), (0, None, None));
        assert_eq!((rate.peak, rate.peak_from, rate.above), (0.0, None, 0));
    }

    proptest! {
        /// Every window that begins with an event, summed up on its own.
        #[test]
        fn the_peak_is_the_busiest_window(
            mut of in prop::collection::vec((0..60_u64, 1..9_u32), 1..40),
            window in 1..30_u64,
        ) {
            of.sort_by_key(|(t, _)| *t);
            let events: Vec<_> = of.iter().map(|(t, _)| event(*t, 0, 0)).collect();
            let costs: Vec<_> = of.iter().map(|(_, c)| *c).collect();
            let mut packet = packet(1, 1, &events);
            packet.span = (Micros(0), Micros(60));
            let rate = Rate::from_packet(&packet, &costs, Micros(window));
            let bits = |from: u64, to: u64| -> u64 {
                let inside = of.iter().filter(|(t, _)| (from..to).contains(t));
                inside.map(|(_, c)| u64::from(*c)).sum()
            };
            let most = of.iter().map(|(t, _)| bits(*t, t + window)).max().unwrap();
            prop_assert_eq!((rate.peak * Micros(window).seconds()).round() as u64, most);
            let from = rate.peak_from.unwrap().0;
            prop_assert_eq!(bits(from, from + window), most);
            // Two bits a map; a frame ends with its last microsecond, and the first has 0, too.
            let start = |n: u64| if n == 0 { 0 } else { n * window + 1 };
            let above = (0..=60).filter(|n| bits(start(*n), start(n + 1)) > 2);
            prop_assert_eq!(rate.above, above.count() as u64);
        }
    }
}
