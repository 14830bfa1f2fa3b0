//! The floats in which a sheet can be solved.

use std::sync::Arc;

use rustfft::{Fft, FftNum, FftPlanner};

use super::sheet::{MOST_LAMBDA, MOST_SIGNAL};

/// What a sheet is computed in: `f64`, or `f32` where speed matters more.
pub trait Float: FftNum + PartialOrd {
    /// The largest space constant that can be answered in it.
    const MOST_LAMBDA: f64;
    /// The largest signal, in size.
    const MOST_SIGNAL: f64;

    /// The nearest number.
    fn nearest(value: f64) -> Self;

    /// As a double.
    fn to_f64(self) -> f64;

    /// The Fourier transform of so many numbers, and its inverse. Not generic, so that its code,
    /// which is long, is in this library alone.
    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2];
}

impl Float for f64 {
    const MOST_LAMBDA: f64 = MOST_LAMBDA;
    const MOST_SIGNAL: f64 = MOST_SIGNAL;

    #[inline]
    fn nearest(value: f64) -> Self {
        value
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2] {
        planned(length)
    }
}

impl Float for f32 {
    const MOST_LAMBDA: f64 = 1e15;
    const MOST_SIGNAL: f64 = 1e30;

    #[inline]
    fn nearest(value: f64) -> Self {
        value as Self
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.into()
    }

    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2] {
        planned(length)
    }
}

/// The Fourier transform of so many numbers, and its inverse.
fn planned<T: FftNum>(length: usize) -> [Arc<dyn Fft<T>>; 2] {
    let mut planner = FftPlanner::new();
    [
        planner.plan_fft_forward(length),
        planner.plan_fft_inverse(length),
    ]
}
