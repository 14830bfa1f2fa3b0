//! Writing pictures and drawings to files.

use std::{io, path::Path};

use image::{ExtendedColorType, ImageEncoder, RgbImage, codecs::png::PngEncoder};

use super::chart::{Drawing, raster, svg};
use crate::save::{SaveError, save};

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
