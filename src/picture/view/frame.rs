//! Event frames: the events of a window, pixel by pixel.

use image::{Rgb, RgbImage};

use super::{
    layout::{caption, fitted, shortened},
    time::Clock,
    window::{Window, signs},
};
use crate::{
    event::{Event, Packet},
    picture::{
        PictureError,
        chart::{Anchor, Area, Drawing, raster},
        ink::{self, Ink},
        text::{Weight, fits, in_letters},
    },
    plane::{Plane, Size},
    unit::Micros,
};

/// A pixel has the full colour where it has at least this many more events of one sign than of the
/// other.
const FULL: i64 = 3;

/// The events of a window as a picture of the sensor's size, of one kind or of all kinds.
pub(super) fn pixels(events: &[Event], size: Size, kind: Option<u8>) -> RgbImage {
    let mut sums = Plane::<Option<i64>>::from_elem(size.shape(), None);
    for e in events
        .iter()
        .filter(|e| kind.is_none_or(|k| k == e.channel))
    {
        if let Some(sum) = sums.get_mut([e.y.into(), e.x.into()]) {
            *sum.get_or_insert(0) += i64::from(e.polarity.sign());
        }
    }
    picture(&sums, |sum| match sum {
        None => ink::EMPTY,
        Some(sum) => tint(*sum),
    })
}

/// The colour of a sum of signs (ON less OFF events).
fn tint(sum: i64) -> Ink {
    let full = match sum {
        0 => return ink::MATCHED,
        1.. => ink::ON,
        _ => ink::OFF,
    };
    let part = 0.55 + 0.45 * (sum.abs().min(FULL) - 1) as f64 / (FULL - 1) as f64;
    mixed(full, part)
}

/// `part` of an ink, the rest empty panel.
pub(super) fn mixed(full: Ink, part: f64) -> Ink {
    let mix = |i: usize| f64::from(ink::EMPTY.0[i]) * (1.0 - part) + f64::from(full.0[i]) * part;
    Rgb([mix(0), mix(1), mix(2)].map(|v| v.round() as u8))
}

pub(super) fn picture<T>(plane: &Plane<T>, ink: impl Fn(&T) -> Ink) -> RgbImage {
    let (height, width) = plane.dim();
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        plane.get([y as usize, x as usize]).map_or(ink::EMPTY, &ink)
    })
}

/// An event frame with its caption and legend; of one kind with as many letters of its name as have
/// room.
pub(super) fn draw(
    drawing: &mut Drawing,
    area: Area,
    packet: &Packet,
    window: &Window,
    kind: Option<(u8, usize)>,
) {
    let area = fitted(area, packet);
    let events = window.events(packet);
    let only = kind.map(|(kind, _)| kind);
    drawing.pixels(area, pixels(events, packet.size, only));
    drawing.frame(area, 1.0, ink::MATCHED);
    let own: Vec<Event> = events
        .iter()
        .filter(|e| only.is_none_or(|k| k == e.channel))
        .copied()
        .collect();
    let [on, off] = signs(&own);
    let counts = format!("{on} ON, {off} OFF");
    if let Some((kind, room)) = kind {
        let name = packet.names.get(usize::from(kind)).cloned();
        let name = name.unwrap_or_else(|| format!("kind {kind}"));
        caption(drawing, area, &shortened(&name, room), &[&counts]);
        return;
    }
    let when = format!("{}: {counts}", window.text(Clock::of(packet)));
    caption(drawing, area, "event frame", &[&when]);
    legend(drawing, (area.x, area.bottom() + 24.0));
}

/// What the colours of a frame mean.
pub(super) fn legend(drawing: &mut Drawing, at: (f64, f64)) {
    let (mut x, y) = at;
    let word = |drawing: &mut Drawing, x: &mut f64, text: &str| {
        drawing.text((*x, y), Anchor::Start, Weight::Plain, ink::CAPTION, text);
        *x += 7.0 * text.len() as f64 + 6.0;
    };
    let patch = |drawing: &mut Drawing, x: &mut f64, ink: Ink| {
        let area = Area {
            x: *x,
            y: y + 4.0,
            width: 12.0,
            height: 12.0,
        };
        drawing.fill(area, ink);
        *x += 12.0;
    };
    word(drawing, &mut x, "OFF 3+");
    for sum in [-3, -2, -1, 0, 1, 2, 3] {
        patch(drawing, &mut x, tint(sum));
    }
    x += 6.0;
    word(drawing, &mut x, "3+ ON");
}

/// One page after the other: the last event of each pixel, window by window from `from` to
/// `to`, for [`write_frames`](crate::picture::write_frames).
///
/// # Errors
/// When the sensor has too many pixels for a picture.
pub fn frames<'a>(
    packet: &'a Packet,
    title: &'a str,
    from: Micros,
    to: Micros,
    window: Micros,
) -> Result<impl Iterator<Item = RgbImage> + Clone + 'a, PictureError> {
    crate::picture::error::check_size(packet.size)?;
    let window = window.0.max(1);
    let number = to.0.saturating_sub(from.0).div_ceil(window);
    let page = move |i: u64| {
        let start = Micros(from.0.saturating_add(i.saturating_mul(window)));
        let end = Micros(start.0.saturating_add(window)).min(to);
        let until = |t: Micros| packet.events.partition_point(|e| e.t <= t);
        let first = if i == 0 {
            packet.events.partition_point(|e| e.t < start)
        } else {
            until(start)
        };
        let events = packet.events.get(first..until(end)).unwrap_or(&[]);
        animated(packet, title, events, (start, end))
    };
    Ok((0..number).map(page))
}

/// A page of an animation: inks only, so that a palette holds them.
fn animated(
    packet: &Packet,
    title: &str,
    events: &[Event],
    (from, to): (Micros, Micros),
) -> RgbImage {
    let Size { height, width } = packet.size;
    // A whole number of pixels for each of the sensor's.
    let times = (600 / width.max(height).max(1)).max(1) as f64;
    let area = Area {
        x: 12.0,
        y: 32.0,
        width: width as f64 * times,
        height: height as f64 * times,
    };
    let mut drawing = Drawing::new(area.width.max(330.0) + 24.0, area.height + 76.0);
    // Spelled as it is written, so that it is not cut within a letter.
    let title = in_letters(title);
    let room = fits(drawing.size().0 as u32 - 24, Weight::Heading);
    drawing.text(
        (12.0, 6.0),
        Anchor::Start,
        Weight::Heading,
        ink::TEXT,
        shortened(&title, room),
    );
    let ground = RgbImage::from_pixel(width as u32, height as u32, ink::EMPTY);
    drawing.pixels(area, crate::picture::panel::events(ground, events));
    let [on, off] = signs(events);
    let clock = Clock::of(packet);
    let mut below = format!("{} to {}", clock.text(from), clock.text(to));
    if let Some(note) = clock.note() {
        below = format!("{below}, {note}");
    }
    let y = area.bottom() + 4.0;
    drawing.text((12.0, y), Anchor::Start, Weight::Plain, ink::TEXT, below);
    let mut x = 12.0;
    for (ink, text) in [
        (ink::ON, format!("{on} ON")),
        (ink::OFF, format!("{off} OFF")),
    ] {
        let patch = Area {
            x,
            y: y + 24.0,
            width: 12.0,
            height: 12.0,
        };
        drawing.fill(patch, ink);
        drawing.text(
            (x + 18.0, y + 20.0),
            Anchor::Start,
            Weight::Plain,
            ink::CAPTION,
            text,
        );
        x += 150.0;
    }
    raster(&drawing, 1)
}

#[cfg(test)]
mod tests {
    use super::{super::tests::packet, *};

    #[test]
    fn the_sign_that_prevails_has_the_colour() {
        let packet = packet(&[
            (1, 0, 0, true),
            (2, 1, 0, false),
            (3, 2, 0, true),
            (4, 2, 0, false),
            (5, 3, 1, true),
            (6, 3, 1, true),
            (7, 3, 1, true),
            (8, 3, 1, true),
        ]);
        let seen = pixels(&packet.events, packet.size, None);
        let at = |x, y| *seen.get_pixel(x, y);
        assert_eq!(at(0, 0), mixed(ink::ON, 0.55));
        assert_eq!(at(1, 0), mixed(ink::OFF, 0.55));
        assert_eq!(at(2, 0), ink::MATCHED);
        assert_eq!(at(3, 1), ink::ON);
        assert_eq!(at(5, 3), ink::EMPTY);
        assert_eq!(
            pixels(&packet.events, packet.size, Some(1)),
            pixels(&[], packet.size, None)
        );
    }

    #[test]
    fn an_animation_shows_every_event_once() {
        let packet = packet(&[
            (0, 0, 0, true),
            (100, 1, 0, true),
            (101, 2, 0, false),
            (250, 3, 0, true),
        ]);
        let pages: Vec<_> = frames(&packet, "t", Micros(0), Micros(250), Micros(100))
            .unwrap()
            .collect();
        assert_eq!(pages.len(), 3);
        // 100 pixels for each of the sensor's.
        let shown = |page: &RgbImage| {
            (0..6)
                .filter(|x| *page.get_pixel(12 + 100 * x + 50, 32 + 50) != ink::EMPTY)
                .collect::<Vec<_>>()
        };
        let all: Vec<_> = pages.iter().map(shown).collect();
        assert_eq!(all, [vec![0, 1], vec![2], vec![3]]);
    }
}
