//! Frames as numpy holds them, as light.

use amacrine::scene::{Image, Levels, Samples};
use numpy::{PyArray3, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::error::refused;

/// An array of frames that nobody writes to meanwhile, `(T, H, W)`, row by row.
pub enum Borrowed<'py> {
    U8(PyReadonlyArray3<'py, u8>),
    F32(PyReadonlyArray3<'py, f32>),
    F64(PyReadonlyArray3<'py, f64>),
}

/// The numbers of some frames, one frame after the other.
#[derive(Clone, Copy)]
pub enum Frames<'a> {
    U8(&'a [u8]),
    F32(&'a [f32]),
    F64(&'a [f64]),
}

impl<'py> Borrowed<'py> {
    pub fn new(array: &Bound<'py, PyAny>) -> PyResult<Self> {
        let busy = |_| refused("the frames are being written to", "give a copy of them");
        if let Ok(array) = array.cast::<PyArray3<u8>>() {
            return Ok(Self::U8(array.try_readonly().map_err(busy)?));
        }
        if let Ok(array) = array.cast::<PyArray3<f32>>() {
            return Ok(Self::F32(array.try_readonly().map_err(busy)?));
        }
        if let Ok(array) = array.cast::<PyArray3<f64>>() {
            return Ok(Self::F64(array.try_readonly().map_err(busy)?));
        }
        Err(refused(
            "frames are an array of uint8, float32 or float64 with three axes",
            "give an array of shape (T,H,W)",
        ))
    }

    /// Frames, rows, columns.
    pub fn shape(&self) -> (usize, usize, usize) {
        let shape = match self {
            Self::U8(array) => array.shape(),
            Self::F32(array) => array.shape(),
            Self::F64(array) => array.shape(),
        };
        match *shape {
            [frames, height, width] => (frames, height, width),
            _ => (0, 0, 0),
        }
    }

    pub fn frames(&self) -> PyResult<Frames<'_>> {
        let scattered = |_| refused("the frames do not lie row by row", "give a copy of them");
        Ok(match self {
            Self::U8(array) => Frames::U8(array.as_slice().map_err(scattered)?),
            Self::F32(array) => Frames::F32(array.as_slice().map_err(scattered)?),
            Self::F64(array) => Frames::F64(array.as_slice().map_err(scattered)?),
        })
    }
}

impl Frames<'_> {
    /// What kind of numbers they are.
    pub const fn samples(self) -> Samples {
        match self {
            Self::U8(_) => Samples::Integers,
            Self::F32(_) | Self::F64(_) => Samples::Floats,
        }
    }

    /// Puts frame `n` in the place of `light`: codes of 8 bits stay codes, which stand for `levels`;
    /// other numbers are taken times `scale`.
    pub fn show(self, n: usize, (scale, levels): (f64, &Levels), light: &mut Image) {
        let size = light.size();
        let pixels = size.pixels();
        let codes = match self {
            Self::U8(all) => all.get(n * pixels..(n + 1) * pixels),
            Self::F32(_) | Self::F64(_) => None,
        };
        match codes.and_then(|it| Image::of_bytes(size, it.to_vec(), levels.clone())) {
            Some(coded) => *light = coded,
            None => {
                if let Some(light) = light.as_slice_mut() {
                    self.light(n, scale, light);
                }
            }
        }
    }

    /// The light of frame `n`: each number times `scale`.
    pub fn light(self, n: usize, scale: f64, light: &mut [f64]) {
        fn put<T: Copy + Into<f64>>(all: &[T], n: usize, scale: f64, light: &mut [f64]) {
            let place = n * light.len()..(n + 1) * light.len();
            let from = all.get(place).unwrap_or_default();
            if scale == 1.0 {
                for (to, from) in light.iter_mut().zip(from) {
                    *to = (*from).into();
                }
            } else {
                for (to, from) in light.iter_mut().zip(from) {
                    *to = (*from).into() * scale;
                }
            }
        }
        match self {
            Self::U8(all) => put(all, n, scale, light),
            Self::F32(all) => put(all, n, scale, light),
            Self::F64(all) => put(all, n, scale, light),
        }
    }
}
