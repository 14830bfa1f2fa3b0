//! Time surfaces: how recent each pixel's last event is.

use super::{
    frame,
    layout::{caption, fitted},
    time::{Clock, lasting},
    window::Window,
};
use crate::{
    elementary,
    event::{Packet, Polarity},
    picture::{
        chart::{Anchor, Area, Drawing},
        ink,
        text::Weight,
    },
    plane::Plane,
};

/// A time surface with its caption and legend: `exp(-(now - t)/tau)` of the pixel's last event,
/// in the colour of its sign.
pub(super) fn draw(drawing: &mut Drawing, area: Area, packet: &Packet, window: &Window) {
    let area = fitted(area, packet);
    let mut last = Plane::from_elem(packet.size.shape(), None);
    let until = packet.events.partition_point(|e| e.t <= window.to);
    for e in packet.events.iter().take(until) {
        if let Some(pixel) = last.get_mut([e.y.into(), e.x.into()]) {
            *pixel = Some((e.t, e.polarity));
        }
    }
    let tau = window.tau.0.max(1) as f64;
    let pixels = frame::picture(&last, |last| match last {
        None => ink::EMPTY,
        Some((t, polarity)) => {
            let strength = elementary::exp(-((window.to.0 - t.0) as f64) / tau);
            frame::mixed(full(*polarity), strength)
        }
    });
    drawing.pixels(area, pixels);
    drawing.frame(area, 1.0, ink::MATCHED);
    let tau = lasting(window.tau);
    let now = Clock::of(packet).text(window.to);
    let when = format!("at {now}; fades by e in {tau}");
    caption(drawing, area, "time surface", &[&when]);
    legend(drawing, (area.x, area.bottom() + 24.0), &tau);
}

const fn full(polarity: Polarity) -> ink::Ink {
    match polarity {
        Polarity::On => ink::ON,
        Polarity::Off => ink::OFF,
    }
}

/// The colour scale from now back to three time constants, for both signs.
fn legend(drawing: &mut Drawing, (x, y): (f64, f64), tau: &str) {
    let steps = 60;
    for (row, polarity) in (0..).zip([Polarity::On, Polarity::Off]) {
        for step in 0..steps {
            let ago = 3.0 * f64::from(step) / f64::from(steps);
            let area = Area {
                x: x + 34.0 + f64::from(step) * 2.0,
                y: y + 4.0 + 6.0 * f64::from(row),
                width: 2.0,
                height: 6.0,
            };
            drawing.fill(area, frame::mixed(full(polarity), elementary::exp(-ago)));
        }
    }
    let mut word = |x: f64, text: String| {
        drawing.text((x, y), Anchor::Start, Weight::Plain, ink::CAPTION, text);
    };
    word(x, "now".into());
    word(
        x + 34.0 + 2.0 * f64::from(steps) + 6.0,
        format!("3 x {tau} ago"),
    );
}
