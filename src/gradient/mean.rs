//! The rule `mean`: the gradient of the events averaged over the phase of the memory.
//!
//! A memory that steps lies on a lattice of thresholds. Averaged over where that lattice begins, it is
//! a play (backlash) of the drive: the mean memory follows it `θ_on/2` behind on the way up, `θ_off/2`
//! ahead on the way down, and stays where it is in between. With `z` the drive's distance from it,
//! `D = d - e` what the drive moves by in a pair, and `o` by how much `z + D` leaves the play:
//!
//! ```text
//! z'      = z + D - o                   o = 0 within the play
//! count   = o / (m θ)                   w = (D - o) / D, when it begins to leave
//! later   = o (1 + w) / (2 m θ)         earlier = o (1 - w) / (2 m θ)
//! ```
//!
//! All of it is smooth but for corners, and its gradient does not know which cells happened to fire.

use multiversion::multiversion;

use crate::number::Real;

use super::pair::Pair;

/// What a row of cells had in a pair, and what the loss asks of it.
pub(super) struct MeanRows<'a, R> {
    /// Distances from the memory at the earlier and the later frame.
    pub(super) from: &'a [R],
    pub(super) to: &'a [R],
    /// By how much each left the play.
    pub(super) over: &'a [R],
    pub(super) thresholds: (&'a [R], &'a [R]),
    pub(super) earlier: &'a [R],
    pub(super) later: &'a [R],
    pub(super) signed: &'a [R],
}

/// What a row gives.
pub(super) struct MeanOutput<'a, R> {
    pub(super) h: &'a mut [R],
    pub(super) memory: &'a mut [R],
    pub(super) before: &'a mut [R],
    pub(super) on: &'a mut [R],
    pub(super) off: &'a mut [R],
}

/// Where the play begins: in its middle, or, where the memory begins a part of a threshold away, at
/// its end of that side.
pub(super) fn begin<R: Real>(part: R) -> R {
    let half = R::from_f64(0.5);
    if part > R::ZERO {
        half
    } else if part < R::ZERO {
        -half
    } else {
        R::ZERO
    }
}

/// Moves a row of plays on by a pair.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn leave<R: Real>(
    (from, to): (&[R], &[R]),
    (on, off): (&[R], &[R]),
    play: &mut [R],
    over: &mut [R],
) {
    let cells = to.len();
    let (from, on, off) = (&from[..cells], &on[..cells], &off[..cells]);
    let (play, over) = (&mut play[..cells], &mut over[..cells]);
    let half = R::from_f64(0.5);
    for x in 0..cells {
        let z = play[x] + (to[x] - from[x]);
        let (most, least) = (on[x] * half, -(off[x] * half));
        let held = if z > most { most } else { z };
        let held = if held < least { least } else { held };
        over[x] = z - held;
        play[x] = held;
    }
}

/// Takes a row back through a pair; `DEAD` with a dead time.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn back<R: Real, const DEAD: bool>(
    rows: &MeanRows<'_, R>,
    pair: &Pair<R>,
    out: MeanOutput<'_, R>,
) {
    let cells = rows.to.len();
    let (from, to, over) = (&rows.from[..cells], rows.to, &rows.over[..cells]);
    let (on, off) = (&rows.thresholds.0[..cells], &rows.thresholds.1[..cells]);
    let (earlier, later) = (&rows.earlier[..cells], &rows.later[..cells]);
    let signed = &rows.signed[..cells];
    let (h, memory) = (&mut out.h[..cells], &mut out.memory[..cells]);
    let before = &mut out.before[..cells];
    let (sum_on, sum_off) = (&mut out.on[..cells], &mut out.off[..cells]);
    let half = R::from_f64(0.5);
    let pick = |first: bool, one: R| if first { one } else { R::ZERO };
    for x in 0..cells {
        let o = over[x];
        let (leaves, above) = (o.abs() > R::ZERO, o > R::ZERO);
        let theta = if above { on[x] } else { off[x] };
        let sign = R::ONE.mul_sign(o);
        let moved = to[x] - from[x];
        let w = R::ONE - o / if leaves { moved } else { R::ONE };
        let w = if w > R::ZERO { w } else { R::ZERO };
        let w = if w < R::ONE { w } else { R::ONE };
        let per = if DEAD {
            let stride = -(-(pair.silence * moved.abs() / theta)).floor();
            R::ONE / (theta * if stride > R::ONE { stride } else { R::ONE })
        } else {
            R::ONE / theta
        };
        let ask = signed[x] + sign * pair.events[0];
        let (e, l) = (earlier[x], later[x]);
        let by_move = per * ((l * (R::ONE + w * w) + e * (R::ONE - w * w)) * half + ask);
        let by_start = -per * (l * w + e * (R::ONE - w) + ask);
        let loss = per * o * ((l * (R::ONE + w) + e * (R::ONE - w)) * half + ask);
        let after = memory[x];
        h[x] = pick(leaves, by_move + after) + before[x];
        let by_theta = half * sign * (by_start - after) - loss / theta;
        sum_on[x] = sum_on[x] + pick(above, by_theta);
        sum_off[x] = sum_off[x] + pick(leaves && !above, by_theta);
        memory[x] = if leaves { by_start } else { after };
        before[x] = pick(leaves, -(by_move + by_start));
    }
}
