//! The change of a kernel's frequency response by quantisation.

use std::f64::consts::TAU;

use super::super::Kernel;
use crate::elementary;

/// The two-dimensional frequency response, where it changes most.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Change {
    /// The largest change over all frequencies, as a part of the largest response.
    pub largest: f64,
    /// Root mean square over all frequencies, as a part of the root mean square response; the
    /// same as the relative error (Parseval).
    pub rms: f64,
    /// Where the change is largest: (vertical, horizontal), in cycles per pixel, 0 to 1/2 and
    /// -1/2 to 1/2.
    pub at: (f64, f64),
    /// The response to uniform light, before and after.
    pub uniform: (f64, f64),
}

/// Frequencies along each axis: enough for kernels of 15x15.
const SIDE: usize = 64;

impl Change {
    /// From one kernel to another of the same shape.
    #[must_use]
    pub fn between(before: &Kernel, after: &Kernel) -> Self {
        let (mut largest, mut at, mut most) = (0.0, (0.0, 0.0), 0.0);
        let (mut changed, mut all) = (0.0, 0.0);
        for v in 0..SIDE {
            for u in 0..SIDE {
                let wrapped = |k: usize| {
                    let k = if k > SIDE / 2 {
                        k as f64 - SIDE as f64
                    } else {
                        k as f64
                    };
                    k / SIDE as f64
                };
                let frequency = (wrapped(v), wrapped(u));
                let (a, b) = (response(before, frequency), response(after, frequency));
                let change = ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2)).sqrt();
                let response = (a.0 * a.0 + a.1 * a.1).sqrt();
                most = response.max(most);
                changed += change * change;
                all += response * response;
                // The response of a real kernel at -f is the conjugate of that at f, so half of the
                // plane suffices.
                if change > largest && frequency.0 >= 0.0 {
                    (largest, at) = (change, frequency);
                }
            }
        }
        Self {
            largest: largest / most,
            rms: (changed / all).sqrt(),
            at,
            uniform: (before.sum(), after.sum()),
        }
    }
}

/// Real and imaginary part of the response to a frequency, in cycles per pixel.
fn response(kernel: &Kernel, (v, u): (f64, f64)) -> (f64, f64) {
    let (rows, columns) = kernel.reach();
    let mut sum = (0.0, 0.0);
    for ((y, x), w) in kernel.weights().indexed_iter() {
        let phase = TAU * (v * (y as f64 - rows as f64) + u * (x as f64 - columns as f64));
        sum.0 += w * elementary::cos(phase);
        sum.1 += w * elementary::sin(phase);
    }
    sum
}
