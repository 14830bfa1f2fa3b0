//! Memory: what a cell compares with, and what an event does to it.
//!
//! | rule | holds | distance `d` | when a cell fires |
//! |---|---|---|---|
//! | `raw-snap` | pixels, `M(x)` | `W * (u - M)` | `M(x) := u(x)` (Eq. 2-4 of So & Wetzstein, arXiv 2504.13457) |
//! | `filtered-snap` | the filtered signal | `W * u - M` | `M(x) := (W * u)(x)`: one shot a frame on a chip |
//! | `filtered-step` | the filtered signal | `W * u - M` | `M(x) += p N θ` (the released code, v2e) |
//! | `authors-pixel-step` | pixels | `W * u - W_m * M` | `M(x) += p N θ` (the released code's old rule) |
//!
//! At the first frame the memory is that frame (filtered, where it holds the filtered signal),
//! so a still scene is silent from its start.
//!
//! A memory that steps is kept as a base and two whole numbers of steps,
//! `M = base + n_on θ_on - n_off θ_off`, so that it does not drift however many steps it takes.
//!
//! A pixel memory that snaps can fire for ever on a still scene: firing at x sets the pixel's
//! own difference to 0, and if the neighbours' differences still add up to more than the
//! threshold, x fires again at each frame and nothing changes. [`Report::livelocked`] counts
//! the cells that do.
//!
//! [`Report::livelocked`]: super::Report::livelocked

use crate::{event::Polarity, kernel::Kernel, plane::Plane};

use super::description::Threshold;

/// The memory of one channel.
#[derive(Clone, Debug)]
pub(super) enum State {
    RawSnap {
        pixels: Plane<f64>,
    },
    FilteredSnap {
        filtered: Plane<f64>,
        /// The signal when the cell last fired, where the polarity is the pixel's.
        pixels: Option<Plane<f64>>,
    },
    FilteredStep {
        base: Plane<f64>,
        steps: Plane<Steps>,
    },
    PixelStep {
        base: Plane<f64>,
        steps: Plane<Steps>,
        seen_through: Kernel,
    },
}

/// How often a memory has been stepped each way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Steps {
    on: u64,
    off: u64,
}

impl Steps {
    /// Where the memory is.
    pub(super) fn value(self, base: f64, threshold: Threshold) -> f64 {
        // Net steps first: with equal thresholds nothing is lost however large the counts are.
        let net = self.on as f64 - self.off as f64;
        base + (net * threshold.on + self.off as f64 * (threshold.on - threshold.off))
    }

    /// Takes `count` steps; `None` beyond 2^53, where whole numbers end in f64.
    pub(super) fn take(&mut self, polarity: Polarity, count: u64) -> Option<()> {
        let side = match polarity {
            Polarity::On => &mut self.on,
            Polarity::Off => &mut self.off,
        };
        *side = side.checked_add(count).filter(|&n| n <= 1 << 53)?;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_million_steps_do_not_drift() {
        let theta = Threshold {
            on: 0.2,
            off: 0.2,
            sigma: 0.0,
        };
        let mut steps = Steps::default();
        steps.take(Polarity::On, 1_000_000_000).unwrap();
        steps.take(Polarity::Off, 999_999_999).unwrap();
        assert_eq!(steps.value(0.5, theta), 0.7);
        // Adding one by one in single precision is off by one per cent after a million.
        let naive = (0..1_000_000).fold(0f32, |m, _| m + 0.2);
        assert!((naive - 200_000.0).abs() > 1000.0);
        let mut steps = Steps::default();
        steps.take(Polarity::On, 1_000_000).unwrap();
        assert_eq!(steps.value(0.0, theta), 200_000.0);
    }

    #[test]
    fn what_cannot_be_counted_is_refused() {
        let mut steps = Steps::default();
        assert_eq!(steps.take(Polarity::On, u64::MAX), None);
        assert_eq!(steps.take(Polarity::Off, (1 << 53) + 1), None);
    }
}
