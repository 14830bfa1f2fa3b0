//! Events a second over time.

use crate::{
    event::{Packet, Polarity},
    picture::{
        chart::{
            Anchor, Area, Drawing,
            axes::{Axis, Scale, axes},
        },
        ink,
        text::{LINE, Weight},
    },
    unit::Micros,
};

use super::time::{Clock, lasting};

/// ON and OFF events of each bin.
#[derive(Debug, PartialEq)]
struct Bins {
    /// When the first begins.
    from: Micros,
    /// Their length.
    length: Micros,
    counts: Vec<[u64; 2]>,
}

impl Bins {
    /// At most `most` bins over the span of the packet, each of 1, 2 or 5 times a power of ten
    /// microseconds. A bin holds its end, not its beginning; the first holds both.
    fn new(packet: &Packet, most: u64) -> Self {
        let (from, to) = packet.span;
        let whole = to.0.saturating_sub(from.0);
        let mut length = 1_u64;
        // 1, 2, 5, 10, 20, …
        for (times, over) in [(2, 1), (5, 2), (2, 1)].into_iter().cycle() {
            if whole.div_ceil(length) <= most {
                break;
            }
            length = (length / over).saturating_mul(times);
        }
        let mut counts = vec![[0; 2]; whole.div_ceil(length).max(1) as usize];
        for e in &packet.events {
            let bin = e.t.0.saturating_sub(from.0).saturating_sub(1) / length;
            if let Some(bin) = counts.get_mut(bin as usize) {
                bin[usize::from(e.polarity == Polarity::Off)] += 1;
            }
        }
        Self {
            from,
            length: Micros(length),
            counts,
        }
    }
}

/// Both rates as steps: ON up, OFF down from a common zero.
pub(super) fn draw(drawing: &mut Drawing, area: Area, packet: &Packet) {
    let bins = Bins::new(packet, 200);
    let second = bins.length.seconds();
    let most = bins.counts.iter().flatten().copied().max().unwrap_or(0);
    let (unit, one) = prefix(most as f64 / second);
    let top = (most as f64 / second / one * 1.08).max(1e-9);
    let from = Clock::of(packet).seconds(bins.from);
    let to = from + bins.counts.len() as f64 * second;
    let label = format!("{unit}ev/s, in bins of {}", lasting(bins.length));
    let x = Axis {
        label: "t (s)",
        from,
        to,
        scale: Scale::Plain,
    };
    let y = Axis {
        label: &label,
        from: if most == 0 { 0.0 } else { -top },
        to: if most == 0 { 1.0 } else { top },
        scale: Scale::Mirrored,
    };
    axes(drawing, area, x, y);
    let zero = area.bottom() - y.part(0.0) * area.height;
    let width = area.width / bins.counts.len() as f64;
    for (i, counts) in (0..).zip(&bins.counts) {
        for (count, ink, up) in [(counts[0], ink::ON, true), (counts[1], ink::OFF, false)] {
            let height = count as f64 / second / one / (y.to - y.from) * area.height;
            let bar = Area {
                x: area.x + f64::from(i) * width,
                y: if up { zero - height } else { zero },
                width,
                height,
            };
            if count > 0 {
                drawing.fill(bar, ink);
            }
        }
    }
    drawing.line((area.x, zero), (area.right(), zero), 1.0, ink::CAPTION);
    let heading = (area.x, area.y - 2.0 * f64::from(LINE) - 6.0);
    drawing.text(
        heading,
        Anchor::Start,
        Weight::Heading,
        ink::TEXT,
        "rate: ON up, OFF down",
    );
}

/// An SI prefix in which a rate is from 1 to 1000, and its factor.
fn prefix(rate: f64) -> (&'static str, f64) {
    match rate {
        r if r >= 1e9 => ("G", 1e9),
        r if r >= 1e6 => ("M", 1e6),
        r if r >= 1e3 => ("k", 1e3),
        _ => ("", 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tests::packet, *};

    #[test]
    fn bins_hold_every_event_once() {
        let packet = packet(&[
            (0, 0, 0, true),
            (100, 0, 0, true),
            (101, 0, 0, false),
            (1000, 0, 0, false),
        ]);
        let bins = Bins::new(&packet, 10);
        assert_eq!((bins.from, bins.length), (Micros(0), Micros(100)));
        assert_eq!(bins.counts.len(), 10);
        assert_eq!(bins.counts[0], [2, 0]);
        assert_eq!(bins.counts[1], [0, 1]);
        assert_eq!(bins.counts[9], [0, 1]);
        for (most, length) in [(1000, 1), (999, 2), (499, 5), (199, 10), (99, 20), (49, 50)] {
            assert_eq!(Bins::new(&packet, most).length, Micros(length));
        }
    }
}
