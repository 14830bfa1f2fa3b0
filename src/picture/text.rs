//! Captions in a small bitmap typeface that is part of the program.

use image::{Rgb, RgbImage};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::ink::Ink;

/// A typeface at one weight and size.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    font: FontWeight,
    height: RasterHeight,
}

impl Face {
    /// For pages with `scale` pixels a point, 1 or 2.
    pub const fn new(weight: Weight, scale: u32) -> Self {
        Self {
            font: weight.font(),
            height: if scale > 1 {
                RasterHeight::Size32
            } else {
                RasterHeight::Size16
            },
        }
    }

    /// Width of a text, in pixels.
    pub fn width(self, text: &str) -> u32 {
        (text.chars().count() * get_raster_width(self.font, self.height)) as u32
    }
}

/// Height of a line, in pixels.
pub const LINE: u32 = 20;

/// The weight of a text: plain, or bold for headings.
#[derive(Clone, Copy, Debug)]
pub enum Weight {
    Plain,
    Heading,
}

impl Weight {
    const fn font(self) -> FontWeight {
        match self {
            Self::Plain => FontWeight::Regular,
            Self::Heading => FontWeight::Bold,
        }
    }
}

/// Characters that fit into `width` pixels.
pub const fn fits(width: u32, weight: Weight) -> usize {
    width as usize / get_raster_width(weight.font(), RasterHeight::Size16)
}

/// Writes a line with its upper left corner at `at`; returns the x at which it ends.
pub fn write(page: &mut RgbImage, at: (u32, u32), text: &str, weight: Weight, ink: Ink) -> u32 {
    write_in(page, at, text, Face::new(weight, 1), ink)
}

/// What is written in place of letters that the typeface, of Latin letters, does not have.
const SPELLED: [(char, &str); 27] = [
    ('μ', "µ"),
    ('≥', ">="),
    ('≤', "<="),
    ('≠', "!="),
    ('≈', "~"),
    ('−', "-"),
    ('–', "-"),
    ('—', "-"),
    ('…', "..."),
    ('→', "->"),
    ('←', "<-"),
    ('√', "sqrt "),
    ('∞', "inf"),
    ('‘', "'"),
    ('’', "'"),
    ('“', "\""),
    ('”', "\""),
    ('α', "alpha"),
    ('β', "beta"),
    ('θ', "theta"),
    ('λ', "lambda"),
    ('π', "pi"),
    ('σ', "sigma"),
    ('τ', "tau"),
    ('Δ', "Delta"),
    ('Σ', "Sigma"),
    ('Ω', "Ohm"),
];

/// What is written in place of a letter, if anything.
fn spelled(c: char) -> Option<&'static str> {
    let found = SPELLED.iter().find(|(letter, _)| *letter == c);
    found.map(|(_, text)| *text)
}

/// Whether the typeface has a letter.
fn is_drawn(c: char) -> bool {
    get_raster(c, FontWeight::Regular, RasterHeight::Size16).is_some()
}

/// The letters of texts of which pixels show a question mark, each once: their typeface has none.
/// An SVG has all letters.
#[must_use]
pub fn unknown_letters<'a>(texts: impl IntoIterator<Item = &'a str>) -> Vec<char> {
    let mut unknown = Vec::new();
    for c in texts.into_iter().flat_map(str::chars) {
        if !is_drawn(c) && spelled(c).is_none() && !unknown.contains(&c) {
            unknown.push(c);
        }
    }
    unknown
}

/// A text in the letters of the typeface.
pub fn in_letters(text: &str) -> String {
    let mut letters = String::with_capacity(text.len());
    for c in text.chars() {
        match spelled(c) {
            _ if is_drawn(c) => letters.push(c),
            Some(text) => letters += text,
            None => letters.push('?'),
        }
    }
    letters
}

/// [`write`] in any face.
pub fn write_in(page: &mut RgbImage, at: (u32, u32), text: &str, face: Face, ink: Ink) -> u32 {
    let (mut x, y) = at;
    for c in in_letters(text).chars() {
        let Some(letter) = get_raster(c, face.font, face.height) else {
            continue;
        };
        for (dy, row) in (0..).zip(letter.rows()) {
            for (dx, cover) in (0..).zip(row) {
                if let Some(pixel) = page.get_pixel_mut_checked(x + dx, y + dy) {
                    *pixel = blend(*pixel, ink, *cover);
                }
            }
        }
        x += letter.width() as u32;
    }
    x
}

/// [`write`], cut off where it would be wider than `width` pixels.
pub fn write_within(
    page: &mut RgbImage,
    at: (u32, u32),
    width: u32,
    text: &str,
    weight: Weight,
    ink: Ink,
) {
    let room = fits(width, weight);
    let text = in_letters(text);
    if text.chars().count() <= room {
        write(page, at, &text, weight, ink);
    } else {
        let mut cut: String = text.chars().take(room.saturating_sub(2)).collect();
        cut.push_str("..");
        write(page, at, &cut, weight, ink);
    }
}

fn blend(below: Ink, ink: Ink, cover: u8) -> Ink {
    let mix = |a: u8, b: u8| {
        let (a, b, cover) = (u32::from(a), u32::from(b), u32::from(cover));
        ((a * (255 - cover) + b * cover + 127) / 255) as u8
    };
    let ([r, g, b], [ir, ig, ib]) = (below.0, ink.0);
    Rgb([mix(r, ir), mix(g, ig), mix(b, ib)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_drawn_or_spelled_or_told() {
        assert_eq!(in_letters("5 µm², 3×2, é"), "5 µm², 3×2, é");
        assert_eq!(in_letters("λ ≥ 1 − τ…"), "lambda >= 1 - tau...");
        assert_eq!(in_letters("眼 a"), "? a");
        assert!(unknown_letters(["µ² × ≥ λ"]).is_empty());
        assert_eq!(unknown_letters(["a 眼", "網眼"]), ['眼', '網']);
        for (letter, text) in SPELLED {
            assert!(!is_drawn(letter) && text.chars().all(is_drawn), "{letter}");
        }
    }
}
