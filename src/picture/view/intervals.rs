//! The histogram of inter-event intervals: times between successive events of a cell.

use std::collections::HashMap;

use crate::{
    elementary,
    event::Packet,
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

use super::time::lasting;

/// Bins of the histogram in one decade.
const PER_DECADE: f64 = 10.0;

/// Intervals of all cells in microseconds, sorted; the signs of events do not matter.
fn intervals(packet: &Packet) -> Vec<u64> {
    let mut last: HashMap<_, Micros> = HashMap::new();
    let mut intervals = Vec::new();
    for e in &packet.events {
        if let Some(before) = last.insert((e.x, e.y, e.channel), e.t) {
            intervals.push(e.t.0 - before.0);
        }
    }
    intervals.sort_unstable();
    intervals
}

/// A histogram over logarithmic bins; intervals of 0 count to the first bin.
pub(super) fn draw(drawing: &mut Drawing, area: Area, packet: &Packet) {
    let all = intervals(packet);
    let decades = |us: u64| elementary::log10(us.max(1) as f64);
    let (low, high) = match (all.first(), all.last()) {
        (Some(low), Some(high)) => (decades(*low).floor(), (decades(*high) + 1e-9).ceil()),
        _ => (0.0, 6.0),
    };
    let high = high.max(low + 1.0);
    let mut bins = vec![0_u64; ((high - low) * PER_DECADE).round() as usize];
    for interval in &all {
        let at = ((decades(*interval) - low) * PER_DECADE + 1e-9) as usize;
        let at = at.min(bins.len().saturating_sub(1));
        if let Some(bin) = bins.get_mut(at) {
            *bin += 1;
        }
    }
    let part = |n: u64| 100.0 * n as f64 / all.len().max(1) as f64;
    let most = bins.iter().copied().max().unwrap_or(0);
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
    for (i, bin) in (0..).zip(&bins).filter(|(_, bin)| **bin > 0) {
        let height = part(*bin) / y.to * area.height;
        let bar = Area {
            x: area.x + f64::from(i) * width + 0.5,
            y: area.bottom() - height,
            width: (width - 1.0).max(0.5),
            height,
        };
        drawing.fill(bar, ink::BARS);
    }
    let median = all
        .get(all.len().saturating_sub(1) / 2)
        .map_or("no cell spoke twice".into(), |m| {
            format!("half are at most {}", lasting(Micros(*m)))
        });
    let heading = format!("{} intervals: {median}", all.len());
    let at = (area.x, area.y - 2.0 * f64::from(LINE) - 6.0);
    drawing.text(at, Anchor::Start, Weight::Heading, ink::TEXT, heading);
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
        ]);
        assert_eq!(intervals(&packet), [0, 10, 37]);
    }
}
