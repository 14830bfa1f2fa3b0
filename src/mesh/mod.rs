//! The resistor sheet: a surround made by the silicon itself.
//!
//! Every pixel has a node. A transverse conductance `g` ties it to the pixel's own signal,
//! four lateral resistors `R` tie it to its neighbours, a capacitor `C` to ground:
//!
//! ```text
//!            P (the photoreceptor's signal)
//!            │
//!            ┴ g
//!       R    │    R
//!  … ─/\/\/─ H ─/\/\/─ …      and the same to the rows above and below
//!            │
//!            ┴ C
//! ```
//!
//! | equation | |
//! |---|---|
//! | `C dH/dt = g (P - H) + (1/R) Lap H` | Kirchhoff's current law at a node |
//! | `τ dH/dt = P - H + λ² Lap H` | the same, over `g` |
//! | `λ = 1 / sqrt(R g)`, in pixels; `τ = C / g`, in seconds | space and time constant |
//! | `(1 - λ² Lap) H = P` | settled |
//! | `P - H` | what the Center Surround DVS is driven by |
//!
//! `Lap H` is the sum of the neighbours' `H` less as many times the node's own. There is nothing
//! beyond the edge (open ends), which is the same as a replicated border. So the cosines of the
//! DCT-II are the modes of the sheet; the one of `k` half waves across `N` pixels has
//!
//! ```text
//! μ = 4 sin²(π k / 2N)      gain 1 / (1 + λy² μy + λx² μx)      time constant τ times the gain
//! ```
//!
//! Everything about a sheet of equal parts is therefore known in closed form: [`Steady`] is its
//! settled state, [`Flow`] how it moves. [`Network`] is a sheet whose parts all differ, and
//! whose laterals may be transistors. [`Circuit`] says what the constants cost in silicon,
//! [`fit()`] which receptive fields a sheet can carry.
//!
//! Sources: T. Delbruck, C. Li, R. Graca, B. `McReynolds`, *Utility and feasibility of a center surround event
//! camera*, ICIP 2022, arXiv 2202.13076; Mead, *Analog VLSI and Neural Systems*, 1989, appendix C.
//! `docs/mesh.md` has all of it with pictures.

pub mod circuit;
mod cosine;
mod euler;
mod fit;
mod flow;
mod krylov;
mod network;
mod reason;
mod steady;

use std::sync::Arc;

use rustfft::Fft;

use crate::{
    elementary,
    plane::{Plane, Size},
};

pub use circuit::{Circuit, Layer};
pub use euler::Euler;
pub use fit::{Fit, FittedSheet, Fitting, fit};
pub use flow::{Between, Flow};
pub use network::{Laterals, Mismatch, Network, Settled};
pub use steady::Steady;

/// Space constants of a sheet of equal parts, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sheet {
    lambda_y: f64,
    lambda_x: f64,
}

/// The largest space constant, in pixels: its square must be a number.
pub const MOST_LAMBDA: f64 = 1e150;

/// The largest signal in size: sums over a sheet must be numbers.
pub const MOST_SIGNAL: f64 = 1e290;

/// Why a sheet cannot be solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum MeshError {
    /// A space constant that is none.
    #[error("the space constant is {value:?}")]
    #[diagnostic(help(
        "give a number of pixels from 0 (no surround) to {most:e}; λ² is transverse over lateral resistance"
    ))]
    Lambda {
        /// What was given.
        value: f64,
        /// The most.
        most: f64,
    },
    /// A time that is none.
    #[error("the {what} is {value} s")]
    #[diagnostic(help("give a finite number of seconds, zero or more"))]
    Time {
        /// Which time.
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// A signal that is no number, or too large to be summed.
    #[error("the pixel at x = {x}, y = {y} is {value:?}")]
    #[diagnostic(help(
        "every pixel must be a finite number, at most {most:e} in size; a node without a signal cannot be solved for"
    ))]
    Signal {
        /// Row.
        y: usize,
        /// Column.
        x: usize,
        /// What it is.
        value: f64,
        /// The most.
        most: f64,
    },
    /// A plane of another size than the sheet.
    #[error("the signal is {got}, the sheet is {want}")]
    #[diagnostic(help("give one signal for each node of the sheet"))]
    Size {
        /// Its size.
        got: Size,
        /// The sheet's size.
        want: Size,
    },
    /// Space constants that differ, where there can only be one.
    #[error("the sheet has two space constants, and v2e's has one")]
    #[diagnostic(help("give one space constant, or use the exact solution"))]
    Anisotropic,
    /// A part of a network that is none.
    #[error("the {what} at x = {x}, y = {y} is {value}")]
    #[diagnostic(help(
        "conductances to the signals and capacitances are above 0, laterals 0 (open) or above"
    ))]
    Part {
        /// Which kind of part.
        what: &'static str,
        /// Row.
        y: usize,
        /// Column.
        x: usize,
        /// What it is.
        value: f64,
    },
    /// The scale of a lateral that is none.
    #[error("the laterals bend at {value}")]
    #[diagnostic(help("give the difference at which they bend, above 0, in the signal's unit"))]
    Scale {
        /// What was given.
        value: f64,
    },
    /// Laterals that are not resistors, where only resistors can be moved on.
    #[error("the laterals are not resistors, and only a linear network is moved on in time")]
    #[diagnostic(help("settle it for each signal, or use linear laterals"))]
    Laterals,
    /// No answer that is right.
    #[error("the network does not settle: what was found may be off by {error:e}")]
    #[diagnostic(help(
        "the parts are too far apart for double precision: bring their conductances closer together"
    ))]
    Unsettled {
        /// How far it may be off.
        error: f64,
    },
    /// Too much work for one frame.
    #[error("the {what} would take more than {most} steps from one frame to the next")]
    #[diagnostic(help(
        "use a smaller space constant or a shorter time, or a sheet of equal parts by its exact rule, whose work does not depend on them"
    ))]
    Steps {
        /// What is moved on.
        what: &'static str,
        /// The most steps.
        most: u64,
    },
    /// A kernel that cannot be fitted.
    #[error("a kernel of zeros, or one that is to be fitted by {sheets} sheets")]
    #[diagnostic(help("give a kernel with a weight that is not 0, and 1 to 3 sheets"))]
    Fit {
        /// How many sheets were asked for.
        sheets: usize,
    },
    /// No pixels.
    #[error("a sheet of {size} pixels has no node")]
    #[diagnostic(help("give at least one row and one column"))]
    Empty {
        /// The size.
        size: Size,
    },
}

impl Sheet {
    /// A sheet with the same resistors both ways; `lambda` in pixels.
    ///
    /// # Errors
    /// When `lambda` is not a number from 0 to [`MOST_LAMBDA`].
    pub fn new(lambda: f64) -> Result<Self, MeshError> {
        Self::anisotropic(lambda, lambda)
    }

    /// A sheet whose resistors down and across differ: `lambda_y² = 1 / (Ry g)`,
    /// `lambda_x² = 1 / (Rx g)`.
    ///
    /// # Errors
    /// As [`Sheet::new`].
    pub fn anisotropic(lambda_y: f64, lambda_x: f64) -> Result<Self, MeshError> {
        for value in [lambda_y, lambda_x] {
            if !(0.0..=MOST_LAMBDA).contains(&value) {
                return Err(MeshError::Lambda {
                    value,
                    most: MOST_LAMBDA,
                });
            }
        }
        // There is no minus zero pixels.
        Ok(Self {
            lambda_y: lambda_y.abs(),
            lambda_x: lambda_x.abs(),
        })
    }

    /// The space constants, down and across, in pixels.
    #[must_use]
    pub const fn lambdas(self) -> (f64, f64) {
        (self.lambda_y, self.lambda_x)
    }

    /// What is left in the surround of a wave of `fy` and `fx` cycles a pixel: from 1 for
    /// uniform light down to `1 / (1 + 8 λ²)` for a checkerboard.
    #[must_use]
    pub fn gain(self, fy: f64, fx: f64) -> f64 {
        let loss = |lambda: f64, f: f64| {
            lambda * lambda * 4.0 * elementary::sin(std::f64::consts::PI * f).powi(2)
        };
        1.0 / (1.0 + loss(self.lambda_y, fy) + loss(self.lambda_x, fx))
    }
}

/// What a sheet is computed in: `f64`, or `f32` where speed matters more.
pub trait Real: rustfft::FftNum + PartialOrd {
    /// The largest space constant that can be answered in it.
    const MOST_LAMBDA: f64;
    /// The largest signal, in size.
    const MOST_SIGNAL: f64;

    /// The nearest number.
    fn of(value: f64) -> Self;

    /// As a double.
    fn double(self) -> f64;

    /// The Fourier transform of so many numbers, and its inverse. Not generic, so that its code,
    /// which is long, is in this library alone.
    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2];
}

impl Real for f64 {
    const MOST_LAMBDA: f64 = MOST_LAMBDA;
    const MOST_SIGNAL: f64 = MOST_SIGNAL;

    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    #[inline]
    fn double(self) -> f64 {
        self
    }

    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2] {
        cosine::transforms(length)
    }
}

impl Real for f32 {
    const MOST_LAMBDA: f64 = 1e15;
    const MOST_SIGNAL: f64 = 1e30;

    #[inline]
    fn of(value: f64) -> Self {
        value as Self
    }

    #[inline]
    fn double(self) -> f64 {
        self.into()
    }

    fn transforms(length: usize) -> [Arc<dyn Fft<Self>>; 2] {
        cosine::transforms(length)
    }
}

/// The eigenvalues `4 sin²(π k / 2n)` of a line of `n` nodes with open ends.
fn eigenvalues(n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |k| {
        4.0 * elementary::sin(std::f64::consts::FRAC_PI_2 * k as f64 / n as f64).powi(2)
    })
}

/// The least and the most of a plane, all of whose pixels must be usable.
fn range<T: Real>(plane: &Plane<T>) -> Result<(T, T), MeshError> {
    let most = T::of(T::MOST_SIGNAL);
    let fault = || {
        let usable = |value: T| value >= -most && value <= most;
        let ((y, x), value) = plane.indexed_iter().find(|(_, value)| !usable(**value))?;
        Some(MeshError::Signal {
            y,
            x,
            value: value.double(),
            most: T::MOST_SIGNAL,
        })
    };
    let (low, high) = match plane.as_slice() {
        Some(values) => extremes(values, most),
        None => extremes(&plane.iter().copied().collect::<Vec<_>>(), most),
    };
    // What is no number is never within.
    if low >= -most && high <= most {
        return Ok((low, high));
    }
    fault().map_or(Ok((low, high)), Err)
}

/// The least and the most of some numbers; beyond `most` if one of them is none.
#[multiversion::multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn extremes<T: Real>(values: &[T], most: T) -> (T, T) {
    const LANES: usize = 16;
    let first = values.first().copied().unwrap_or(most);
    let (mut low, mut high) = ([first; LANES], [first; LANES]);
    let mut usable = [true; LANES];
    let (blocks, rest) = values.as_chunks::<LANES>();
    for block in blocks {
        for i in 0..LANES {
            let value = block[i];
            low[i] = if value < low[i] { value } else { low[i] };
            high[i] = if value > high[i] { value } else { high[i] };
            usable[i] &= value >= -most && value <= most;
        }
    }
    for (i, &value) in rest.iter().enumerate() {
        low[i] = if value < low[i] { value } else { low[i] };
        high[i] = if value > high[i] { value } else { high[i] };
        usable[i] &= value >= -most && value <= most;
    }
    if usable.contains(&false) {
        return (most + most, most + most);
    }
    let least = |a: T, b: T| if b < a { b } else { a };
    let largest = |a: T, b: T| if b > a { b } else { a };
    (
        low.into_iter().fold(first, least),
        high.into_iter().fold(first, largest),
    )
}
