//! The panels of a contact sheet one moment after the other, as a GIF that loops.
//!
//! Small, because all colours are known beforehand (grays and a few inks, one palette), and
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
/// The palette's entry for "as it was".
const UNCHANGED: u8 = GRAYS + COLOURED.len() as u8;
/// Grays, of 255, that pass for the same.
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
    let layout = Layout::of(show, moments)?;
    let Some(first) = moments.first() else {
        return Err(PictureError::Nothing);
    };
    let (width, height) = layout.page(show, &[first])?.dimensions();
    save(path, |out| {
        // A page has at most 65535 pixels a side.
        let (width, height) = (width as u16, height as u16);
        let mut gif = Encoder::new(out, width, height, &palette()).map_err(io::Error::other)?;
        gif.set_repeat(Repeat::Infinite).map_err(io::Error::other)?;
        let mut screen: Option<RgbImage> = None;
        for moment in moments {
            let page = layout.page(show, &[moment]).map_err(io::Error::other)?;
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

/// The palette's entry for a colour.
fn entry(ink: Ink) -> u8 {
    let coloured = COLOURED.iter().position(|other| *other == ink);
    coloured.map_or_else(
        || (u32::from(ink.0[0]) * u32::from(GRAYS - 1) + 127).div_euclid(255) as u8,
        |i| GRAYS + i as u8,
    )
}

/// What must be drawn to get from the screen to the page; the screen follows.
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

/// The same ink, or two grays that are hardly different.
fn alike(a: Ink, b: Ink) -> bool {
    let gray = |ink: Ink| {
        let [r, g, b] = ink.0;
        (r == g && g == b).then_some(r)
    };
    a == b || matches!((gray(a), gray(b)), (Some(a), Some(b)) if a.abs_diff(b) <= HARDLY)
}
