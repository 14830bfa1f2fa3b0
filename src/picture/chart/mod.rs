//! Drawings: marks on a page, written as PNG or as SVG.
//!
//! A page is measured in points; a PNG has two pixels a point, so that it stays sharp where it
//! is enlarged. Both are made of the same marks, so they show the same. What is a picture in
//! pixels (a panel, a cloud of dots) stays one in both.

pub(super) mod axes;
mod raster;
mod svg;

use image::RgbImage;

pub(super) use raster::mixed;
pub use raster::raster;
pub use svg::{png, svg};

use super::{ink::Ink, text::Weight};

/// A place on a page, in points from its upper left corner.
pub(super) type Point = (f64, f64);

/// A rectangle on a page, in points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
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
pub(super) enum Anchor {
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
    width: f64,
    height: f64,
    marks: Vec<Mark>,
}

impl Drawing {
    pub(super) const fn new(width: f64, height: f64) -> Self {
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

    pub(super) fn fill(&mut self, area: Area, ink: Ink) {
        self.marks.push(Mark::Fill(area, ink));
    }

    pub(super) fn line(&mut self, from: Point, to: Point, width: f64, ink: Ink) {
        self.marks.push(Mark::Line(from, to, width, ink));
    }

    pub(super) fn pixels(&mut self, area: Area, picture: RgbImage) {
        self.marks.push(Mark::Pixels(area, picture));
    }

    pub(super) fn text(
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

    /// The four sides of an area, just outside it.
    pub(super) fn frame(&mut self, area: Area, width: f64, ink: Ink) {
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
