//! Several pages one after the other as a looping GIF or APNG.
//!
//! A GIF is small, because all colours are known beforehand (grays and a few inks, one palette), and
//! because a pixel whose gray hardly changes is left as it was.

use std::{io, path::Path};

use gif::{DisposalMethod, Encoder, Frame, Repeat};
use image::RgbImage;

use super::{
    Moment, PictureError, Show,
    ink::{COLOURED, Ink},
    sheet::Layout,
};
use crate::save::save;

/// Levels of gray in the palette.
const GRAYS: u8 = 64;
/// Palette index that leaves a pixel as it was in the page before.
const UNCHANGED: u8 = GRAYS + COLOURED.len() as u8;
/// Two grays (0 to 255) at most this far apart count as the same.
const HARDLY: u8 = 6;

/// Writes an animation of the moments, each shown for `hold` seconds (to a hundredth).
///
/// # Errors
/// When there is no moment, sizes differ, the picture would be too large, or the file cannot
/// be written.
pub fn write_animation(
    path: &Path,
    show: &Show<'_>,
    moments: &[Moment],
    hold: f64,
) -> Result<(), PictureError> {
    let layout = Layout::new(show, moments)?;
    // All pages have the size of the first, so whether they can be made is known here.
    let Some(first) = moments.first() else {
        return Err(PictureError::Nothing);
    };
    layout.page(show, &[first])?;
    let pages = moments
        .iter()
        .filter_map(|moment| layout.page(show, &[moment]).ok());
    write_gif(path, pages, hold)
}

/// Writes pages of one size one after the other, each shown for `hold` seconds: as APNG when
/// the name ends in `.apng` or `.png`, else as GIF, which knows the inks and grays only.
///
/// # Errors
/// When there is no page, or the file cannot be written.
pub fn write_frames(
    path: &Path,
    pages: impl Iterator<Item = RgbImage> + Clone,
    hold: f64,
) -> Result<(), PictureError> {
    let png = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("apng") || e.eq_ignore_ascii_case("png");
    if path.extension().is_some_and(png) {
        write_apng(path, pages, hold)
    } else {
        write_gif(path, pages, hold)
    }
}

fn write_apng(
    path: &Path,
    pages: impl Iterator<Item = RgbImage> + Clone,
    hold: f64,
) -> Result<(), PictureError> {
    let number = pages.clone().count() as u32;
    let mut pages = pages.peekable();
    let (width, height) = pages.peek().ok_or(PictureError::Nothing)?.dimensions();
    save(path, |out| {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(number, 0).map_err(io::Error::other)?;
        // `as` saturates.
        let hold = (hold * 1000.0).round() as u16;
        encoder
            .set_frame_delay(hold, 1000)
            .map_err(io::Error::other)?;
        let mut writer = encoder.write_header().map_err(io::Error::other)?;
        for page in pages {
            let written = writer.write_image_data(page.as_raw());
            written.map_err(io::Error::other)?;
        }
        writer.finish().map_err(io::Error::other)
    })?;
    Ok(())
}

fn write_gif(
    path: &Path,
    pages: impl Iterator<Item = RgbImage>,
    hold: f64,
) -> Result<(), PictureError> {
    let mut pages = pages.peekable();
    let (width, height) = pages.peek().ok_or(PictureError::Nothing)?.dimensions();
    save(path, |out| {
        // A page has at most 65535 pixels a side.
        let (width, height) = (width as u16, height as u16);
        let mut gif = Encoder::new(out, width, height, &palette()).map_err(io::Error::other)?;
        gif.set_repeat(Repeat::Infinite).map_err(io::Error::other)?;
        let mut screen: Option<RgbImage> = None;
        for page in pages {
            let buffer = match &mut screen {
                None => {
                    let all = page.pixels().map(|ink| entry(*ink)).collect::<Vec<_>>();
                    screen = Some(page);
                    all
                }
                Some(screen) => changes(screen, &page),
            };
            let frame = Frame {
                width,
                height,
                // `as` saturates.
                delay: (hold * 100.0).round() as u16,
                dispose: DisposalMethod::Keep,
                transparent: Some(UNCHANGED),
                buffer: buffer.into(),
                ..Frame::default()
            };
            gif.write_frame(&frame).map_err(io::Error::other)?;
        }
        Ok(())
    })?;
    Ok(())
}

fn palette() -> Vec<u8> {
    (0..GRAYS)
        .flat_map(|level| [(u32::from(level) * 255 / u32::from(GRAYS - 1)) as u8; 3])
        .chain(COLOURED.into_iter().flat_map(|ink| ink.0))
        .chain([255; 3])
        .collect()
}

/// The palette index of a colour.
fn entry(ink: Ink) -> u8 {
    let coloured = COLOURED.iter().position(|other| *other == ink);
    coloured.map_or_else(
        || (u32::from(ink.0[0]) * u32::from(GRAYS - 1) + 127).div_euclid(255) as u8,
        |i| GRAYS + i as u8,
    )
}

/// Palette indices of a frame that turns `screen` into `page`; pixels that stay are [`UNCHANGED`].
/// `screen` becomes what is then seen.
fn changes(screen: &mut RgbImage, page: &RgbImage) -> Vec<u8> {
    screen
        .pixels_mut()
        .zip(page.pixels())
        .map(|(old, new)| {
            if alike(*old, *new) {
                UNCHANGED
            } else {
                *old = *new;
                entry(*new)
            }
        })
        .collect()
}

/// Whether two inks are equal, or two grays no further apart than [`HARDLY`].
fn alike(a: Ink, b: Ink) -> bool {
    let gray = |ink: Ink| {
        let [r, g, b] = ink.0;
        (r == g && g == b).then_some(r)
    };
    a == b || matches!((gray(a), gray(b)), (Some(a), Some(b)) if a.abs_diff(b) <= HARDLY)
}
