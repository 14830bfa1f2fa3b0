//! Gray pictures of samples up to any white (PGM, P5), exactly; and what may stand behind a PNM.
//!
//! The crate `image` rounds a white of 100 or 1023 to 255 or 65535.

use std::{
    io::{BufRead, Read},
    path::Path,
    sync::{Mutex, PoisonError},
};

use crate::scene::{
    Image, Levels, SceneError,
    checks::{self, MemoryLimit},
};

/// What such a file begins with.
pub(super) const MAGIC: &[u8] = b"P5";

/// Bytes of a header that are read; comments may be long.
const LONGEST_HEADER: u64 = 1 << 16;

/// Reads the picture, and the bits of a sample.
pub(super) fn read(
    file: &mut impl BufRead,
    path: &Path,
    frame: u64,
    room: MemoryLimit,
) -> Result<(Image, u32), SceneError> {
    let damaged = |what: String| SceneError::Picture {
        path: path.into(),
        frame,
        cause: what.into(),
    };
    let mut header = file.by_ref().take(LONGEST_HEADER);
    header.consume(MAGIC.len());
    let mut next = |what| number(&mut header, what).map_err(damaged);
    let (width, height, white) = (next("width")?, next("height")?, next("white")?);
    let side = |n: u32| usize::try_from(n).unwrap_or(usize::MAX);
    let size = checks::checked_size(path, side(height), side(width))?;
    let white = u16::try_from(white).ok().filter(|white| *white > 0);
    let white = white.ok_or_else(|| damaged("its white is not from 1 to 65535".into()))?;
    let wide = if white > 255 { 2 } else { 1 };
    let pixels = size.pixels();
    let held = wide as u128 + checks::PIXEL_BYTES;
    room.check(path, size, held * pixels as u128)?;
    let (mut bytes, want) = (Vec::new(), (pixels * wide) as u64);
    let got = file.take(want).read_to_end(&mut bytes);
    let got = got.map_err(|cause| SceneError::unreadable(path, cause))? as u64;
    if got < want {
        return Err(SceneError::Truncated {
            path: path.into(),
            frame,
            got,
            want,
        });
    }
    let image = if wide == 1 {
        check(&bytes, u8::try_from(white).unwrap_or(u8::MAX)).map_err(damaged)?;
        Image::of_bytes(size, bytes, levels(white))
    } else {
        let pairs = bytes.as_chunks().0.iter();
        let codes: Vec<u16> = pairs.map(|pair| u16::from_be_bytes(*pair)).collect();
        check(&codes, white).map_err(damaged)?;
        Image::of_words(size, codes, levels(white))
    };
    let bits = match white {
        0..=255 => 8,
        1023 => 10,
        4095 => 12,
        _ => 16,
    };
    let image = image.ok_or_else(|| damaged("too few samples".into()))?;
    Ok((image, bits))
}

fn check<T: Copy + Ord + std::fmt::Display>(codes: &[T], white: T) -> Result<(), String> {
    match codes.iter().find(|code| **code > white) {
        Some(code) => Err(format!("a sample is {code}, and its white {white}")),
        None => Ok(()),
    }
}

/// What codes up to a white stand for. Those of the last white are kept: pictures of a folder share
/// them.
fn levels(white: u16) -> Levels {
    static LAST: Mutex<Option<(u16, Levels)>> = Mutex::new(None);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    match &*last {
        Some((known, levels)) if *known == white => levels.clone(),
        _ => {
            let light = |code: f64| code * 255.0 / f64::from(white);
            let levels = match white {
                255 => Levels::bytes(),
                0..=255 => Levels::bytes().map(light),
                _ => Levels::of_words(|code| light(code.into())),
            };
            *last = Some((white, levels.clone()));
            levels
        }
    }
}

/// The next number of a header, and one byte of space behind it; comments run to the end of a line.
fn number(header: &mut impl BufRead, what: &str) -> Result<u32, String> {
    let mut digits = String::new();
    let mut is_comment = false;
    for byte in header.bytes() {
        let byte = byte.map_err(|cause| cause.to_string())?;
        match byte {
            b'\n' | b'\r' if is_comment => is_comment = false,
            _ if is_comment => {}
            b'#' if digits.is_empty() => is_comment = true,
            b'0'..=b'9' => digits.push(byte.into()),
            _ if byte.is_ascii_whitespace() && digits.is_empty() => {}
            _ if byte.is_ascii_whitespace() => {
                return digits
                    .parse()
                    .map_err(|_| format!("its {what} is {digits}"));
            }
            _ => break,
        }
    }
    Err(format!("its header has no {what}"))
}

/// Refuses what stands behind a picture, but for white space.
pub(super) fn check_end(file: &mut impl BufRead, path: &Path) -> Result<(), SceneError> {
    let unreadable = |cause| SceneError::unreadable(path, cause);
    loop {
        let bytes = file.fill_buf().map_err(unreadable)?;
        if bytes.is_empty() {
            return Ok(());
        }
        if let Some(at) = bytes.iter().position(|byte| !byte.is_ascii_whitespace()) {
            let begin = &bytes[at..];
            return Err(SceneError::Behind {
                path: path.into(),
                is_another: matches!(begin, [b'P', b'1'..=b'7', ..]),
            });
        }
        let length = bytes.len();
        file.consume(length);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{plane::Size, scene::OpenOptions};

    fn of(bytes: &[u8]) -> Result<Vec<f64>, SceneError> {
        let (mut file, path) = (bytes, Path::new("a.pgm"));
        let room = MemoryLimit::new(OpenOptions::default());
        let (image, _) = read(&mut file, path, 0, room)?;
        check_end(&mut file, path)?;
        assert_eq!(image.size(), Size::new(1, 2));
        Ok(image.iter().copied().collect())
    }

    #[test]
    fn any_white_is_exact() {
        assert_eq!(of(b"P5 2 1 100\n\x32\x64").unwrap(), [127.5, 255.0]);
        assert_eq!(of(b"P5\n# a\n2 1\n255\n\x00\xff\n").unwrap(), [0.0, 255.0]);
        let ten = of(b"P5 2 1 1023\n\x02\x00\x00\x01").unwrap();
        assert_eq!(ten, [512.0 * 255.0 / 1023.0, 255.0 / 1023.0]);
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        for (bytes, words) in [
            (
                &b"P5 2 1 100\n\x32\x65"[..],
                "a sample is 101, and its white 100",
            ),
            (b"P5 2 1 100\n\x32", "1 of 2 bytes"),
            (b"P5 2 1 0\n\x00\x00", "white"),
            (b"P5 2 x", "no height"),
            (
                b"P5 2 1 255\n\x00\x00P5 2 1 255\n\x01\x01",
                "another picture",
            ),
            (b"P5 2 1 255\n\x00\x00 \x01", "bytes that are no part of it"),
        ] {
            let error = of(bytes).unwrap_err();
            let cause = std::error::Error::source(&error);
            let told = format!(
                "{error} {}",
                cause.map_or(String::new(), ToString::to_string)
            );
            assert!(told.contains(words), "{told}");
        }
    }
}
