//! Random numbers for sheets: a hash of reason and place, so that the order of work cannot change it.

use crate::{
    chance::{GOLDEN, mix, uniform},
    elementary,
};

/// Reason a number is drawn: no two reasons share their numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reason {
    LateralDown = 1,
    LateralAcross = 2,
    Transverse = 3,
    Capacitor = 4,
    Thermal = 5,
}

/// A standard normal number for node (or mode) number `place` at `step` (Box & Muller, 1958).
pub(super) fn normal(seed: u64, reason: Reason, place: usize, step: u64) -> f64 {
    let mut h = mix(seed.wrapping_add(GOLDEN));
    for part in [reason as u64, place as u64, step] {
        h = mix((h ^ part).wrapping_add(GOLDEN));
    }
    let radius = 1.0 - uniform(h);
    let angle = uniform(mix(h.wrapping_add(GOLDEN)));
    (-2.0 * elementary::ln(radius)).sqrt() * elementary::cos(std::f64::consts::TAU * angle)
}
