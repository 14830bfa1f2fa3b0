//! Events of a cell: how many thresholds the drive has crossed, and when.
//!
//! With the drive's distance from memory `d = S - M`, the threshold `θ = θ_on` for `d ≥ 0`
//! and `θ_off` below, and `p = sign(d)`:
//!
//! - a memory that **steps** counts whole thresholds, `N = floor(|d| / θ)`. A crossing by
//!   equality fires: a relative tolerance ([`Real::TIE`]) absorbs what rounding does to
//!   `0.6 / 0.2`, and that `|d|` is multiplied by `1 / θ`, worked out once.
//! - a memory that **snaps** decides once, when the frame is taken: `|d| > θ`, strictly, as
//!   Eq. 2 of the paper and as the chip's `where` does.
//!
//! The drive is a straight line between two frames, from distance `d0` to `d1`. Level `i θ`
//! is crossed at
//!
//! ```text
//! u_i = (i θ - p d0) / (p (d1 - d0))          0 at the earlier frame, 1 at the later
//! ```
//!
//! which is ESIM's rule (Rebecq et al., `CoRL` 2018). The released simulator instead draws its
//! line from the memory itself, `d0 = 0`: see [`super::refractory`].

use multiversion::multiversion;

use crate::number::Real;

use super::train::TrainRow;

/// The number of whole thresholds in a distance; `per_on` and `per_off` are their reciprocals. At
/// most 2^31, which also stands for a distance that is not a number.
#[inline]
pub(crate) fn whole<R: Real>(d: R, per_on: R, per_off: R) -> R {
    let quotient = d.abs() * if d >= R::ZERO { per_on } else { per_off };
    // In single precision the tolerance of a large count would exceed one event.
    let half = R::from_f64(0.5);
    let tolerance = quotient * R::TIE;
    let whole = (quotient + if tolerance < half { tolerance } else { half }).floor();
    let beyond = R::from_f64(2_147_483_648.0);
    if whole < beyond { whole } else { beyond }
}

/// The place of the first crossing on the line from one distance to another, and the spacing of the
/// crossings, by linear interpolation between the frames.
///
/// Where the line does not rise, a disturbance made the crossing: it is placed at the later frame.
#[inline]
pub(super) fn place<R: Real>(from: R, to: R, on: R, off: R) -> (R, R) {
    let theta = if to >= R::ZERO { on } else { off };
    let start = from.mul_sign(to);
    let rise = to.abs() - start;
    let rises = rise > R::ZERO;
    let per = R::ONE / rise;
    let place = (theta - start) * per;
    let place = if place > R::ZERO { place } else { R::ZERO };
    let place = if place < R::ONE { place } else { R::ONE };
    (
        if rises { place } else { R::ONE },
        if rises { theta * per } else { R::ZERO },
    )
}

/// The decision of a memory that snaps: 1, 0 or -1 event, at the later frame. Returns whether all
/// distances are numbers, since a NaN is neither above nor below a threshold.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(crate) fn snap<R: Real>(distances: &[R], on: &[R], off: &[R], row: &mut TrainRow<R>) -> bool {
    let mut numbers = true;
    let cells = distances.iter().zip(on.iter().zip(off));
    for (count, (&d, (&on, &off))) in row.counts.iter_mut().zip(cells) {
        numbers &= is_number(d);
        *count = if d > on {
            1
        } else if -d > off {
            -1
        } else {
            0
        };
    }
    row.first.fill(R::ONE);
    row.spacing.fill(R::ZERO);
    numbers
}

/// Whether it is finite: 0 times infinity or NaN is NaN.
#[inline]
pub(super) fn is_number<R: Real>(d: R) -> bool {
    d * R::ZERO == R::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Polarity, reference::train::Train};
    use proptest::prelude::*;

    const ON: f64 = 0.2;
    const OFF: f64 = 0.1;

    fn count(d: f64) -> i32 {
        counted(d, ON, OFF)
    }

    fn counted<R: Real>(d: R, on: R, off: R) -> i32 {
        let whole = whole(d, R::ONE / on, R::ONE / off);
        whole.mul_sign(d).to_f64().to_i32_in_range()
    }

    fn snapped(d: f64) -> i32 {
        let mut row = TrainRow::new(1);
        snap(&[d], &[ON], &[OFF], &mut row);
        row.counts[0]
    }

    #[test]
    fn a_tie_fires_when_it_steps_and_not_when_it_snaps() {
        assert_eq!(count(0.6), 3);
        assert_eq!(count(0.6 - 1e-9), 2);
        assert_eq!(count(-1e6 * 0.1), -1_000_000);
        assert_eq!(
            (snapped(0.2), snapped(0.2 + 1e-15), snapped(-0.11)),
            (0, 1, -1)
        );
    }

    #[test]
    fn single_precision_ties_fire_too() {
        assert_eq!(counted(0.3f32 + 0.3, 0.2, 0.2), 3);
    }

    #[test]
    fn what_cannot_be_counted_is_marked() {
        let most = f64::from(i32::MAX);
        for d in [most, -most] {
            assert_eq!(f64::from(counted(d, 1.0, 1.0)), d);
        }
        for d in [most + 1.0, -most - 1.0, f64::INFINITY, f64::NAN] {
            assert_eq!(counted(d, 1.0, 1.0), i32::MIN, "{d}");
            assert_eq!(counted(d as f32, 1.0, 1.0), i32::MIN, "{d}");
        }
    }

    proptest! {
        /// Each event lies where the line meets its level, and no further level is reached.
        #[test]
        fn crossings_lie_where_the_line_meets_the_levels(d0 in -0.0999f64..0.1999, d1 in -3.0f64..3.0) {
            let theta = if d1 > 0.0 { ON } else { OFF };
            let (first, spacing) = place(d0, d1, ON, OFF);
            let train = Train { polarity: Polarity::On, count: count(d1).unsigned_abs().into(), first, spacing };
            for i in 0..train.count {
                let u = train.at(i);
                let line = d0 + u * (d1 - d0);
                let level = d1.signum() * theta * (i + 1) as f64;
                prop_assert!((line - level).abs() < 1e-12, "event {} at {}: {} is not {}", i, u, line, level);
            }
            prop_assert!(d1.abs() < theta * (train.count + 1) as f64);
        }
    }
}
