//! The event cloud: events as dots in a box, time to the right, y down, x into the page.

use image::RgbImage;

use super::{layout::caption, time::Clock};
use crate::{
    elementary,
    event::{Event, Packet, Polarity},
    picture::{
        chart::{Anchor, Area, Drawing, Point, mixed},
        ink,
        text::{LINE, Weight},
    },
    unit::Micros,
};

/// At most this many dots are drawn, as more hide each other: beyond, every n-th event is shown,
/// and the caption says so.
const DOTS: usize = 40_000;
/// Pixels a point.
const FINE: f64 = 2.0;
/// Depth of the box on the page, as shares of its area: to the right, and up.
const DEPTH: (f64, f64) = (0.30, 0.30);

/// The oblique projection of the box (t, x, y) into an area of the page.
struct Box3 {
    area: Area,
}

impl Box3 {
    /// The place on the page of `t`, `x` and `y`, each from 0 to 1 along its side of the box.
    fn at(&self, t: f64, x: f64, y: f64) -> Point {
        let a = self.area;
        let across = a.width * (1.0 - DEPTH.0);
        let down = a.height * (1.0 - DEPTH.1);
        (
            a.x + t * across + x * a.width * DEPTH.0,
            a.y + a.height * DEPTH.1 + y * down - x * a.height * DEPTH.1,
        )
    }

    fn corner(&self, (t, x, y): Corner) -> Point {
        self.at(t.into(), x.into(), y.into())
    }
}

/// The cloud with its box, labels and caption.
pub(super) fn draw(drawing: &mut Drawing, area: Area, packet: &Packet) {
    let panel = area;
    let line = f64::from(LINE);
    // Room for the labels of time, below, and of y, at the left.
    let area = Area {
        x: area.x + 28.0,
        y: area.y,
        width: area.width - 34.0,
        height: panel.height - 2.0 * line,
    };
    let space = Box3 { area };
    let every = packet.events.len().div_ceil(DOTS).max(1);
    drawing.pixels(area, dots(packet, &space, every));
    edges(drawing, &space);
    labels(drawing, &space, packet);
    let note = if every > 1 {
        format!("one event in {every}; blue ON, vermilion OFF")
    } else {
        "all events; blue ON, vermilion OFF".into()
    };
    let whole = Area {
        x: panel.x,
        height: panel.height,
        ..area
    };
    caption(drawing, whole, "events in x, y and time", &[&note]);
}

/// A corner of the box: 0 or 1 along t, x and y.
type Corner = (u8, u8, u8);

/// Edges behind the dots, drawn pale.
const HIDDEN: [(Corner, Corner); 3] = [
    ((0, 1, 1), (1, 1, 1)),
    ((0, 1, 0), (0, 1, 1)),
    ((0, 0, 1), (0, 1, 1)),
];

/// The other edges.
const VISIBLE: [(Corner, Corner); 9] = [
    ((0, 0, 0), (1, 0, 0)),
    ((0, 0, 1), (1, 0, 1)),
    ((0, 0, 0), (0, 0, 1)),
    ((1, 0, 0), (1, 0, 1)),
    ((0, 0, 0), (0, 1, 0)),
    ((1, 0, 0), (1, 1, 0)),
    ((1, 0, 1), (1, 1, 1)),
    ((0, 1, 0), (1, 1, 0)),
    ((1, 1, 0), (1, 1, 1)),
];

fn edges(drawing: &mut Drawing, space: &Box3) {
    for (edges, ink) in [(&HIDDEN[..], ink::MATCHED), (&VISIBLE[..], ink::CAPTION)] {
        for (from, to) in edges {
            drawing.line(space.corner(*from), space.corner(*to), 1.0, ink);
        }
    }
}

/// The names of the axes and the values at their ends.
fn labels(drawing: &mut Drawing, space: &Box3, packet: &Packet) {
    let line = f64::from(LINE);
    let clock = Clock::of(packet);
    let (from, to) = packet.span;
    // Two digits at least of how long it lasts.
    let lasts = Micros(to.0.saturating_sub(from.0)).seconds().max(1e-6);
    let decimals = (1.0 - elementary::log10(lasts).floor()).clamp(2.0, 6.0) as usize;
    let mut word = |at: Point, anchor, ink, text: String| {
        drawing.text(at, anchor, Weight::Plain, ink, text);
    };
    let (left, right) = (space.corner((0, 0, 1)), space.corner((1, 0, 1)));
    let below = left.1 + 3.0;
    let middle = f64::midpoint(left.0, right.0);
    word(
        (left.0, below),
        Anchor::Start,
        ink::CAPTION,
        format!("{:.decimals$}", clock.seconds(from)),
    );
    word((middle, below), Anchor::Middle, ink::TEXT, "t (s)".into());
    word(
        (right.0, below),
        Anchor::End,
        ink::CAPTION,
        format!("{:.decimals$}", clock.seconds(to)),
    );
    let far = space.corner((1, 1, 1));
    let along = (
        f64::midpoint(right.0, far.0) + 8.0,
        f64::midpoint(right.1, far.1) - 4.0,
    );
    word(along, Anchor::Start, ink::TEXT, "x (px)".into());
    let top = space.corner((0, 0, 0));
    let beside = top.0 - 5.0;
    word((beside, top.1 - 6.0), Anchor::End, ink::CAPTION, "0".into());
    let half = f64::midpoint(top.1, left.1) - line / 2.0;
    word((beside, half), Anchor::End, ink::TEXT, "y".into());
    let lowest = (packet.size.height - 1).to_string();
    word(
        (beside, left.1 - line + 4.0),
        Anchor::End,
        ink::CAPTION,
        lowest,
    );
    let near = (right.0 + 15.0, right.1 - 5.0);
    word(near, Anchor::Start, ink::CAPTION, "0".into());
    let farthest = (packet.size.width - 1).to_string();
    word(
        (far.0 + 5.0, far.1 - 9.0),
        Anchor::Start,
        ink::CAPTION,
        farthest,
    );
}

/// A picture of the dots, those farther back drawn first; every `every`-th event.
fn dots(packet: &Packet, space: &Box3, every: usize) -> RgbImage {
    let area = space.area;
    let side = |points: f64| (points * FINE).ceil().max(1.0) as u32;
    let mut picture = RgbImage::from_pixel(side(area.width), side(area.height), ink::PAGE);
    let (from, to) = packet.span;
    let whole = to.0.saturating_sub(from.0).max(1) as f64;
    let mut shown: Vec<&Event> = packet.events.iter().step_by(every).collect();
    shown.sort_by_key(|e| (std::cmp::Reverse(e.x), e.t));
    // Where dots lie on each other all should show; where they are few each should.
    let strength = if shown.len() > DOTS / 4 { 0.5 } else { 0.85 };
    for e in shown {
        let t = e.t.0.saturating_sub(from.0) as f64 / whole;
        let x = (f64::from(e.x) + 0.5) / packet.size.width as f64;
        let y = (f64::from(e.y) + 0.5) / packet.size.height as f64;
        let at = space.at(t.min(1.0), x, y);
        let ink = match e.polarity {
            Polarity::On => ink::ON,
            Polarity::Off => ink::OFF,
        };
        let (px, py) = ((at.0 - area.x) * FINE, (at.1 - area.y) * FINE);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            if let Some(pixel) = picture.get_pixel_mut_checked(px as u32 + dx, py as u32 + dy) {
                *pixel = mixed(*pixel, ink, strength);
            }
        }
    }
    picture
}
