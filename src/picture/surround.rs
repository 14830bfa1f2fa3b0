//! Pictures of a resistive grid: its receptive field, its frequency response, its voltages.

use image::{RgbImage, imageops};

use super::{
    ink::{self, Ink},
    panel,
    text::{self, LINE, Weight},
};
use crate::plane::Plane;

/// What is shown of a resistive grid.
#[derive(Clone, Debug)]
pub struct SurroundShow {
    /// The line on top.
    pub title: String,
    /// Fields side by side, each with its caption: `[y, x]`. Their colours go with the root of
    /// the weight, or the surround would not be seen beside the centre.
    pub fields: Vec<(String, Plane<f64>)>,
    /// Frequency responses, each with its name: gains at equal steps from 0 to half a cycle a
    /// pixel.
    pub responses: Vec<(String, Vec<f64>)>,
    /// Node voltages drawn as a landscape, each with its caption, `[y, x]`.
    pub reliefs: Vec<(String, Plane<f64>)>,
}

const PANEL: u32 = 264;
const MARGIN: u32 = 20;
const GAP: u32 = 24;
/// The curves' colours, in order.
const CURVES: [Ink; 4] = [ink::ON, ink::OFF, ink::EXTRA, ink::MISSING];

/// Fields on top, the responses below them, the landscapes at the bottom.
#[must_use]
pub fn surround(show: &SurroundShow) -> RgbImage {
    let columns = show.fields.len().max(show.reliefs.len()).max(3) as u32;
    let wide = 2 * MARGIN + columns * PANEL + (columns - 1) * GAP;
    let row = PANEL + 2 * LINE + GAP;
    let mut page = RgbImage::from_pixel(wide, MARGIN + LINE + GAP + 3 * row, ink::PAGE);
    let room = wide - 2 * MARGIN;
    text::write_within(
        &mut page,
        (MARGIN, MARGIN),
        room,
        &show.title,
        Weight::Heading,
        ink::TEXT,
    );
    let top = MARGIN + LINE + GAP / 2;
    let left = |i: usize| MARGIN + i as u32 * (PANEL + GAP);
    for (i, (caption, field)) in show.fields.iter().enumerate() {
        write_caption(&mut page, (left(i), top), caption);
        let roots = field.mapv(|w| w.signum() * w.abs().sqrt());
        let most = roots.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
        let picture = panel::weights(&roots, most);
        let times = (PANEL / picture.width().max(picture.height()).max(1)).max(1);
        let picture = panel::enlarged(&picture, times);
        imageops::replace(&mut page, &picture, left(i).into(), (top + LINE).into());
        key(&mut page, (left(i), top + LINE + PANEL + 4), most * most);
    }
    responses(&mut page, (MARGIN, top + row), room, &show.responses);
    for (i, (caption, voltages)) in show.reliefs.iter().enumerate() {
        let at = (left(i), top + 2 * row);
        write_caption(&mut page, at, caption);
        let picture = relief(voltages);
        imageops::replace(&mut page, &picture, at.0.into(), (at.1 + LINE).into());
    }
    page
}

/// What the colours of a field mean: weights from `-most` to `most`, by their roots.
fn key(page: &mut RgbImage, (x, y): (u32, u32), most: f64) {
    const BAR: u32 = 96;
    let [least, most] = [-most, most].map(|weight| format!("{weight:+.3}"));
    let x = text::write(page, (x, y), &least, Weight::Plain, ink::CAPTION) + 6;
    let roots = Plane::from_shape_fn((12, BAR as usize + 1), |(_, step)| {
        2.0 * step as f64 / f64::from(BAR) - 1.0
    });
    let bar = panel::weights(&roots, 1.0);
    imageops::replace(page, &bar, x.into(), (y + 4).into());
    let zero = x + BAR / 2;
    line(
        page,
        (f64::from(zero), f64::from(y + 16)),
        (f64::from(zero), f64::from(y + 18)),
        ink::CAPTION,
    );
    let end = (x + BAR + 7, y);
    text::write(page, end, &most, Weight::Plain, ink::CAPTION);
}

fn write_caption(page: &mut RgbImage, at: (u32, u32), caption: &str) {
    text::write_within(page, at, PANEL, caption, Weight::Plain, ink::CAPTION);
}

/// Curves over frequency, with their names.
fn responses(page: &mut RgbImage, (x, y): (u32, u32), room: u32, curves: &[(String, Vec<f64>)]) {
    let caption = "gain over spatial frequency, 0 to 0.5 cycles a pixel";
    text::write_within(page, (x, y), room, caption, Weight::Plain, ink::CAPTION);
    let values = || curves.iter().flat_map(|(_, gains)| gains.iter().copied());
    let (low, high) = values().fold((0.0, 1e-300), |(l, h): (f64, f64), v| (l.min(v), h.max(v)));
    // The scale and the names stand beside the curves.
    let (scale, names) = (64, 240);
    let (left, width) = (x + scale, room.saturating_sub(scale + names));
    let (top, height) = (y + LINE + LINE / 2, PANEL);
    let to_y = |gain: f64| f64::from(top) + f64::from(height) * (high - gain) / (high - low);
    let to_x = |part: f64| f64::from(left) + f64::from(width) * part;
    for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let gain = low + part * (high - low);
        line(
            page,
            (to_x(0.0), to_y(gain)),
            (to_x(1.0), to_y(gain)),
            ink::EMPTY,
        );
        let at = (x, (to_y(gain) as u32).saturating_sub(LINE / 2));
        text::write(page, at, &format!("{gain:.2}"), Weight::Plain, ink::CAPTION);
        let at = ((to_x(part) as u32).saturating_sub(20), top + height + 4);
        text::write(
            page,
            at,
            &format!("{:.3}", part / 2.0),
            Weight::Plain,
            ink::CAPTION,
        );
    }
    line(
        page,
        (to_x(0.0), to_y(0.0)),
        (to_x(1.0), to_y(0.0)),
        ink::MATCHED,
    );
    for (i, (name, gains)) in curves.iter().enumerate() {
        let ink = CURVES[i % CURVES.len()];
        let last = gains.len().saturating_sub(1).max(1) as f64;
        let points: Vec<_> = (0..)
            .zip(gains)
            .map(|(k, gain)| (to_x(f64::from(k) / last), to_y(*gain)))
            .collect();
        for pair in points.windows(2) {
            // Two pixels thick.
            line(page, pair[0], pair[1], ink);
            let lower = |(x, y): (f64, f64)| (x, y + 1.0);
            line(page, lower(pair[0]), lower(pair[1]), ink);
        }
        let at = (left + width + 16, top + i as u32 * LINE);
        text::write_within(page, at, names - 16, name, Weight::Plain, ink);
    }
}

/// Voltages as a landscape: a line for each row, the near ones before the far ones.
#[must_use]
pub fn relief(voltages: &Plane<f64>) -> RgbImage {
    let mut picture = RgbImage::from_pixel(PANEL, PANEL, ink::PAGE);
    let (rows, columns) = voltages.dim();
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = voltages
        .iter()
        .fold(none, |(l, h), v| (l.min(*v), h.max(*v)));
    let span = if high > low { high - low } else { 1.0 };
    let shown = rows.min(48);
    let side = f64::from(PANEL);
    // Far rows are shorter and higher up.
    let (near, far, rise) = (0.96, 0.62, 0.42);
    for i in 0..shown {
        let depth = i as f64 / (shown - 1).max(1) as f64;
        let y = i * (rows - 1) / (shown - 1).max(1);
        let width = side * (far + (near - far) * depth);
        let base = side * (rise + (0.97 - rise) * depth);
        let point = |x: usize| {
            let part = x as f64 / (columns - 1).max(1) as f64;
            let height = (voltages[[y, x]] - low) / span;
            (
                (side - width) / 2.0 + part * width,
                base - height * side * 0.36 * width / side,
            )
        };
        let points: Vec<_> = (0..columns).map(point).collect();
        // Rows behind are hidden: each row fills the page below it with paper.
        for pair in points.windows(2) {
            let (from, to) = (pair[0].0.round() as u32, pair[1].0.round() as u32);
            for x in from..=to {
                let part = f64::from(x - from) / f64::from((to - from).max(1));
                let top = pair[0].1 + part * (pair[1].1 - pair[0].1);
                for y in top.max(0.0).round() as u32..=(base.round() as u32).min(PANEL - 1) {
                    if let Some(pixel) = picture.get_pixel_mut_checked(x, y) {
                        *pixel = ink::PAGE;
                    }
                }
            }
        }
        for pair in points.windows(2) {
            line(&mut picture, pair[0], pair[1], ink::ON);
        }
    }
    picture
}

/// A line one pixel thick; what leaves the page is not drawn.
fn line(page: &mut RgbImage, from: (f64, f64), to: (f64, f64), ink: Ink) {
    let steps = (to.0 - from.0)
        .abs()
        .max((to.1 - from.1).abs())
        .ceil()
        .clamp(1.0, 65_536.0);
    let mut step = 0.0;
    while step <= steps {
        let part = step / steps;
        let at = |a: f64, b: f64| a + part * (b - a);
        let (x, y) = (at(from.0, to.0).round(), at(from.1, to.1).round());
        if x >= 0.0
            && y >= 0.0
            && let Some(pixel) = page.get_pixel_mut_checked(x as u32, y as u32)
        {
            *pixel = ink;
        }
        step += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_on_the_page() {
        let bump = Plane::from_shape_fn((33, 33), |(y, x)| {
            let r = (y as f64 - 16.0).powi(2) + (x as f64 - 16.0).powi(2);
            (-r / 30.0).exp()
        });
        let show = SurroundShow {
            title: "a sheet of equal resistors".into(),
            fields: vec![("H".into(), bump.clone()), ("P - H".into(), -&bump)],
            responses: vec![
                ("a".into(), vec![0.0, 0.5, 1.0]),
                ("b".into(), vec![1.0, 0.2]),
            ],
            reliefs: vec![("voltages".into(), bump.clone())],
        };
        let page = surround(&show);
        let has = |ink: Ink| page.pixels().filter(|p| **p == ink).count();
        for ink in [ink::ON, ink::OFF, ink::TEXT] {
            assert!(has(ink) > 50, "{ink:?}");
        }
        // The key of the first field: the ends of its bar, above the tick of 0.
        let y = MARGIN + LINE + GAP / 2 + LINE + PANEL + 4;
        let row: Vec<Ink> = (MARGIN..MARGIN + PANEL)
            .map(|x| *page.get_pixel(x, y + 10))
            .collect();
        let at = |ink: Ink| row.iter().position(|p| *p == ink).unwrap();
        assert_eq!(at(ink::ON) - at(ink::OFF), 96);
        // A plane is flat: straight lines only, one for each row.
        let flat = relief(&Plane::from_elem((10, 10), 3.0));
        let inked = |picture: &RgbImage, y: u32| {
            picture
                .rows()
                .nth(y as usize)
                .unwrap()
                .any(|p| *p == ink::ON)
        };
        assert_eq!((0..PANEL).filter(|y| inked(&flat, *y)).count(), 10);
        // A single pixel, a single row, a single column.
        for shape in [(1, 1), (1, 9), (9, 1)] {
            assert_eq!(relief(&Plane::zeros(shape)).dimensions(), (PANEL, PANEL));
        }
    }
}
