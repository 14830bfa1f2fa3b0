//! The histogram of inter-event intervals: times between successive events of a cell, apart by the
//! signs of the two.

use std::collections::HashMap;

use crate::{
    elementary,
    event::{Packet, Polarity},
    picture::{
        chart::{
            Anchor, Area, Drawing,
            axes::{Axis, Scale, axes},
        },
        ink::{self, Ink},
        text::{LINE, Weight},
    },
    unit::Micros,
};

use super::time::lasting;

/// Bins of the histogram in one decade.
const PER_DECADE: f64 = 10.0;

/// The signs of the two events of an interval: colour and name.
const SIGNS: [(Ink, &str); 3] = [
    (ink::ON, "ON-ON"),
    (ink::OFF, "OFF-OFF"),
    (ink::BARS, "sign changes"),
];

/// Intervals of all cells in microseconds, sorted, each with its place in [`SIGNS`].
fn intervals(packet: &Packet) -> Vec<(u64, usize)> {
    let mut last: HashMap<_, (Micros, Polarity)> = HashMap::new();
    let mut intervals = Vec::new();
    for e in &packet.events {
        let before = last.insert((e.x, e.y, e.channel), (e.t, e.polarity));
        if let Some((before, sign)) = before {
            let signs = match (sign, e.polarity) {
                (Polarity::On, Polarity::On) => 0,
                (Polarity::Off, Polarity::Off) => 1,
                _ => 2,
            };
            intervals.push((e.t.0 - before.0, signs));
        }
    }
    intervals.sort_unstable();
    intervals
}

/// A histogram over logarithmic bins, whose bars are stacks of [`SIGNS`]; intervals of 0 count to
/// the first bin.
pub(super) fn draw(drawing: &mut Drawing, area: Area, packet: &Packet) {
    let all = intervals(packet);
    let decades = |us: u64| elementary::log10(us.max(1) as f64);
    let (low, high) = match (all.first(), all.last()) {
        (Some((low, _)), Some((high, _))) => {
            (decades(*low).floor(), (decades(*high) + 1e-9).ceil())
        }
        _ => (0.0, 6.0),
    };
    let high = high.max(low + 1.0);
    let mut bins = vec![[0_u64; SIGNS.len()]; ((high - low) * PER_DECADE).round() as usize];
    for (interval, signs) in &all {
        let at = ((decades(*interval) - low) * PER_DECADE + 1e-9) as usize;
        let at = at.min(bins.len().saturating_sub(1));
        if let Some(bin) = bins.get_mut(at) {
            bin[*signs] += 1;
        }
    }
    let part = |n: u64| 100.0 * n as f64 / all.len().max(1) as f64;
    let most = bins.iter().map(|bin| bin.iter().sum()).max().unwrap_or(0);
    let x = Axis {
        label: "time between a cell's events",
        from: low,
        to: high,
        scale: Scale::Decades,
    };
    let y = Axis {
        label: "% of intervals, 10 bins a decade",
        from: 0.0,
        to: if most == 0 { 1.0 } else { part(most) * 1.08 },
        scale: Scale::Plain,
    };
    axes(drawing, area, x, y);
    let width = area.width / bins.len() as f64;
    for (i, bin) in (0..).zip(&bins) {
        let mut top = area.bottom();
        for (count, (ink, _)) in bin.iter().zip(SIGNS).filter(|(count, _)| **count > 0) {
            let height = part(*count) / y.to * area.height;
            top -= height;
            let bar = Area {
                x: area.x + f64::from(i) * width + 0.5,
                y: top,
                width: (width - 1.0).max(0.5),
                height,
            };
            drawing.fill(bar, ink);
        }
    }
    legend(drawing, area);
    let median = all
        .get(all.len().saturating_sub(1) / 2)
        .map_or("no cell spoke twice".into(), |(m, _)| {
            format!("half are at most {}", lasting(Micros(*m)))
        });
    let heading = format!("{} intervals: {median}", all.len());
    let at = (area.x, area.y - 2.0 * f64::from(LINE) - 6.0);
    drawing.text(at, Anchor::Start, Weight::Heading, ink::TEXT, heading);
}

/// What the colours mean, above the right end of a plot.
fn legend(drawing: &mut Drawing, area: Area) {
    let mut right = area.right();
    let y = area.y - f64::from(LINE) - 4.0;
    for (ink, name) in SIGNS.into_iter().rev() {
        drawing.text((right, y), Anchor::End, Weight::Plain, ink::CAPTION, name);
        right -= 7.0 * name.len() as f64 + 18.0;
        let patch = Area {
            x: right,
            y: y + 4.0,
            width: 12.0,
            height: 12.0,
        };
        drawing.fill(patch, ink);
        right -= 10.0;
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tests::packet, *};

    #[test]
    fn intervals_are_of_one_cell() {
        let packet = packet(&[
            (0, 0, 0, true),
            (3, 1, 0, true),
            (10, 0, 0, false),
            (10, 0, 0, true),
            (40, 1, 0, true),
            (41, 0, 1, true),
            (51, 0, 1, true),
            (54, 1, 0, false),
            (60, 1, 0, false),
        ]);
        // The first event of a cell follows none; which of its events came before, and its sign.
        assert_eq!(
            intervals(&packet),
            [(0, 2), (6, 1), (10, 0), (10, 2), (14, 2), (37, 0)]
        );
    }
}
