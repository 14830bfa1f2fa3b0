//! Drawings: marks on a page, written as PNG or as SVG.
//!
//! A page is measured in points; a PNG has two pixels a point, so that it stays sharp where it
//! is enlarged. Both are made of the same marks, so they show the same. What is a picture in
//! pixels (a panel, a cloud of dots) stays one in both.

pub(super) mod axes;
mod drawing;
pub(super) mod labels;
mod raster;
mod svg;

pub use drawing::Drawing;
pub(super) use drawing::{Anchor, Area, Point};
pub(super) use raster::mixed;
pub use raster::raster;
pub use svg::{png, svg};
