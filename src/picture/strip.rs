//! A strip: what each register holds after each line of a program, as pictures.

use image::{
    RgbImage,
    imageops::{self, FilterType},
};

use super::{
    PictureError, ink, panel,
    text::{self, LINE, Weight},
};
use crate::plane::Size;

/// A register as it is after a line.
#[derive(Clone, Debug)]
pub struct StripCell {
    /// What it holds.
    pub picture: RgbImage,
    /// Whether the line wrote it.
    pub written: bool,
}

/// The longer side of a cell, in pixels.
const SIDE: u32 = 112;
const MARGIN: u32 = 16;
const GAP: u32 = 8;
const NAMES: u32 = 56;
/// Lines of a column's caption.
const CAPTION: u32 = 3;

/// A row for each register, a column for each line of the program with its text on top. What a
/// line has written is framed, all else is pale. Every column has a cell for each row.
///
/// # Errors
/// When there is nothing to show, or the picture would be too large.
pub fn strip(
    title: &str,
    rows: &[String],
    columns: &[(String, Vec<StripCell>)],
) -> Result<RgbImage, PictureError> {
    let first = columns.first().and_then(|(_, cells)| cells.first());
    let (width, height) = first.ok_or(PictureError::Nothing)?.picture.dimensions();
    let (width, height) = fitted(width, height);
    let column = width.max(SIDE);
    let left = |i: u32| MARGIN + NAMES + i * (column + GAP);
    let top = |i: u32| MARGIN + (1 + CAPTION) * LINE + GAP + i * (height + GAP);
    let (wide, high) = (left(columns.len() as u32), top(rows.len() as u32));
    let size = Size::new(high as usize, wide as usize);
    if wide.max(high) > u32::from(u16::MAX) {
        return Err(PictureError::TooLarge(size));
    }
    let mut page = RgbImage::from_pixel(wide + MARGIN - GAP, high + MARGIN - GAP, ink::PAGE);
    let room = wide - MARGIN;
    text::write_within(
        &mut page,
        (MARGIN, MARGIN - 4),
        room,
        title,
        Weight::Heading,
        ink::TEXT,
    );
    for (j, name) in (0..).zip(rows) {
        let middle = top(j) + height.saturating_sub(LINE) / 2;
        text::write_within(
            &mut page,
            (MARGIN, middle),
            NAMES,
            name,
            Weight::Heading,
            ink::TEXT,
        );
    }
    for (i, (caption, cells)) in (0..).zip(columns) {
        for (k, line) in (1..).zip(wrapped(caption, text::fits(column, Weight::Plain))) {
            let at = (left(i), MARGIN + k * LINE);
            text::write(&mut page, at, &line, Weight::Plain, ink::CAPTION);
        }
        for (j, cell) in (0..).zip(cells) {
            let (x, y) = (left(i), top(j));
            let mut picture = sized(&cell.picture, width, height);
            if cell.written {
                frame(&mut page, (x, y), (width, height));
            } else {
                picture = panel::pale(&picture);
            }
            imageops::replace(&mut page, &picture, x.into(), y.into());
        }
    }
    Ok(page)
}

/// The size of a cell: enlarged by a whole number, or made smaller.
fn fitted(width: u32, height: u32) -> (u32, u32) {
    let longer = width.max(height);
    if longer <= SIDE {
        let times = SIDE / longer.max(1);
        return (width * times, height * times);
    }
    let part = |side: u32| (side * SIDE / longer).max(1);
    (part(width), part(height))
}

fn sized(picture: &RgbImage, width: u32, height: u32) -> RgbImage {
    let (own, _) = picture.dimensions();
    if width >= own {
        panel::enlarged(picture, width / own.max(1))
    } else {
        imageops::resize(picture, width, height, FilterType::Triangle)
    }
}

/// Two pixels of ink around a cell.
fn frame(page: &mut RgbImage, (x, y): (u32, u32), (width, height): (u32, u32)) {
    for (dx, dy) in (0..width + 4).flat_map(|dx| (0..height + 4).map(move |dy| (dx, dy))) {
        let inside = (2..width + 2).contains(&dx) && (2..height + 2).contains(&dy);
        if let Some(pixel) = page.get_pixel_mut_checked(x + dx - 2, y + dy - 2)
            && !inside
        {
            *pixel = ink::ON;
        }
    }
}

/// A caption in at most [`CAPTION`] lines of `room` characters, broken at blanks where there are
/// any; the rest is cut off.
fn wrapped(text: &str, room: usize) -> Vec<String> {
    let room = room.max(3);
    let mut rest: Vec<char> = text.chars().collect();
    let mut lines: Vec<String> = Vec::new();
    while !rest.is_empty() {
        if lines.len() == CAPTION as usize {
            if let Some(last) = lines.last_mut() {
                *last = last.chars().take(room - 2).chain("..".chars()).collect();
            }
            break;
        }
        let blank = rest.iter().take(room + 1).rposition(|c| *c == ' ');
        let at = match blank {
            _ if rest.len() <= room => rest.len(),
            Some(at) if at > 0 => at,
            _ => room,
        };
        let tail = rest.split_off(at);
        lines.push(rest.into_iter().collect());
        rest = tail.into_iter().skip_while(|c| *c == ' ').collect();
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn captions_are_cut_at_three_lines() {
        assert_eq!(wrapped("abcd", 3), ["abc", "d"]);
        assert_eq!(wrapped("abcdefghij", 3), ["abc", "def", "g.."]);
        assert_eq!(
            wrapped("33 AND(R9, R5, R7);", 12),
            ["33 AND(R9,", "R5, R7);"]
        );
        assert_eq!(wrapped("ab cd", 5), ["ab cd"]);
        assert!(wrapped("", 3).is_empty());
    }

    #[test]
    fn small_arrays_are_enlarged_and_large_ones_made_smaller() {
        assert_eq!(fitted(7, 5), (112, 80));
        assert_eq!(fitted(1, 1), (112, 112));
        assert_eq!(fitted(256, 128), (112, 56));
        assert_eq!(fitted(4096, 1), (112, 1));
    }

    #[test]
    fn what_was_written_is_framed() {
        let cell = |written| StripCell {
            picture: RgbImage::from_pixel(4, 4, ink::TEXT),
            written,
        };
        let rows = ["A".to_owned(), "B".to_owned()];
        let columns = [("1 x".to_owned(), vec![cell(true), cell(false)])];
        let picture = strip("t", &rows, &columns).unwrap();
        let framed = picture.pixels().filter(|p| **p == ink::ON).count();
        assert_eq!(framed, 116 * 116 - 112 * 112);
        assert!(strip("t", &rows, &[]).is_err());
    }
}
