//! The float types in which a grid can be solved.

use std::sync::Arc;

use rustfft::{Fft, FftNum, FftPlanner};

use super::sheet::{MOST_LAMBDA, MOST_SIGNAL};

/// A float type for solving grids: `f64`, or `f32` where speed matters more.
pub trait Float: FftNum + PartialOrd {
    /// The largest space constant, in pixels, that can be solved in it.
    const MOST_LAMBDA: f64;
    /// The largest magnitude of a signal.
    const MOST_SIGNAL: f64;

    /// Rounds to the nearest value of this type.
    fn nearest(value: f64) -> Self;

    /// Converts to `f64`.
    fn to_f64(self) -> f64;

    /// The Fourier transform of `length` numbers, and its inverse. Not generic, so that the long
    /// code of `rustfft` is compiled once.
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

    /// Nothing in this library asks for it: who does compiles it.
    #[inline]
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
