//! The surround by explicit Euler steps, as v2e computes it. It exists only to agree with v2e;
//! [`Flow`](super::Flow) is exact.
//!
//! Read from the behaviour of v2e 1.5.1 (`EventEmulator`, `cs_lambda_pixels`, `cs_tau_p_ms`):
//! a frame is stepped `ceil(5 dt / min(τ, τ/λ²))` times towards the later frame (once more where
//! rounding puts a whole quotient just above itself),
//!
//! ```text
//! H += (t/τ) (P - H) + (t λ²/τ) Lap H
//! ```
//!
//! with the border replicated, until the steps are done or no pixel has moved by more than
//! 1e-5. A time constant of 0 stands for 1 ns. The surround starts as the first frame itself,
//! so a still scene moves until it has settled, and the early stop leaves an error: 0.005 of a
//! unit step at `λ` 10, most of the step at `λ` 100.

use super::{
    MeshError, Sheet,
    signal::{check_next, check_time, checked_range},
};
use crate::plane::{Plane, Size};

/// A resistive grid that is stepped as v2e does it.
#[derive(Clone, Debug)]
pub struct Euler {
    lambda: f64,
    tau: f64,
    surround: Plane<f64>,
    steps: u64,
}

/// Steps in the shorter of the two time constants.
const STEPS: f64 = 5.0;
/// What stands for a time constant of 0, in seconds.
const INSTANT: f64 = 1e-9;
/// A frame's stepping ends early once no pixel moves by more than this in a step.
const STILL: f64 = 1e-5;
/// Steps of one frame at most: beyond, a frame takes minutes.
const MAX_STEPS: u64 = 1_000_000;

impl Euler {
    /// Starts with the first frame as its surround; `tau` is the time constant in seconds.
    ///
    /// # Errors
    /// When `tau` is not a time, the space constants differ (v2e knows one), or a pixel is no
    /// number.
    pub fn begin(sheet: Sheet, tau: f64, signal: &Plane<f64>) -> Result<Self, MeshError> {
        let (lambda, lambda_x) = sheet.lambdas();
        if lambda != lambda_x {
            return Err(MeshError::Anisotropic);
        }
        check_time("time constant", tau)?;
        checked_range(signal)?;
        Ok(Self {
            lambda,
            tau,
            surround: signal.clone(),
            steps: 0,
        })
    }

    /// The surround `H`, `[y, x]`, in the signal's unit.
    #[must_use]
    pub const fn surround(&self) -> &Plane<f64> {
        &self.surround
    }

    /// Euler steps taken so far.
    #[must_use]
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Advances by `seconds` with `signal` as input.
    ///
    /// # Errors
    /// When the time is none, the signal has another size or a pixel that is no number, or the
    /// sheet is still moving after a million steps; it is then as it was.
    pub fn advance(&mut self, signal: &Plane<f64>, seconds: f64) -> Result<(), MeshError> {
        check_next(signal, Size::of(&self.surround), seconds)?;
        let tau = if self.tau > 0.0 { self.tau } else { INSTANT };
        let lateral = if self.lambda > 0.0 {
            tau / (self.lambda * self.lambda)
        } else {
            f64::INFINITY
        };
        let steps = (seconds / tau.min(lateral) * STEPS).ceil();
        let what = "sheet by v2e's rule";
        if seconds == 0.0 {
            return Ok(());
        }
        if steps.is_infinite() {
            return Err(MeshError::Steps {
                what,
                most: MAX_STEPS,
            });
        }
        let (own, side) = (seconds / steps / tau, seconds / steps / lateral);
        let (mut before, mut now) = (self.surround.clone(), self.surround.clone());
        let mut done = 0u64;
        let mut moved = 2.0 * STILL;
        while (done as f64) < steps && moved > STILL {
            if done == MAX_STEPS {
                return Err(MeshError::Steps {
                    what,
                    most: MAX_STEPS,
                });
            }
            std::mem::swap(&mut before, &mut now);
            moved = step(&before, signal, own, side, &mut now);
            done += 1;
        }
        self.surround = now;
        self.steps += done;
        Ok(())
    }
}

/// Takes one step; returns the largest change of a pixel.
fn step(
    before: &Plane<f64>,
    signal: &Plane<f64>,
    own: f64,
    side: f64,
    after: &mut Plane<f64>,
) -> f64 {
    let (height, width) = before.dim();
    let mut furthest = 0.0f64;
    for ((y, x), to) in after.indexed_iter_mut() {
        let here = before[[y, x]];
        let around = before[[y.saturating_sub(1), x]]
            + before[[(y + 1).min(height - 1), x]]
            + before[[y, x.saturating_sub(1)]]
            + before[[y, (x + 1).min(width - 1)]];
        let change = own * (signal[[y, x]] - here) + side * (around - 4.0 * here);
        furthest = furthest.max(change.abs());
        *to = here + change;
    }
    furthest
}
