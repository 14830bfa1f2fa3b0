//! Fire: how many thresholds the drive has crossed, and when.
//!
//! With the drive's distance from memory `d = S - M`, the threshold `θ = θ_on` for `d ≥ 0`
//! and `θ_off` below, and `p = sign(d)`:
//!
//! - a memory that **steps** counts whole thresholds, `N = floor(|d| / θ)`. A crossing by
//!   equality fires: a relative tolerance ([`Real::TIE`]) absorbs what rounding does to
//!   `0.6 / 0.2`.
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
//! which is ESIM's rule (Rebecq et al., CoRL 2018). The released simulator instead draws its
//! line from the memory itself, `d0 = 0`: see [`super::refractory`].

use multiversion::multiversion;

use crate::number::Real;

use super::train::TrainRow;

/// Distances from memory of a row of cells, and their thresholds.
pub(super) struct Distances<'a, R> {
    /// At the earlier frame.
    pub(super) from: &'a [R],
    /// At the later frame.
    pub(super) to: &'a [R],
    pub(super) on: &'a [R],
    pub(super) off: &'a [R],
}

impl<R: Real> Distances<'_, R> {
    /// The column of the first distance of more thresholds than are counted.
    pub(super) fn first_beyond(&self) -> usize {
        let beyond = |x: &usize| {
            let one = Distances {
                from: &self.from[*x..=*x],
                to: &self.to[*x..=*x],
                on: &self.on[*x..=*x],
                off: &self.off[*x..=*x],
            };
            !count(&one, &mut [0])
        };
        (0..self.to.len()).find(beyond).unwrap_or(0)
    }
}

/// More thresholds than this, up or down, are not counted.
pub(super) const MOST: i32 = 1 << 30;

/// Whole thresholds crossed, with the sign of the distance; whether all could be counted.
#[must_use]
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn count<R: Real>(distances: &Distances<'_, R>, counts: &mut [i32]) -> bool {
    let most = R::of_i32(MOST);
    let mut fits = true;
    let thresholds = distances.on.iter().zip(distances.off);
    let half = R::of(0.5);
    for ((count, &d), (&on, &off)) in counts.iter_mut().zip(distances.to).zip(thresholds) {
        let theta = if d >= R::ZERO { on } else { off };
        let quotient = d.abs() / theta;
        // In single precision the tolerance of a large count would be more than an event.
        let hair = quotient * R::TIE;
        let hair = if hair < half { hair } else { half };
        let whole = (quotient + hair).floor();
        fits &= whole <= most;
        *count = to_i32(if d >= R::ZERO { whole } else { -whole });
    }
    fits
}

/// A whole number within 2^31, without the checks of `as` that keep a loop from being
/// vectorised: added to 1.5 * 2^52, it stands in the lowest bits.
#[inline]
fn to_i32<R: Real>(whole: R) -> i32 {
    (whole.to_f64() + 6_755_399_441_055_744.0).to_bits() as i32
}

/// When the thresholds were crossed, by linear interpolation between the frames.
///
/// Where the line does not rise, a disturbance made the crossing: it is seen at the frame.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn time<R: Real>(distances: &Distances<'_, R>, first: &mut [R], spacing: &mut [R]) {
    let lines = distances.from.iter().zip(distances.to);
    let thresholds = distances.on.iter().zip(distances.off);
    let out = first.iter_mut().zip(spacing);
    for (((&d0, &d1), (&on, &off)), (first, spacing)) in lines.zip(thresholds).zip(out) {
        let theta = if d1 >= R::ZERO { on } else { off };
        let start = if d1 >= R::ZERO { d0 } else { -d0 };
        let rise = d1.abs() - start;
        let rises = rise > R::ZERO;
        let per = R::ONE / if rises { rise } else { R::ONE };
        let place = (theta - start) * per;
        let place = if place > R::ZERO { place } else { R::ZERO };
        let place = if place < R::ONE { place } else { R::ONE };
        *first = if rises { place } else { R::ONE };
        *spacing = if rises { theta * per } else { R::ZERO };
    }
}

/// The one decision of a memory that snaps: 1, 0 or -1 event, when the frame is taken.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn snap<R: Real>(distances: &Distances<'_, R>, row: &mut TrainRow<R>) {
    let thresholds = distances.on.iter().zip(distances.off);
    for ((count, &d), (&on, &off)) in row.counts.iter_mut().zip(distances.to).zip(thresholds) {
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ON: [f64; 1] = [0.2];
    const OFF: [f64; 1] = [0.1];

    fn one(from: f64, to: f64) -> TrainRow<f64> {
        let distances = Distances {
            from: &[from],
            to: &[to],
            on: &ON,
            off: &OFF,
        };
        let mut row = TrainRow::new(1);
        assert!(count(&distances, &mut row.counts));
        time(&distances, &mut row.first, &mut row.spacing);
        row
    }

    fn snapped(d: f64) -> i32 {
        let mut row = TrainRow::new(1);
        snap(
            &Distances {
                from: &[0.0],
                to: &[d],
                on: &ON,
                off: &OFF,
            },
            &mut row,
        );
        row.counts[0]
    }

    #[test]
    fn a_tie_fires_when_it_steps_and_not_when_it_snaps() {
        assert_eq!(one(0.0, 0.6).counts, [3]);
        assert_eq!(one(0.0, 0.6 - 1e-9).counts, [2]);
        assert_eq!(one(0.0, -1e6 * 0.1).counts, [-1_000_000]);
        assert_eq!(
            (snapped(0.2), snapped(0.2 + 1e-15), snapped(-0.11)),
            (0, 1, -1)
        );
    }

    #[test]
    fn single_precision_ties_fire_too() {
        let mut counts = [0];
        let distances = Distances {
            from: &[0.0],
            to: &[0.3f32 + 0.3],
            on: &[0.2],
            off: &[0.2],
        };
        assert!(count(&distances, &mut counts));
        assert_eq!(counts, [3]);
    }

    #[test]
    fn what_cannot_be_counted_is_noticed() {
        let most = f64::from(MOST);
        for (d, fits) in [
            (most, true),
            (-most, true),
            (most + 1.0, false),
            (-most - 1.0, false),
            (f64::INFINITY, false),
            (f64::NAN, false),
        ] {
            let distances = Distances {
                from: &[0.0],
                to: &[d],
                on: &[1.0],
                off: &[1.0],
            };
            let mut counts = [0];
            assert_eq!(count(&distances, &mut counts), fits, "{d}");
            assert!(!fits || f64::from(counts[0]) == d);
        }
    }

    proptest! {
        /// Each event lies where the line meets its level, and no further level is reached.
        #[test]
        fn crossings_lie_where_the_line_meets_the_levels(d0 in -0.0999f64..0.1999, d1 in -3.0f64..3.0) {
            let Some(train) = one(d0, d1).get(0) else {
                prop_assert!(d1 < 0.2 && d1 > -0.1);
                return Ok(());
            };
            let theta = if d1 > 0.0 { 0.2 } else { 0.1 };
            for i in 0..train.count {
                let u = train.at(i);
                let line = d0 + u * (d1 - d0);
                let level = f64::from(train.polarity.sign()) * theta * (i + 1) as f64;
                prop_assert!((line - level).abs() < 1e-12, "event {} at {}: {} is not {}", i, u, line, level);
            }
            prop_assert!(d1.abs() < theta * (train.count + 1) as f64);
        }
    }
}
