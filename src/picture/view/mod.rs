//! Pictures of one packet: frames, time surfaces, clouds, rates, intervals, kinds.
//!
//! | view | what it shows |
//! |---|---|
//! | [`View::Overview`] | all that follows, on one page |
//! | [`View::Frame`] | each pixel in the colour of the sign that prevails in a window, the fuller the more |
//! | [`View::Surface`] | each pixel's last event, `exp(-(now - t)/tau)` |
//! | [`View::Cloud`] | events in x, y and time |
//! | [`View::Rate`] | ON and OFF events a second, over time |
//! | [`View::Intervals`] | times between successive events of a cell, whatever their signs |
//! | [`View::Kinds`] | a frame for each kind |
//!
//! A window `from..to` holds the events of `from < t <= to`, as everywhere in this room.

mod cloud;
mod frame;
mod intervals;
mod kinds;
mod pages;
mod rate;
mod surface;

use super::{
    PictureError,
    chart::{Anchor, Area, Drawing},
    ink,
    text::{LINE, Weight},
};
use crate::{
    event::{Event, Packet, Polarity},
    unit::Micros,
};

pub use frame::frames;
pub use pages::pages;

/// What of a packet is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// Everything on one page.
    #[default]
    Overview,
    /// The events of a window.
    Frame,
    /// The last event of each pixel.
    Surface,
    /// Events in x, y and time.
    Cloud,
    /// Events a second.
    Rate,
    /// Times between events of a cell.
    Intervals,
    /// A frame for each kind.
    Kinds,
}

/// How a packet is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look<'a> {
    /// What the page is called.
    pub title: &'a str,
    /// Which view.
    pub view: View,
    /// Length of a frame's window, and the time constant of a time surface.
    pub window: Micros,
    /// The time at which frame and surface are taken; without one, the end of the busiest window.
    pub at: Option<Micros>,
}

/// Between panels, and around the page.
const GAP: f64 = 36.0;
const MARGIN: f64 = 24.0;
/// Room at the left of a plot for what is written at its ticks, and below it.
const LEFT: f64 = 56.0;
const BELOW: f64 = 46.0;
/// The longer side of a panel.
const PANEL: f64 = 360.0;

/// Draws a packet.
///
/// # Errors
/// When the packet's sensor has no pixels, or too many for a picture.
pub fn draw(packet: &Packet, look: &Look<'_>) -> Result<Drawing, PictureError> {
    super::error::check_size(packet.size)?;
    let shown = Window::new(packet, look);
    let layout = Layout::new(packet);
    let top = layout.top;
    let page = |width, height| layout.page((width, height), packet, look.title);
    let wide = 2.0 * PANEL;
    let plot = layout.plot(0.0, top, wide - 12.0);
    Ok(match look.view {
        View::Frame => {
            let mut d = page(PANEL, layout.panel_height());
            frame::draw(&mut d, layout.panel(0.0), packet, &shown, None);
            d
        }
        View::Surface => {
            let mut d = page(PANEL, layout.panel_height());
            surface::draw(&mut d, layout.panel(0.0), packet, &shown);
            d
        }
        View::Cloud => {
            let mut d = page(wide, layout.panel_height());
            let area = Area {
                width: wide,
                ..layout.panel(0.0)
            };
            cloud::draw(&mut d, area, packet);
            d
        }
        View::Rate => {
            let mut d = page(wide + LEFT, layout.plot_height());
            rate::draw(&mut d, plot, packet);
            d
        }
        View::Intervals => {
            let mut d = page(wide + LEFT, layout.plot_height());
            intervals::draw(&mut d, plot, packet);
            d
        }
        View::Kinds => kinds::page(packet, &shown, look.title),
        View::Overview => layout.overview(packet, &shown, look.title),
    })
}

/// Positions on a page, in points: the head, panels side by side below it, plots below these.
struct Layout {
    /// Height of a line of text.
    line: f64,
    /// The upper edge of what is below the head.
    top: f64,
    /// Height of a panel, without heading and captions.
    tall: f64,
}

/// Height of a plot, without heading and axis.
const LOW: f64 = PANEL * 0.62;

impl Layout {
    fn new(packet: &Packet) -> Self {
        let line = f64::from(LINE);
        let square = Area {
            x: 0.0,
            y: 0.0,
            width: PANEL,
            height: PANEL,
        };
        Self {
            line,
            top: MARGIN + 2.0 * line + 16.0,
            // As high as the sensor's shape asks; but a cloud needs some room.
            tall: fitted(square, packet).height.max(PANEL / 2.0),
        }
    }

    /// A page with room for `width` by `height` below its head.
    fn page(&self, (width, height): (f64, f64), packet: &Packet, title: &str) -> Drawing {
        let mut drawing = Drawing::new(width + 2.0 * MARGIN, self.top + height + MARGIN);
        head(&mut drawing, packet, title);
        drawing
    }

    /// Panel number `n` of the row of panels.
    fn panel(&self, n: f64) -> Area {
        Area {
            x: MARGIN + n * (PANEL + GAP),
            y: self.top + self.line + 4.0,
            width: PANEL,
            height: self.tall,
        }
    }

    /// Height of a panel with its heading and captions.
    fn panel_height(&self) -> f64 {
        self.tall + 3.0 * self.line + 4.0
    }

    /// A plot below `top`, in the column of panel number `n`. Its ticks are at its left.
    fn plot(&self, n: f64, top: f64, width: f64) -> Area {
        Area {
            x: MARGIN + n * (PANEL + GAP) + LEFT,
            y: top + 2.0 * self.line + 12.0,
            width,
            height: LOW,
        }
    }

    /// Height of a plot with its heading and axis.
    fn plot_height(&self) -> f64 {
        LOW + BELOW + 2.0 * self.line + 12.0
    }

    /// All views: three panels, two plots below them, then the kinds, where there are several.
    fn overview(&self, packet: &Packet, shown: &Window, title: &str) -> Drawing {
        let top = self.top;
        let second = top + self.panel_height() + GAP / 2.0;
        let kinds = if packet.channels > 1 {
            kinds::height(packet) + GAP
        } else {
            0.0
        };
        let bottom = second + LOW + BELOW + 2.0 * self.line + 12.0 - top;
        let width = 3.0 * PANEL + 2.0 * GAP;
        let mut d = self.page((width, bottom + kinds), packet, title);
        frame::draw(&mut d, self.panel(0.0), packet, shown, None);
        surface::draw(&mut d, self.panel(1.0), packet, shown);
        cloud::draw(&mut d, self.panel(2.0), packet);
        let half = (width - GAP) / 2.0 - LEFT;
        let left = self.plot(0.0, second, half - 8.0);
        rate::draw(&mut d, left, packet);
        let right = Area {
            x: left.right() + 8.0 + GAP + LEFT,
            ..left
        };
        intervals::draw(&mut d, right, packet);
        if packet.channels > 1 {
            kinds::draw(&mut d, MARGIN, top + bottom + GAP, packet, shown);
        }
        d
    }
}

/// Draws the title, and below it what the packet is: events, size, span, rates.
fn head(drawing: &mut Drawing, packet: &Packet, title: &str) {
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
    let at = (MARGIN, MARGIN - 6.0 + f64::from(LINE));
    drawing.text(at, Anchor::Start, Weight::Plain, ink::CAPTION, cut(facts));
}

/// The window that frames and surfaces show.
struct Window {
    from: Micros,
    to: Micros,
    /// The time constant of surfaces.
    tau: Micros,
}

impl Window {
    fn new(packet: &Packet, look: &Look<'_>) -> Self {
        let window = Micros(look.window.0.max(1));
        let to = look.at.unwrap_or_else(|| busiest(&packet.events, window));
        Self {
            from: Micros(to.0.saturating_sub(window.0)),
            to,
            tau: window,
        }
    }

    /// The events of the window; one that reaches back before the first time holds the events of
    /// time 0 too.
    fn events<'a>(&self, packet: &'a Packet) -> &'a [Event] {
        let until = |t: Micros| packet.events.partition_point(|e| e.t <= t);
        let first = if self.to.0 < self.tau.0 {
            0
        } else {
            until(self.from)
        };
        packet.events.get(first..until(self.to)).unwrap_or(&[])
    }

    /// `0.120 s to 0.130 s`.
    fn text(&self) -> String {
        format!("{} to {}", seconds(self.from), seconds(self.to))
    }
}

/// The end of the window that holds the most events; it ends with an event.
fn busiest(events: &[Event], window: Micros) -> Micros {
    let (mut most, mut at, mut first) = (0, Micros(0), 0);
    for (last, e) in events.iter().enumerate() {
        while let Some(old) = events.get(first)
            && e.t.0 - old.t.0 >= window.0
        {
            first += 1;
        }
        if last + 1 - first > most {
            most = last + 1 - first;
            at = e.t;
        }
    }
    at
}

/// How many events are ON and OFF.
fn signs(events: &[Event]) -> [usize; 2] {
    let on = events.iter().filter(|e| e.polarity == Polarity::On).count();
    [on, events.len() - on]
}

/// A time in seconds, to the microsecond, without trailing zeros.
fn seconds(t: Micros) -> String {
    format!("{} s", trimmed(t.seconds()))
}

fn trimmed(seconds: f64) -> String {
    let text = format!("{seconds:.6}");
    let text = text.trim_end_matches('0');
    let text = text.trim_end_matches('.');
    text.to_owned()
}

/// A duration in the unit that suits it.
fn lasting(t: Micros) -> String {
    match t.0 {
        us if us >= 1_000_000 => format!("{} s", trimmed(t.seconds())),
        us if us >= 1000 => format!("{} ms", trimmed(t.seconds() * 1e3)),
        us => format!("{us} us"),
    }
}

/// The largest rectangle of the sensor's shape within an area.
fn fitted(area: Area, packet: &Packet) -> Area {
    let (w, h) = (packet.size.width as f64, packet.size.height as f64);
    let times = (area.width / w).min(area.height / h);
    Area {
        x: area.x,
        y: area.y,
        width: w * times,
        height: h * times,
    }
}

/// Heading above an area, captions below it.
fn caption(drawing: &mut Drawing, area: Area, heading: &str, below: &[&str]) {
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
    use crate::plane::Size;

    pub(super) fn packet(events: &[(u64, u16, u16, bool)]) -> Packet {
        let mut packet = Packet::new(Size::new(4, 6), 1);
        packet.events = events
            .iter()
            .map(|(t, x, y, on)| Event {
                t: Micros(*t),
                x: *x,
                y: *y,
                polarity: if *on { Polarity::On } else { Polarity::Off },
                channel: 0,
            })
            .collect();
        packet.span = (Micros(0), Micros(1000));
        packet
    }

    #[test]
    fn the_busiest_window_ends_with_an_event() {
        let packet = packet(&[0, 10, 11, 12, 20, 21].map(|t| (t, 0, 0, true)));
        assert_eq!(busiest(&packet.events, Micros(3)), Micros(12));
        assert_eq!(busiest(&packet.events, Micros(11)), Micros(20));
        assert_eq!(busiest(&[], Micros(10)), Micros(0));
    }

    #[test]
    fn a_window_from_the_beginning_holds_time_0() {
        let packet = packet(&[0, 10, 20].map(|t| (t, 0, 0, true)));
        let look = |at| Look {
            title: "",
            view: View::Frame,
            window: Micros(10),
            at: Some(Micros(at)),
        };
        let held = |at| Window::new(&packet, &look(at)).events(&packet).len();
        assert_eq!((held(5), held(10), held(20), held(31)), (1, 1, 1, 0));
    }

    #[test]
    fn lengths_of_time_are_short() {
        let texts = [7, 1500, 20_000, 1_900_000].map(|t| lasting(Micros(t)));
        assert_eq!(texts, ["7 us", "1.5 ms", "20 ms", "1.9 s"]);
        assert_eq!(seconds(Micros(330_000)), "0.33 s");
    }
}
