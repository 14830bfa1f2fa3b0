//! What the grid draws random numbers for.

use crate::rng::{self, Hash};

/// Why a number is drawn: each reason has random numbers of its own.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reason {
    LateralDown = 1,
    LateralAcross = 2,
    Transverse = 3,
    Capacitor = 4,
    Thermal = 5,
}

/// A standard normal number for node (or mode) number `place` at `step`.
pub(super) fn normal(seed: u64, reason: Reason, place: usize, step: u64) -> f64 {
    let key = Hash::new(seed).with(reason as u64);
    let key = key.with(place as u64).with(step);
    rng::normal(key.uniform(), key.nth(1).uniform())
}
