//! What the float model draws random numbers for, and for which cell.

use crate::rng::{self, Hash};

/// Why a number is drawn: each reason has random numbers of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    ThresholdOn = 1,
    ThresholdOff = 2,
    LeakRate = 3,
    LeakPhase = 4,
    HotPixel = 5,
    StrayWait = 6,
    StraySign = 7,
    StrayKept = 8,
    Jitter = 9,
}

/// A cell to draw for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) seed: u64,
    pub(super) channel: usize,
    pub(super) y: usize,
    pub(super) x: usize,
}

impl Place {
    /// A uniform number in [0, 1); `step` is the number of the interval, or another counter.
    pub(super) fn uniform(self, reason: Reason, step: u64) -> f64 {
        self.uniform_at(reason, step, 0)
    }

    /// The same, the `turn`-th number of a step.
    pub(super) fn uniform_at(self, reason: Reason, step: u64, turn: u64) -> f64 {
        Draws::new(self.seed, reason).uniform_at(self, step, turn)
    }

    /// A standard normal number.
    pub(super) fn normal(self, reason: Reason, step: u64) -> f64 {
        rng::normal(
            self.uniform(reason, 2 * step),
            self.uniform(reason, 2 * step + 1),
        )
    }
}

/// The generator of one reason: the part of the hash that all places share, computed once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws(Hash);

impl Draws {
    pub(super) fn new(seed: u64, reason: Reason) -> Self {
        Self(Hash::new(seed).with(reason as u64))
    }

    /// As [`Place::uniform_at`], of a place with the same seed.
    #[inline]
    pub(super) fn uniform_at(self, place: Place, step: u64, turn: u64) -> f64 {
        let Place { channel, y, x, .. } = place;
        let cell = ((channel as u64) << 48) | ((y as u64) << 24) | x as u64;
        let key = self.0.with(cell).with(step ^ turn.rotate_left(32));
        key.uniform()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: u64 = 200_000;

    fn place(i: u64) -> Place {
        Place {
            seed: 7,
            channel: 0,
            y: (i / 400) as usize,
            x: (i % 400) as usize,
        }
    }

    fn mean(of: impl Fn(Place, u64) -> f64) -> f64 {
        (0..DRAWS).map(|i| of(place(i), i % 5)).sum::<f64>() / DRAWS as f64
    }

    /// Means within 4 sigma of what the distribution says.
    #[test]
    fn draws_have_their_moments() {
        let near = |got: f64, want: f64, sigma: f64| {
            let bound = 4.0 * sigma / (DRAWS as f64).sqrt();
            assert!(
                (got - want).abs() < bound,
                "{got}, not {want} within {bound}"
            );
        };
        near(
            mean(|p, s| p.uniform(Reason::Jitter, s)),
            0.5,
            (1f64 / 12.0).sqrt(),
        );
        near(mean(|p, s| p.normal(Reason::Jitter, s)), 0.0, 1.0);
        near(
            mean(|p, s| p.normal(Reason::Jitter, s).powi(2)),
            1.0,
            2f64.sqrt(),
        );
        // Neighbours, steps, reasons and seeds are not alike.
        let product = |p: Place, q: Place| {
            (p.uniform(Reason::Jitter, 0) - 0.5) * (q.uniform(Reason::Jitter, 0) - 0.5)
        };
        let apart = |a: f64, b: f64| (a - 0.5) * (b - 0.5);
        near(
            mean(|p, _| product(p, Place { x: p.x + 1, ..p })),
            0.0,
            1.0 / 12.0,
        );
        near(
            mean(|p, _| product(p, Place { seed: 8, ..p })),
            0.0,
            1.0 / 12.0,
        );
        let drawn = |p: Place, reason, step, turn| p.uniform_at(reason, step, turn);
        for (reason, step, turn) in [
            (Reason::Jitter, 1, 0),
            (Reason::Jitter, 0, 1),
            (Reason::StraySign, 0, 0),
        ] {
            let both =
                |p: Place, _| apart(drawn(p, Reason::Jitter, 0, 0), drawn(p, reason, step, turn));
            near(mean(both), 0.0, 1.0 / 12.0);
        }
    }
}
