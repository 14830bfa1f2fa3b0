//! A drawing as pixels.

use image::{
    Rgb, RgbImage,
    imageops::{self, FilterType},
};

use super::drawing::{Anchor, Area, Drawing, Mark, Point};
use crate::{
    elementary,
    picture::{
        ink::{self, Ink},
        text::{self, Face},
    },
};

/// The drawing with `scale` pixels a point, 1 or 2.
#[must_use]
pub fn raster(drawing: &Drawing, scale: u32) -> RgbImage {
    let scale = scale.clamp(1, 2);
    let side = |points: f64| (points.ceil() as u32).max(1) * scale;
    let mut page = RgbImage::from_pixel(side(drawing.width), side(drawing.height), ink::PAGE);
    let s = f64::from(scale);
    for mark in &drawing.marks {
        match mark {
            Mark::Fill(area, ink) => fill(&mut page, scaled(*area, s), *ink),
            Mark::Line(from, to, width, ink) => {
                let at = |p: &Point| (p.0 * s, p.1 * s);
                line(&mut page, at(from), at(to), width * s, *ink);
            }
            Mark::Pixels(area, picture) => {
                let area = scaled(*area, s);
                let (width, height) = (area.width.round() as u32, area.height.round() as u32);
                let picture = imageops::resize(picture, width, height, FilterType::Nearest);
                let (x, y) = (area.x.round() as i64, area.y.round() as i64);
                imageops::replace(&mut page, &picture, x, y);
            }
            Mark::Text(at, anchor, weight, ink, words) => {
                let face = Face::new(*weight, scale);
                let words = &text::in_letters(words);
                let width = f64::from(face.width(words));
                let left = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => width / 2.0,
                    Anchor::End => width,
                };
                let corner = ((at.0 * s - left).round(), (at.1 * s).round());
                // What would begin off the page begins at its edge: `as` saturates.
                text::write_in(
                    &mut page,
                    (corner.0 as u32, corner.1 as u32),
                    words,
                    face,
                    *ink,
                );
            }
        }
    }
    page
}

fn scaled(area: Area, s: f64) -> Area {
    Area {
        x: area.x * s,
        y: area.y * s,
        width: area.width * s,
        height: area.height * s,
    }
}

/// Pixels are covered by the part of them that lies inside.
fn fill(page: &mut RgbImage, area: Area, ink: Ink) {
    let inside = |low: f64, high: f64, pixel: u32| {
        let pixel = f64::from(pixel);
        (high.min(pixel + 1.0) - low.max(pixel)).clamp(0.0, 1.0)
    };
    let (x, y) = (area.x.max(0.0), area.y.max(0.0));
    let (width, height) = page.dimensions();
    for py in y.floor() as u32..(area.bottom().ceil().max(0.0) as u32).min(height) {
        for px in x.floor() as u32..(area.right().ceil().max(0.0) as u32).min(width) {
            let part = inside(x, area.right(), px) * inside(y, area.bottom(), py);
            cover(page, px, py, part, ink);
        }
    }
}

/// A pixel is covered by how near its middle is to the line.
fn line(page: &mut RgbImage, from: Point, to: Point, width: f64, ink: Ink) {
    let reach = width / 2.0 + 1.0;
    let low = |a: f64, b: f64| (a.min(b) - reach).max(0.0).floor() as u32;
    let high = |a: f64, b: f64| (a.max(b) + reach).max(0.0).ceil() as u32;
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = elementary::hypot(dx, dy);
    let (across, down) = page.dimensions();
    for py in low(from.1, to.1)..high(from.1, to.1).min(down) {
        for px in low(from.0, to.0)..high(from.0, to.0).min(across) {
            let (x, y) = (f64::from(px) + 0.5 - from.0, f64::from(py) + 0.5 - from.1);
            let along = if length > 0.0 {
                ((x * dx + y * dy) / length).clamp(0.0, length)
            } else {
                0.0
            };
            let (nx, ny) = if length > 0.0 {
                (x - along * dx / length, y - along * dy / length)
            } else {
                (x, y)
            };
            let part = (width / 2.0 + 0.5 - elementary::hypot(nx, ny)).clamp(0.0, 1.0);
            cover(page, px, py, part, ink);
        }
    }
}

/// Mixes ink into a pixel, if there is one.
fn cover(page: &mut RgbImage, x: u32, y: u32, part: f64, ink: Ink) {
    if part <= 0.0 {
        return;
    }
    if let Some(pixel) = page.get_pixel_mut_checked(x, y) {
        *pixel = mixed(*pixel, ink, part);
    }
}

/// `part` of the ink over what is below.
pub fn mixed(below: Ink, ink: Ink, part: f64) -> Ink {
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    let ([r, g, b], [ir, ig, ib]) = (below.0, ink.0);
    Rgb([mix(r, ir), mix(g, ig), mix(b, ib)])
}
