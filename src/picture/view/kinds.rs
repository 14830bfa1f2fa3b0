//! A small event frame for each kind.

use super::{
    frame,
    layout::{GAP, MARGIN, fitted, head, top},
    time::Clock,
    window::Window,
};
use crate::{
    event::Packet,
    picture::{
        chart::{Anchor, Area, Drawing},
        ink,
        text::{LINE, Weight, fits},
    },
};

/// The longer side of a small panel.
const SMALL: f64 = 170.0;
const APART: f64 = 14.0;
/// Letters of a name, which is no wider than a panel.
const NAME: usize = fits(SMALL as u32, Weight::Heading);
/// Kinds side by side.
const ROW: usize = 6;

/// The area of the panel of `kind`, in a grid of panels that begins at `(left, top)`.
fn area(packet: &Packet, left: f64, top: f64, kind: usize) -> Area {
    let line = f64::from(LINE);
    let whole = Area {
        x: 0.0,
        y: 0.0,
        width: SMALL,
        height: SMALL,
    };
    let panel = fitted(whole, packet);
    let (row, column) = ((kind / ROW) as f64, (kind % ROW) as f64);
    Area {
        x: left + column * (SMALL + APART),
        y: top + line + row * (panel.height + 2.0 * line + APART),
        ..panel
    }
}

/// Height of the grid of panels, in points.
pub(super) fn height(packet: &Packet) -> f64 {
    let last = usize::from(packet.channels.max(1)) - 1;
    area(packet, 0.0, 0.0, last).bottom() + f64::from(LINE) + 4.0
}

/// Draws the grid of panels with its upper left corner at `(left, top)`.
pub(super) fn draw(drawing: &mut Drawing, left: f64, top: f64, packet: &Packet, window: &Window) {
    for kind in 0..packet.channels {
        let area = area(packet, left, top, kind.into());
        frame::draw(drawing, area, packet, window, Some((kind, NAME)));
    }
}

/// Draws the grid of panels on a page of its own.
pub(super) fn page(packet: &Packet, window: &Window, title: &str) -> Drawing {
    let columns = usize::from(packet.channels).clamp(2, ROW) as f64;
    let width = columns * (SMALL + APART) - APART;
    let top = top(packet);
    let height = height(packet);
    let bottom = top + height + f64::from(LINE) + GAP + MARGIN;
    let mut drawing = Drawing::new(width + 2.0 * MARGIN, bottom);
    head(&mut drawing, packet, title);
    draw(&mut drawing, MARGIN, top, packet, window);
    let when = (MARGIN, top + height + 8.0 + f64::from(LINE));
    let text = window.text(Clock::of(packet));
    drawing.text(when, Anchor::Start, Weight::Plain, ink::CAPTION, text);
    frame::legend(&mut drawing, (MARGIN, top + height + 8.0));
    drawing
}
