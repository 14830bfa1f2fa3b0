//! A drawing: a page and the marks on it.

use image::RgbImage;

use crate::picture::ink::Ink;
use crate::picture::text::{Face, Weight, in_letters};

/// A place on a page, in points from its upper left corner.
pub(crate) type Point = (f64, f64);

/// A rectangle on a page, in points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Area {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

impl Area {
    pub const fn right(self) -> f64 {
        self.x + self.width
    }

    pub const fn bottom(self) -> f64 {
        self.y + self.height
    }
}

/// Which end of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// One thing on a page.
#[derive(Clone, Debug)]
pub(super) enum Mark {
    /// A filled rectangle.
    Fill(Area, Ink),
    /// A straight line of some width.
    Line(Point, Point, f64, Ink),
    /// Pixels, stretched over an area without smoothing.
    Pixels(Area, RgbImage),
    /// A line of text, its upper edge and one end given.
    Text(Point, Anchor, Weight, Ink, String),
}

/// Marks on a page, the later over the earlier.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Width of the page, in points.
    pub(super) width: f64,
    /// Height of the page, in points.
    pub(super) height: f64,
    pub(super) marks: Vec<Mark>,
}

impl Drawing {
    pub(crate) const fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            marks: Vec::new(),
        }
    }

    /// Width and height of the page, in points.
    #[must_use]
    pub const fn size(&self) -> (f64, f64) {
        (self.width, self.height)
    }

    /// Every text on the page, in the order in which it was written.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.marks.iter().filter_map(|mark| match mark {
            Mark::Text(.., text) => Some(text.as_str()),
            _ => None,
        })
    }

    pub(crate) fn fill(&mut self, area: Area, ink: Ink) {
        self.marks.push(Mark::Fill(area, ink));
    }

    /// A square about a point, of twice `half` along each side.
    pub(crate) fn square(&mut self, (x, y): Point, half: f64, ink: Ink) {
        let area = Area {
            x: x - half,
            y: y - half,
            width: 2.0 * half,
            height: 2.0 * half,
        };
        self.fill(area, ink);
    }

    pub(crate) fn line(&mut self, from: Point, to: Point, width: f64, ink: Ink) {
        self.marks.push(Mark::Line(from, to, width, ink));
    }

    pub(crate) fn pixels(&mut self, area: Area, picture: RgbImage) {
        self.marks.push(Mark::Pixels(area, picture));
    }

    pub(crate) fn text(
        &mut self,
        at: Point,
        anchor: Anchor,
        weight: Weight,
        ink: Ink,
        text: impl Into<String>,
    ) {
        self.marks
            .push(Mark::Text(at, anchor, weight, ink, text.into()));
    }

    /// The drawing on a page that is at least so wide that every line of text that begins on it
    /// ends on it too, with a margin.
    pub(crate) fn fitted(mut self, margin: f64) -> Self {
        for mark in &self.marks {
            if let Mark::Text((x, _), Anchor::Start, weight, _, text) = mark {
                // An SVG shows the letters as they are, pixels those of the typeface.
                let width = |text: &str| f64::from(Face::new(*weight, 1).width(text));
                let right = x + width(text).max(width(&in_letters(text))) + margin;
                self.width = self.width.max(right);
            }
        }
        self
    }

    /// The four sides of an area, just outside it.
    pub(crate) fn frame(&mut self, area: Area, width: f64, ink: Ink) {
        let half = width / 2.0;
        let (left, top) = (area.x - half, area.y - half);
        let (right, bottom) = (area.right() + half, area.bottom() + half);
        for (from, to) in [
            ((left - half, top), (right + half, top)),
            ((left - half, bottom), (right + half, bottom)),
            ((left, top), (left, bottom)),
            ((right, top), (right, bottom)),
        ] {
            self.line(from, to, width, ink);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::ink;

    #[test]
    fn a_page_is_as_wide_as_what_is_written_on_it() {
        let page = |text: &str| {
            let mut page = Drawing::new(100.0, 20.0);
            page.text((10.0, 0.0), Anchor::Start, Weight::Heading, ink::TEXT, text);
            page.fitted(5.0).size().0
        };
        assert_eq!(page("short"), 100.0);
        let letter = f64::from(Face::new(Weight::Heading, 1).width("a"));
        assert_eq!(page(&"a".repeat(40)), 40.0f64.mul_add(letter, 15.0));
        // Spelled out where the typeface has no such letter.
        assert_eq!(page(&"\u{3bb}".repeat(20)), 120.0f64.mul_add(letter, 15.0));
    }
}
