//! A view on a page.

use super::{
    cloud, frame, intervals, kinds,
    layout::{self, BELOW, GAP, LEFT, MARGIN, PANEL, fitted, head},
    look::{Look, View},
    rate, surface,
    window::Window,
};
use crate::{
    event::Packet,
    picture::{
        PictureError,
        chart::{Area, Drawing},
        error::check_size,
        text::LINE,
    },
};

/// Draws a packet.
///
/// # Errors
/// When the packet's sensor has no pixels, or too many for a picture.
pub fn draw(packet: &Packet, look: &Look<'_>) -> Result<Drawing, PictureError> {
    check_size(packet.size)?;
    let shown = Window::new(packet, look);
    let line = f64::from(LINE);
    let top = layout::top(packet);
    let page = |width: f64, height: f64| {
        let mut drawing = Drawing::new(width + 2.0 * MARGIN, top + height + MARGIN);
        head(&mut drawing, packet, look.title);
        drawing
    };
    let column = |n: f64| MARGIN + n * (PANEL + GAP);
    let square = Area {
        x: 0.0,
        y: 0.0,
        width: PANEL,
        height: PANEL,
    };
    // As high as the sensor's shape asks; but a cloud needs some room.
    let tall = fitted(square, packet).height.max(PANEL / 2.0);
    let panel = |n: f64, top: f64| Area {
        x: column(n),
        y: top + line + 4.0,
        height: tall,
        ..square
    };
    let high = tall + 3.0 * line + 4.0;
    // Beside the panels, plots have their ticks at the left.
    let plot = |n: f64, top: f64, width: f64, height: f64| Area {
        x: column(n) + LEFT,
        y: top + 2.0 * line + 12.0,
        width,
        height,
    };
    let wide = 2.0 * PANEL;
    let low = PANEL * 0.62;
    Ok(match look.view {
        View::Frame => {
            let mut d = page(PANEL, high);
            frame::draw(&mut d, panel(0.0, top), packet, &shown, None);
            d
        }
        View::Surface => {
            let mut d = page(PANEL, high);
            surface::draw(&mut d, panel(0.0, top), packet, &shown);
            d
        }
        View::Cloud => {
            let mut d = page(wide, high);
            let area = panel(0.0, top);
            cloud::draw(
                &mut d,
                Area {
                    width: wide,
                    ..area
                },
                packet,
            );
            d
        }
        View::Rate => {
            let mut d = page(wide + LEFT, low + BELOW + 2.0 * line + 12.0);
            rate::draw(&mut d, plot(0.0, top, wide - 12.0, low), packet);
            d
        }
        View::Intervals => {
            let mut d = page(wide + LEFT, low + BELOW + 2.0 * line + 12.0);
            intervals::draw(&mut d, plot(0.0, top, wide - 12.0, low), packet);
            d
        }
        View::Kinds => kinds::page(packet, &shown, look.title),
        View::Overview => {
            let second = top + high + GAP / 2.0;
            let kinds = if packet.channels > 1 {
                kinds::height(packet) + GAP
            } else {
                0.0
            };
            let bottom = second + low + BELOW + 2.0 * line + 12.0 - top;
            let width = 3.0 * PANEL + 2.0 * GAP;
            let mut d = page(width, bottom + kinds);
            frame::draw(&mut d, panel(0.0, top), packet, &shown, None);
            surface::draw(&mut d, panel(1.0, top), packet, &shown);
            cloud::draw(&mut d, panel(2.0, top), packet);
            let half = (width - GAP) / 2.0 - LEFT;
            let left = plot(0.0, second, half - 8.0, low);
            rate::draw(&mut d, left, packet);
            let right = Area {
                x: left.right() + 8.0 + GAP + LEFT,
                ..left
            };
            intervals::draw(&mut d, right, packet);
            if packet.channels > 1 {
                kinds::draw(&mut d, MARGIN, top + bottom + GAP, packet, &shown);
            }
            d
        }
    })
}
