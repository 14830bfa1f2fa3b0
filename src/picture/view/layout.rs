//! Where things are on a page: its head, panels, what is written above and below them.

use super::{
    time::{Clock, trimmed},
    window::signs,
};
use crate::{
    event::Packet,
    picture::{
        chart::{Anchor, Area, Drawing},
        ink,
        text::{LINE, Weight},
    },
    unit::Micros,
};

/// Between panels, and around the page.
pub(super) const GAP: f64 = 36.0;
pub(super) const MARGIN: f64 = 24.0;
/// Room at the left of a plot for what is written at its ticks, and below it.
pub(super) const LEFT: f64 = 56.0;
pub(super) const BELOW: f64 = 46.0;
/// The longer side of a panel.
pub(super) const PANEL: f64 = 360.0;

/// Title, and what is known of the packet.
pub(super) fn head(drawing: &mut Drawing, packet: &Packet, title: &str) {
    let room = |width: f64| (width / 7.0) as usize;
    let (width, _) = drawing.size();
    let cut = |text: String| {
        let room = room(width - 2.0 * MARGIN);
        if text.chars().count() <= room {
            return text;
        }
        text.chars()
            .take(room.saturating_sub(2))
            .chain("..".chars())
            .collect()
    };
    let title = cut(title.to_owned());
    drawing.text(
        (MARGIN, MARGIN - 6.0),
        Anchor::Start,
        Weight::Heading,
        ink::TEXT,
        title,
    );
    let [on, off] = signs(&packet.events);
    let kinds = match packet.channels {
        1 => String::new(),
        n => format!(", {n} kinds"),
    };
    let dropped = match packet.dropped.total() {
        0 => String::new(),
        n => format!(", {n} dropped"),
    };
    let (from, to) = packet.span;
    let facts = format!(
        "{} px{kinds}, {} s; {on} ON, {off} OFF{dropped}",
        packet.size,
        trimmed(Micros(to.0.saturating_sub(from.0)).seconds()),
    );
    for (line, text) in [Some(facts), Clock::of(packet).note()]
        .into_iter()
        .flatten()
        .enumerate()
    {
        let at = (MARGIN, MARGIN - 6.0 + f64::from(LINE) * (line + 1) as f64);
        drawing.text(at, Anchor::Start, Weight::Plain, ink::CAPTION, cut(text));
    }
}

/// Where what is below the head begins.
pub(super) fn top(packet: &Packet) -> f64 {
    let lines = if Clock::of(packet).note().is_some() {
        3.0
    } else {
        2.0
    };
    MARGIN + lines * f64::from(LINE) + 16.0
}

/// Where a panel of the sensor's shape lies within an area: as large as it can be.
pub(super) fn fitted(area: Area, packet: &Packet) -> Area {
    let (w, h) = (packet.size.width as f64, packet.size.height as f64);
    let times = (area.width / w).min(area.height / h);
    Area {
        x: area.x,
        y: area.y,
        width: w * times,
        height: h * times,
    }
}

/// A name in so many letters: of a longer one the middle is left out, since names of kinds begin
/// alike.
pub(super) fn shortened(name: &str, room: usize) -> String {
    const LEFT_OUT: &str = "...";
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= room {
        return name.to_owned();
    }
    let kept = room.saturating_sub(LEFT_OUT.len());
    let (begin, end) = (kept.div_ceil(2), kept / 2);
    let begin = letters.iter().take(begin).copied();
    let end = letters.iter().skip(letters.len() - end).copied();
    begin.chain(LEFT_OUT.chars()).chain(end).collect()
}

/// Heading above an area, captions below it.
pub(super) fn caption(drawing: &mut Drawing, area: Area, heading: &str, below: &[&str]) {
    let line = f64::from(LINE);
    let above = (area.x, area.y - line - 2.0);
    drawing.text(above, Anchor::Start, Weight::Heading, ink::TEXT, heading);
    for (i, text) in (0..).zip(below) {
        let at = (area.x, area.bottom() + 4.0 + f64::from(i) * line);
        drawing.text(at, Anchor::Start, Weight::Plain, ink::CAPTION, *text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_lose_their_middle() {
        assert_eq!(shortened("centre-on", 9), "centre-on");
        let east = shortened("brighter to the north-east", 22);
        assert_eq!(east, "brighter t...orth-east");
        assert_eq!(shortened("eyes", 3), "...");
    }
}
