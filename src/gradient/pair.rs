//! One cell in one pair of frames, backwards: the derivative of its train's voxels and counts by the
//! distance from the memory at both frames and by the threshold, and how far its memory follows.
//!
//! With `d` and `e` the distances at the later and the earlier frame, `p = sign(d)`, `θ` the threshold
//! of that sign, `ρ = p (d - e)` the rise of the line between the frames, and `N` the events that were
//! kept, the first at `f`, `σ` apart, of which one in `m` crossings is kept:
//!
//! ```text
//! later = p L,  earlier = p (N - L),   L = N f + σ N (N - 1) / 2,   f ~ (iθ - p e) / ρ,  σ = m θ / ρ
//!
//! at fixed N    dL/dd = -p L/ρ      dL/de = -p (N - L)/ρ      dL/dθ = (L + N p e/ρ)/θ
//! by N          dL/dN = f + σ (N - 1/2)
//! instead of 0  dN/dr = 1/m,  r = |d|/θ
//! ```
//!
//! A cell without an event has none to move: the one that it would have next comes at the later frame,
//! unless the cell is silent then. `docs/learning.md` derives all this.

use crate::{number::Real, reference::fire};

use super::rule::{Rule, Slope};

/// How cells fire, as the constants of [`slopes`].
pub(super) const STEP: u8 = 0;
pub(super) const DEAD: u8 = 1;
pub(super) const AUTHORS: u8 = 2;
pub(super) const SNAP: u8 = 3;

/// What flows through the memory, as the constants of [`slopes`].
pub(super) const RELEASED: u8 = 0;
pub(super) const RESET: u8 = 1;
pub(super) const THROUGH: u8 = 2;

impl Rule {
    pub(super) const fn constant(self) -> u8 {
        match self {
            Self::Authors => RELEASED,
            Self::Reset => RESET,
            Self::Through | Self::Mean => THROUGH,
        }
    }
}

/// What all cells of a pair share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair<R> {
    /// The refractory period in units of the pair, a hair less; for the authors' rule in seconds.
    pub(super) silence: R,
    /// The time between the frames, in seconds.
    pub(super) duration: R,
    /// What the loss asks of each event, whatever its sign; the second of cells that are silent.
    pub(super) events: [R; 2],
}

impl<R: Real> Pair<R> {
    pub(super) fn asks(events: f64, slope: Slope) -> [R; 2] {
        let silent = match slope {
            Slope::All => events,
            Slope::Fired => 0.0,
        };
        [R::from_f64(events), R::from_f64(silent)]
    }
}

/// A cell in a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<R> {
    /// Distance from the memory at the earlier and the later frame.
    pub(super) from: R,
    pub(super) to: R,
    /// Thresholds, ON and OFF, and their reciprocals.
    pub(super) on: R,
    pub(super) off: R,
    pub(super) per_on: R,
    pub(super) per_off: R,
    /// Number of events that were kept, without sign.
    pub(super) count: R,
    /// As in the tape.
    pub(super) timing: R,
    /// The loss's gradients of the earlier voxel, the later one and the signed count.
    pub(super) earlier: R,
    pub(super) later: R,
    pub(super) signed: R,
}

/// The derivatives of the loss by what a cell had in a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slopes<R> {
    /// `a`: by the distance at the later frame, the memory held.
    pub(super) to: R,
    /// `b`: by the distance at the earlier frame.
    pub(super) from: R,
    /// By the threshold, distances held.
    pub(super) theta: R,
    /// `κ`: how far the memory after the pair follows the drive at the later frame; the rest stays.
    pub(super) follow: R,
    /// `dM/dθ` of that memory, distances held.
    pub(super) rest: R,
}

/// The slopes of a cell that fires as `KIND` says, with the memory of `RULE`.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
pub(super) fn slopes<R: Real, const KIND: u8, const RULE: u8>(
    cell: &Cell<R>,
    pair: &Pair<R>,
) -> Slopes<R> {
    match KIND {
        AUTHORS => authors::<R, RULE>(cell, pair),
        SNAP => snap::<R, RULE>(cell, pair),
        _ => step::<R, KIND, RULE>(cell, pair),
    }
}

#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn pick<R: Real>(first: bool, one: R, other: R) -> R {
    if first { one } else { other }
}

#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn step<R: Real, const KIND: u8, const RULE: u8>(c: &Cell<R>, pair: &Pair<R>) -> Slopes<R> {
    let half = R::from_f64(0.5);
    let (d, above) = (c.to, c.to >= R::ZERO);
    let (theta, per) = (pick(above, c.on, c.off), pick(above, c.per_on, c.per_off));
    let sign = R::ONE.mul_sign(d);
    let r = d.abs() * per;
    let whole = fire::whole(d, c.per_on, c.per_off);
    let fired = c.count > R::ZERO;
    let start = c.from.mul_sign(d);
    let rise = d.abs() - start;
    // Where the line does not rise, rounding alone made the crossing.
    let rises = rise > theta * R::from_f64(1e-6);
    let inverse = R::ONE / pick(rises, rise, theta);
    let spacing = theta * inverse;
    let (first, part) = if KIND == DEAD {
        let stride = -(-(pair.silence / spacing)).floor();
        (c.timing, R::ONE / pick(stride > R::ONE, stride, R::ONE))
    } else {
        let first = (theta - start) * inverse;
        let first = pick(first > R::ZERO, first, R::ZERO);
        (pick(first < R::ONE, first, R::ONE), R::ONE)
    };
    let kept = if KIND == DEAD {
        spacing / part
    } else {
        spacing
    };
    let n = c.count;
    let later = n * first + kept * (n * (n - R::ONE) * half);
    let by_count = (first + kept * (n - half)) * part;
    let gap = c.later - c.earlier;
    let ask = c.signed + sign * pair.events[0];
    let count = (c.earlier + ask) * part;
    let to = (count + gap * (by_count - spacing * later)) * per;
    let from = -gap * (n - later) * inverse;
    let by_theta = gap * (later + n * start * inverse - by_count * r) - count * r;
    let by_theta = sign * per * by_theta;
    // A train that rounding made lies at the later frame.
    let flat = (c.later + ask) * per;
    let quiet = (c.later + c.signed + sign * pair.events[1]) * per;
    let quiet = if KIND == DEAD {
        quiet * c.timing
    } else {
        quiet
    };
    let other = pick(fired, flat, quiet);
    let moves = fired && rises;
    let follow = match RULE {
        THROUGH => R::ONE,
        RESET => pick(whole > R::ZERO, R::ONE, R::ZERO),
        _ => R::ZERO,
    };
    Slopes {
        to: pick(moves, to, other),
        from: pick(moves, from, R::ZERO),
        theta: pick(moves, by_theta, -sign * r * other),
        follow,
        rest: follow * sign * (whole - r),
    }
}

#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn snap<R: Real, const RULE: u8>(c: &Cell<R>, pair: &Pair<R>) -> Slopes<R> {
    let (d, above) = (c.to, c.to >= R::ZERO);
    let (theta, per) = (pick(above, c.on, c.off), pick(above, c.per_on, c.per_off));
    let sign = R::ONE.mul_sign(d);
    let events = pick(c.count > R::ZERO, pair.events[0], pair.events[1]);
    // Without a refractory period `timing` is 1: a cell is always ready.
    let to = c.timing * (c.later + c.signed + sign * events) * per;
    let follow = match RULE {
        THROUGH => R::ONE,
        RESET => pick(d.abs() > theta, R::ONE, R::ZERO),
        _ => R::ZERO,
    };
    Slopes {
        to,
        from: R::ZERO,
        theta: -d * per * to,
        follow,
        rest: R::ZERO,
    }
}

/// The authors' refractory rule: `α` from crossing to crossing, `α_r` from event to event, `β` before
/// the first. As released, `dα_r = dα`, `dβ = 0` and `dN = -(Δ - w)/(r + α)² dα`, where `w` is what is
/// left of the period at the earlier frame.
#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn authors<R: Real, const RULE: u8>(c: &Cell<R>, pair: &Pair<R>) -> Slopes<R> {
    let hair = R::from_f64(1e-9);
    let half = R::from_f64(0.5);
    let (d, above) = (c.to, c.to >= R::ZERO);
    let (theta, per) = (pick(above, c.on, c.off), pick(above, c.per_on, c.per_off));
    let sign = R::ONE.mul_sign(d);
    let q = (d.abs() + hair) / theta;
    let alpha = pair.duration / q;
    let over = R::ONE / (pair.silence + alpha + hair);
    // q dN/dq
    let by_q = (pair.duration - c.timing) * alpha * over * over;
    let fired = c.count > R::ZERO;
    let per_pair = R::ONE / pair.duration;
    let one = alpha * per_pair;
    let spacing = ((pair.silence / alpha).floor() + R::ONE) * one;
    let before = (c.timing / alpha).floor() * one;
    let n = c.count;
    let triangle = n * (n + R::ONE) * half;
    let later = before * n + spacing * triangle;
    let by_count = before + spacing * (n + half);
    let gap = c.later - c.earlier;
    let ask = c.signed + sign * pair.events[0];
    let moved = (c.earlier + ask) * by_q + gap * (by_count * by_q - one * triangle);
    // q times the derivative by q, with the sign of the events.
    let (quiet, follow) = if RULE == RELEASED {
        // The released code loses the sign of a silent cell: half of them pull the wrong way.
        (
            (sign * c.later + c.signed + sign * pair.events[1]) * q,
            R::ZERO,
        )
    } else {
        (
            (c.later + c.signed + sign * pair.events[1]) * by_q,
            by_q / q,
        )
    };
    let follow = match RULE {
        THROUGH => follow,
        RESET => pick(fired, follow, R::ZERO),
        _ => R::ZERO,
    };
    let moved = pick(fired, moved, quiet);
    let to = moved / q * per;
    let to = if RULE == RELEASED {
        let tanh = tanh(d);
        let sign = (R::ONE - tanh * tanh) * (c.earlier * (n - later) + c.later * later);
        to + pick(fired, sign, R::ZERO)
    } else {
        to
    };
    Slopes {
        to,
        from: R::ZERO,
        theta: -sign * moved * per,
        follow,
        rest: pick(follow > R::ZERO, sign * (n - by_q), R::ZERO),
    }
}

/// The hyperbolic tangent, by Lambert's continued fraction of an eighth of the angle and three
/// doublings: additions, multiplications and divisions alone, so that the loop is vectorised. The
/// error is a few units in the last place.
#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn tanh<R: Real>(x: R) -> R {
    let most = R::from_f64(20.0);
    let size = pick(x.abs() < most, x.abs(), most) * R::from_f64(0.125);
    let square = size * size;
    let mut tail = R::from_f64(19.0);
    for odd in [17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0, 1.0] {
        tail = R::from_f64(odd) + square / tail;
    }
    let mut tanh = size / tail;
    for _ in 0..3 {
        tanh = (tanh + tanh) / (R::ONE + tanh * tanh);
    }
    tanh.mul_sign(x)
}
