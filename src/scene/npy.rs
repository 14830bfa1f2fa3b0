//! `.npy` arrays of shape `(frames, height, width)`: numbers as given.
//!
//! The numbers are read frame by frame; `ndarray-npy`, which reads whole arrays, would hold
//! the clip in memory. Format: `numpy.lib.format`, versions 1 to 3.

use std::{
    io::{self, Read},
    path::{Path, PathBuf},
};

use super::{
    Frame, Image, Levels, OpenOptions, Scene, SceneError, decoded::Source, light,
    light::MemoryLimit, rate::Rate,
};
use crate::plane::Size;

/// The first bytes of every file.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// The longest header that is read; `numpy` itself stops at 10 000.
const LONGEST_HEADER: u64 = 65_535;

/// A stream of frames in an `.npy` file.
pub(super) struct Npy<R> {
    path: PathBuf,
    stream: R,
    size: Size,
    number: Number,
    rate: Rate,
    frames: u64,
    next: u64,
    bytes: Vec<u8>,
}

/// Opens an `.npy` file.
pub(super) fn open(
    path: &Path,
    options: OpenOptions,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    let stream = light::open_file(path)?;
    let length = stream
        .get_ref()
        .metadata()
        .ok()
        .filter(std::fs::Metadata::is_file)
        .map(|data| data.len());
    let npy = Npy::new(path, stream, length, options)?;
    let source = npy.number.source();
    Ok((npy, source))
}

impl<R: Read + Send> Npy<R> {
    /// Reads the header; `length` is that of the whole stream, where it is known.
    fn new(
        path: &Path,
        mut stream: R,
        length: Option<u64>,
        options: OpenOptions,
    ) -> Result<Self, SceneError> {
        let (text, before) = header(path, &mut stream)?;
        let header = Header::parse(&text).map_err(|(field, want)| SceneError::Header {
            path: path.into(),
            field,
            got: format!("{:?}", text.trim_end()),
            want,
        })?;
        let number = Number::named(&header.descr).ok_or_else(|| SceneError::NumberType {
            path: path.into(),
            got: header.descr.clone(),
        })?;
        let &[frames, height, width] = header.shape.as_slice() else {
            return Err(SceneError::Axes {
                path: path.into(),
                shape: header.shape,
            });
        };
        if frames == 0 {
            return Err(SceneError::Empty {
                path: path.into(),
                missing: "frame",
            });
        }
        let axis = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
        let size = light::checked_size(path, axis(height), axis(width))?;
        // With at most one axis longer than 1, row-major and column-major order are the same bytes.
        if header.fortran && header.shape.iter().filter(|n| **n > 1).count() > 1 {
            return Err(SceneError::FortranOrder { path: path.into() });
        }
        MemoryLimit::new(options).check(path, size, held(number, size))?;
        let want = u128::from(frames) * (size.pixels() * number.bytes()) as u128;
        if let Some(got) = length.map(|length| length.saturating_sub(before))
            && u128::from(got) != want
        {
            return Err(SceneError::Length {
                path: path.into(),
                got,
                want,
            });
        }
        light::check_number(path, frames - 1)?;
        Ok(Self {
            path: path.into(),
            stream,
            size,
            number,
            rate: Rate::asked_or_assumed(options.fps),
            frames,
            next: 0,
            bytes: Vec::new(),
        })
    }

    /// The numbers of the frame that was read.
    fn numbers(&self, index: u64) -> Result<Vec<f64>, SceneError> {
        let width = self.size.width;
        let mut numbers = Vec::with_capacity(self.size.pixels());
        for (place, bytes) in self.bytes.chunks_exact(self.number.bytes()).enumerate() {
            let (y, x) = (place / width, place % width);
            let value = match self.number.read(bytes) {
                Value::Real(value) => value,
                Value::Inexact(value) => {
                    return Err(SceneError::Inexact {
                        path: self.path.clone(),
                        frame: index,
                        y,
                        x,
                        value,
                    });
                }
            };
            if !value.is_finite() {
                return Err(SceneError::NotFinite {
                    path: self.path.clone(),
                    frame: index,
                    y,
                    x,
                    value,
                });
            }
            numbers.push(value);
        }
        Ok(numbers)
    }
}

impl<R: Read + Send> Scene for Npy<R> {
    fn size(&self) -> Size {
        self.size
    }
    fn fps(&self) -> f64 {
        self.rate.fps
    }
    fn fps_is_assumed(&self) -> bool {
        self.rate.assumed
    }
    fn frames(&self) -> Option<u64> {
        Some(self.frames)
    }
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.next == self.frames {
            return Ok(None);
        }
        let index = self.next;
        let want = (self.size.pixels() * self.number.bytes()) as u64;
        // Reading through `take` allocates what is there, not what the header claims.
        self.bytes.clear();
        let got = (&mut self.stream)
            .take(want)
            .read_to_end(&mut self.bytes)
            .map_err(|cause| SceneError::unreadable(&self.path, cause))? as u64;
        let truncated = || SceneError::Truncated {
            path: self.path.clone(),
            frame: index,
            got,
            want,
        };
        if got < want {
            return Err(truncated());
        }
        let light = match self.number.kind {
            Kind::U1 => {
                Image::of_bytes(self.size, std::mem::take(&mut self.bytes), Levels::bytes())
            }
            Kind::U2 => {
                let read = if self.number.big_end_first {
                    u16::from_be_bytes
                } else {
                    u16::from_le_bytes
                };
                let (pairs, _) = self.bytes.as_chunks();
                let codes = pairs.iter().map(|pair| read(*pair)).collect();
                Image::of_words(self.size, codes, Levels::words())
            }
            _ => light::plane(self.size, self.numbers(index)?).map(Image::from),
        };
        let light = light.ok_or_else(truncated)?;
        self.next += 1;
        Ok(Some(Frame {
            index,
            seconds: self.rate.seconds(index),
            light,
        }))
    }
    fn bytes(&self) -> u128 {
        held(self.number, self.size)
    }
}

/// Bytes held for a frame: as it is stored, twice where that is light, and as light.
fn held(number: Number, size: Size) -> u128 {
    (2 * number.bytes() as u128 + light::PIXEL_BYTES_HELD) * size.pixels() as u128
}

/// The type of the array's numbers.
#[derive(Clone, Copy, Debug)]
struct Number {
    kind: Kind,
    big_end_first: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    F2,
    F4,
    F8,
    U1,
    U2,
    U4,
    U8,
    I1,
    I2,
    I4,
    I8,
}

/// A number that was read.
enum Value {
    Real(f64),
    /// A whole number that no `f64` equals.
    Inexact(i128),
}

impl Number {
    /// The type that a `descr` such as `<f8` names.
    fn named(descr: &str) -> Option<Self> {
        let (big_end_first, name) = match descr.as_bytes().first()? {
            b'<' | b'|' => (false, &descr[1..]),
            b'>' => (true, &descr[1..]),
            b'=' => (cfg!(target_endian = "big"), &descr[1..]),
            _ => return None,
        };
        let kind = match name {
            "f2" => Kind::F2,
            "f4" => Kind::F4,
            "f8" => Kind::F8,
            "u1" => Kind::U1,
            "u2" => Kind::U2,
            "u4" => Kind::U4,
            "u8" => Kind::U8,
            "i1" => Kind::I1,
            "i2" => Kind::I2,
            "i4" => Kind::I4,
            "i8" => Kind::I8,
            _ => return None,
        };
        Some(Self {
            kind,
            big_end_first,
        })
    }

    /// What such numbers are as samples; those with a sign have no range.
    fn source(self) -> Source {
        match self.kind {
            Kind::F2 | Kind::F4 | Kind::F8 => Source::floats(),
            Kind::U1 => Source::integers(Some(8)),
            Kind::U2 => Source::integers(Some(16)),
            _ => Source::integers(None),
        }
    }

    fn bytes(self) -> usize {
        match self.kind {
            Kind::U1 | Kind::I1 => 1,
            Kind::F2 | Kind::U2 | Kind::I2 => 2,
            Kind::F4 | Kind::U4 | Kind::I4 => 4,
            Kind::F8 | Kind::U8 | Kind::I8 => 8,
        }
    }

    fn read(self, bytes: &[u8]) -> Value {
        let fold = |all: u64, byte: &u8| all << 8 | u64::from(*byte);
        let bits = if self.big_end_first {
            bytes.iter().fold(0, fold)
        } else {
            bytes.iter().rev().fold(0, fold)
        };
        match self.kind {
            Kind::F2 => Value::Real(half::f16::from_bits(bits as u16).to_f64()),
            Kind::F4 => Value::Real(f32::from_bits(bits as u32).into()),
            Kind::F8 => Value::Real(f64::from_bits(bits)),
            Kind::U1 | Kind::U2 | Kind::U4 | Kind::U8 => exact(bits.into()),
            Kind::I1 => exact((bits as i8).into()),
            Kind::I2 => exact((bits as i16).into()),
            Kind::I4 => exact((bits as i32).into()),
            Kind::I8 => exact((bits as i64).into()),
        }
    }
}

fn exact(value: i128) -> Value {
    let real = value as f64;
    if real as i128 == value {
        Value::Real(real)
    } else {
        Value::Inexact(value)
    }
}

/// The text of the header, and how many bytes come before the numbers.
fn header(path: &Path, stream: &mut impl Read) -> Result<(String, u64), SceneError> {
    let bad = |field, got: &[u8], want| SceneError::Header {
        path: path.into(),
        field,
        got: format!("\"{}\"", got.escape_ascii()),
        want,
    };
    let mut take = |n: u64| -> Result<Vec<u8>, SceneError> {
        let mut bytes = Vec::new();
        let read: io::Result<usize> = stream.take(n).read_to_end(&mut bytes);
        read.map_err(|cause| SceneError::unreadable(path, cause))?;
        Ok(bytes)
    };
    let start = take(8)?;
    if start.is_empty() {
        return Err(SceneError::Empty {
            path: path.into(),
            missing: "header",
        });
    }
    let wide = match start.strip_prefix(MAGIC) {
        Some([1, 0]) => 2,
        Some([2 | 3, 0]) => 4,
        Some(version) => return Err(bad("version", version, "1.0, 2.0 or 3.0")),
        None => return Err(bad("magic", &start, "\\x93NUMPY and a version")),
    };
    let length = take(wide)?;
    if (length.len() as u64) < wide {
        return Err(bad("length", &length, "the length of the header"));
    }
    let says = length
        .iter()
        .rev()
        .fold(0, |all, byte| all << 8 | u64::from(*byte));
    if says > LONGEST_HEADER {
        return Err(bad("length", &length, "at most 65535 bytes"));
    }
    let text = take(says)?;
    if (text.len() as u64) < says {
        return Err(bad(
            "text",
            &text,
            "a whole header; the file ends inside it",
        ));
    }
    match String::from_utf8(text) {
        Ok(text) => Ok((text, 8 + wide + says)),
        Err(error) => Err(bad("text", error.as_bytes(), "text")),
    }
}

/// What the header says.
#[derive(Debug, PartialEq)]
struct Header {
    descr: String,
    fortran: bool,
    shape: Vec<u64>,
}

/// A field that is wrong, and what was expected instead.
type Wrong = (&'static str, &'static str);

impl Header {
    /// Reads the Python dictionary of the header: strings, booleans, and one tuple.
    fn parse(text: &str) -> Result<Self, Wrong> {
        const DICTIONARY: Wrong = ("text", "{'descr': …, 'fortran_order': …, 'shape': …}");
        const DESCR: Wrong = ("descr", "a plain type in quotes, such as '<f8'");
        const ORDER: Wrong = ("fortran_order", "True or False");
        const SHAPE: Wrong = ("shape", "whole numbers in brackets, such as (10, 64, 64)");
        let (mut descr, mut fortran, mut shape) = (None, None, None);
        let mut rest = text
            .trim()
            .strip_prefix('{')
            .ok_or(DICTIONARY)?
            .trim_start();
        while !rest.starts_with('}') {
            let (key, after) = quoted(rest).ok_or(DICTIONARY)?;
            rest = after
                .trim_start()
                .strip_prefix(':')
                .ok_or(DICTIONARY)?
                .trim_start();
            match key {
                "descr" => {
                    let (word, after) = quoted(rest).ok_or(DESCR)?;
                    descr = Some(word.to_owned());
                    rest = after;
                }
                "fortran_order" => {
                    let word = ["True", "False"].into_iter().find(|w| rest.starts_with(w));
                    let word = word.ok_or(ORDER)?;
                    fortran = Some(word == "True");
                    rest = &rest[word.len()..];
                }
                "shape" => {
                    let inside = rest.strip_prefix('(').ok_or(SHAPE)?;
                    let (inside, after) = inside.split_once(')').ok_or(SHAPE)?;
                    let words = inside.split(',').map(str::trim);
                    let axes: Result<_, _> =
                        words.filter(|w| !w.is_empty()).map(str::parse).collect();
                    shape = Some(axes.map_err(|_| SHAPE)?);
                    rest = after;
                }
                _ => return Err(DICTIONARY),
            }
            rest = rest.trim_start();
            if let Some(after) = rest.strip_prefix(',') {
                rest = after.trim_start();
            } else if !rest.starts_with('}') {
                return Err(DICTIONARY);
            }
        }
        if !rest[1..].trim().is_empty() {
            return Err(DICTIONARY);
        }
        Ok(Self {
            descr: descr.ok_or(DESCR)?,
            fortran: fortran.ok_or(ORDER)?,
            shape: shape.ok_or(SHAPE)?,
        })
    }
}

/// A quoted string at the start of `text`, and what follows it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

#[cfg(test)]
mod tests {
    use ndarray_npy::WriteNpyExt;
    use proptest::prelude::*;

    use super::*;

    fn read(bytes: &[u8]) -> Result<Vec<Frame>, SceneError> {
        let mut scene = Npy::new(
            Path::new("a.npy"),
            bytes,
            Some(bytes.len() as u64),
            OpenOptions::default(),
        )?;
        let mut frames = Vec::new();
        while let Some(frame) = scene.next_frame()? {
            frames.push(frame);
        }
        Ok(frames)
    }

    /// Every type, written by `ndarray-npy`, comes back as the same numbers.
    #[test]
    fn every_type_is_read_as_given() {
        macro_rules! check {
            ($($type:ty),*) => {$({
                let numbers: [$type; 6] = [0, 1, 2, 3, <$type>::MAX >> (<$type>::BITS / 2), <$type>::MIN];
                check_one(numbers, |n| n as f64);
            })*};
        }
        fn check_one<T: ndarray_npy::WritableElement + Copy>(numbers: [T; 6], real: fn(T) -> f64) {
            let array = ndarray::Array3::from_shape_vec((2, 1, 3), numbers.to_vec()).unwrap();
            let mut bytes = Vec::new();
            array.write_npy(&mut bytes).unwrap();
            let frames = read(&bytes).unwrap();
            assert_eq!(frames.len(), 2);
            assert_eq!(frames[1].seconds, 1.0 / 240.0);
            for (place, number) in numbers.iter().enumerate() {
                assert_eq!(frames[place / 3].light[(0, place % 3)], real(*number));
            }
        }
        check!(u8, u16, u32, u64, i8, i16, i32, i64);
        check_one(
            [0.0, -1.5, f32::MIN_POSITIVE, 3.25, 1e30, -0.1_f32],
            f64::from,
        );
        check_one([0.0, -1.5, f64::MIN_POSITIVE, 3.25, 1e300, -0.1_f64], |n| n);
    }

    #[test]
    fn either_end_may_be_first() {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        let text = b"{'descr': '>f2', 'fortran_order': True, 'shape': (1, 1, 2), }\n";
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text);
        bytes.extend([0x3c, 0x00, 0xc1, 0x00]);
        let light = &read(&bytes).unwrap()[0].light;
        assert_eq!((light[(0, 0)], light[(0, 1)]), (1.0, -2.5));
    }

    #[test]
    fn numbers_that_no_real_equals_are_refused() {
        let array = ndarray::arr3(&[[[1_i64 << 53, (1 << 53) + 1]]]);
        let mut bytes = Vec::new();
        array.write_npy(&mut bytes).unwrap();
        let message = read(&bytes).unwrap_err().to_string();
        assert!(message.contains("x 1: 9007199254740993"), "{message}");
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes: Vec<u8>) {
            prop_assert!(read(&bytes).is_err());
            let mut after = b"\x93NUMPY\x01\x00".to_vec();
            after.extend(&bytes);
            prop_assert!(read(&after).is_err());
        }

        #[test]
        fn any_header_is_read_or_refused(
            text in "\\{('(descr|fortran_order|shape)': ('[<>|][fui][1248]'|True|False|\\([0-9]{0,9},[0-9]{0,20},[ 0-9]{0,20}\\)),? ?){0,4}\\}?.{0,3}"
        ) {
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend((text.len() as u16).to_le_bytes());
            bytes.extend(text.as_bytes());
            bytes.extend([0; 16]);
            let _ = read(&bytes);
        }

        #[test]
        fn a_cut_file_is_an_error(cut in 0_usize..176) {
            let array = ndarray::Array3::<f64>::zeros((2, 1, 3));
            let mut bytes = Vec::new();
            array.write_npy(&mut bytes).unwrap();
            prop_assert_eq!(bytes.len(), 176);
            prop_assert!(read(&bytes[..cut]).is_err());
        }
    }
}
