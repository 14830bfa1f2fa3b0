//! `.npy` arrays of shape `(frames, height, width)` or `(frames, 1, height, width)`: numbers as
//! given.
//!
//! The numbers are read frame by frame; a whole array would hold the clip in memory.

use std::{
    io::Read,
    path::{Path, PathBuf},
};

use crate::{
    npy::{Header, HeaderError, Kind, Number, Value},
    plane::Size,
    scene::{
        Frame, Image, Levels, OpenOptions, Outline, Scene, SceneError,
        checks::{self, MemoryLimit},
        light::conversion::Source,
        time::frame_rate::Rate,
    },
};

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
pub(in crate::scene) fn open(
    path: &Path,
    options: OpenOptions,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    let stream = checks::open_file(path)?;
    let length = checks::known_length(&stream);
    let npy = Npy::new(path, stream, length, options)?;
    let source = samples(npy.number);
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
        let (header, before) = header(path, &mut stream)?;
        // Truth values are no light.
        let number = Number::named(&header.descr).filter(|number| number.kind != Kind::B1);
        let number = number.ok_or_else(|| SceneError::NumberType {
            path: path.into(),
            got: header.descr.clone(),
        })?;
        // (T,1,H,W) is what networks take.
        let (&[frames, height, width] | &[frames, 1, height, width]) = header.shape.as_slice()
        else {
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
        let size = checks::checked_size(path, axis(height), axis(width))?;
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
        checks::check_number(path, frames - 1)?;
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
    fn outline(&self) -> Outline {
        Outline {
            frames: Some(self.frames),
            bytes: held(self.number, self.size),
            ..Outline::at(self.rate, self.size)
        }
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
            _ => checks::plane(self.size, self.numbers(index)?).map(Image::from),
        };
        let light = light.ok_or_else(truncated)?;
        self.next += 1;
        Ok(Some(Frame {
            index,
            seconds: self.rate.seconds(index),
            light,
        }))
    }
}

/// Bytes held for a frame: as it is stored, twice where that is light, and as light.
fn held(number: Number, size: Size) -> u128 {
    (2 * number.bytes() as u128 + checks::PIXEL_BYTES_HELD) * size.pixels() as u128
}

/// What numbers are as samples; those with a sign have no range.
fn samples(number: Number) -> Source {
    match number.kind {
        Kind::F2 | Kind::F4 | Kind::F8 => Source::floats(),
        Kind::U1 => Source::integers(Some(8)),
        Kind::U2 => Source::integers(Some(16)),
        _ => Source::integers(None),
    }
}

/// Reads the header, and how many bytes come before the numbers.
fn header(path: &Path, stream: &mut impl Read) -> Result<(Header, u64), SceneError> {
    let path = path.to_owned();
    Header::read(stream).map_err(|error| match error {
        HeaderError::System(cause) => SceneError::unreadable(&path, cause),
        HeaderError::Empty => SceneError::Empty {
            path,
            missing: "header",
        },
        HeaderError::Field { field, got, want } => SceneError::Header {
            path,
            field,
            got,
            want,
        },
    })
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

    /// One channel, as networks have it, is no axis of its own; three are colour.
    #[test]
    fn one_channel_is_no_axis() {
        let written = |shape: [usize; 4]| {
            let mut bytes = Vec::new();
            let count = shape.iter().product::<usize>() as u32;
            let numbers = (0..count).map(f64::from).collect();
            let array = ndarray::Array4::from_shape_vec(shape, numbers).unwrap();
            array.write_npy(&mut bytes).unwrap();
            bytes
        };
        let frames = read(&written([2, 1, 2, 3])).unwrap();
        assert_eq!((frames.len(), frames[1].light.dim()), (2, (2, 3)));
        assert_eq!(frames[1].light[(1, 2)], 11.0);
        assert!(read(&written([2, 3, 2, 3])).is_err());
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
