//! Pictures of packets: what the scene showed, what both sensors said, where they differ; and
//! of one packet alone, in [`view`].
//!
//! [`contact_sheet`] puts several moments below each other, [`write_animation`] one after the
//! other; both show the same four panels. Single panels are in [`panel`], colours in [`ink`].
//! An event belongs to a moment when `from < t <= to`, so moments that touch share no event.

mod animation;
mod chart;
pub mod front;
pub mod ink;
pub mod panel;
mod sheet;
mod strip;
mod surround;
mod text;
pub mod view;
mod waterfall;

pub use animation::{write_animation, write_frames};
pub use chart::{Drawing, png, raster, svg};
pub use sheet::{Moment, Show, contact_sheet};
pub use strip::{StripCell, strip};
pub use surround::{SurroundShow, relief, surround};
pub use waterfall::{Classes, WaterfallShow, WaterfallStep, waterfall};

use std::{io, path::Path};

use image::{ExtendedColorType, ImageEncoder, RgbImage, codecs::png::PngEncoder};

use crate::{
    plane::Size,
    save::{SaveError, save},
};

/// A picture cannot be made.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PictureError {
    /// No moment to show.
    #[error("there is no moment to show")]
    #[diagnostic(help("give at least one frame"))]
    Nothing,
    /// Frames and packets of different sizes.
    #[error("the {what} is {got}, the sensor is {want}")]
    #[diagnostic(help("frames and packets of one picture have one size"))]
    Size {
        /// What does not fit.
        what: &'static str,
        /// Its size.
        got: Size,
        /// Size of the reference's sensor.
        want: Size,
    },
    /// A sensor without pixels.
    #[error("a sensor of {0} pixels cannot be shown")]
    #[diagnostic(help(
        "the file has no events and does not say how large its sensor is: give one that does"
    ))]
    NoPixels(Size),
    /// Larger than the file can be.
    #[error("the picture would be {0}; a side is at most 65535")]
    #[diagnostic(help("show fewer moments, or a part of the sensor"))]
    TooLarge(Size),
    /// The file cannot be saved.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Save(#[from] SaveError),
}

/// Whether a sensor has pixels, and not more than files can hold.
fn check(size: Size) -> Result<(), PictureError> {
    let most = usize::from(u16::MAX);
    if size.height.max(size.width) > most {
        return Err(PictureError::TooLarge(size));
    }
    if size.height.min(size.width) == 0 {
        return Err(PictureError::NoPixels(size));
    }
    Ok(())
}

/// Writes a drawing, whole or not at all: as SVG when the name ends in `.svg`, else as PNG.
///
/// # Errors
/// When the file cannot be written.
pub fn write_drawing(path: &Path, drawing: &Drawing) -> Result<(), SaveError> {
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("svg"))
    {
        return write_svg(path, drawing);
    }
    write_png(path, &raster(drawing, 2))
}

/// Writes a drawing as SVG, whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn write_svg(path: &Path, drawing: &Drawing) -> Result<(), SaveError> {
    let text = svg(drawing);
    save(path, |out| out.write_all(text.as_bytes()))
}

/// Writes a picture as PNG, whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png(path: &Path, picture: &RgbImage) -> Result<(), SaveError> {
    let (width, height) = picture.dimensions();
    save(path, |out| {
        PngEncoder::new(out)
            .write_image(picture, width, height, ExtendedColorType::Rgb8)
            .map_err(io::Error::other)
    })
}
