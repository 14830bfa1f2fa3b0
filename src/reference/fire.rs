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
//! which is ESIM's rule (Rebecq et al., `CoRL` 2018). The released simulator instead draws its
//! line from the memory itself, `d0 = 0`: see [`super::refractory`].

use multiversion::multiversion;

use crate::number::Real;

use super::train::TrainRow;

/// Distances from memory of a row of cells, and their thresholds.
#[derive(Clone, Copy)]
pub(super) struct Distances<'a, R> {
    /// At the earlier frame.
    pub(super) from: &'a [R],
    /// At the later frame.
    pub(super) to: &'a [R],
    pub(super) on: &'a [R],
    pub(super) off: &'a [R],
}

/// More thresholds than this, up or down, are not counted.
pub(super) const MOST: i32 = 1 << 30;

/// How many thresholds a row of cells has crossed, and if `times` are wanted, when; the column
/// of the first cell that crossed more than are counted, if there is one.
pub(super) fn cross<R: Real>(
    distances: Distances<'_, R>,
    times: bool,
    row: &mut TrainRow<R>,
) -> Result<(), usize> {
    let fits = if times {
        count_and_time(distances, &mut row.counts, &mut row.first, &mut row.spacing)
    } else {
        count(distances, &mut row.counts)
    };
    if fits {
        return Ok(());
    }
    let Distances { to, on, off, .. } = distances;
    let beyond = |x: &usize| !whole(to[*x], on[*x], off[*x]).1;
    Err((0..to.len()).find(beyond).unwrap_or(0))
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn count<R: Real>(distances: Distances<'_, R>, counts: &mut [i32]) -> bool {
    let mut fits = true;
    let Distances { to, on, off, .. } = distances;
    for ((count, &d), (&on, &off)) in counts.iter_mut().zip(to).zip(on.iter().zip(off)) {
        let (whole, counted) = whole(d, on, off);
        *count = to_i32(whole);
        fits &= counted;
    }
    fits
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn count_and_time<R: Real>(
    distances: Distances<'_, R>,
    counts: &mut [i32],
    first: &mut [R],
    spacing: &mut [R],
) -> bool {
    let mut fits = true;
    let Distances { from, to, on, off } = distances;
    let lines = from.iter().zip(to).zip(on.iter().zip(off));
    let out = counts.iter_mut().zip(first.iter_mut().zip(spacing));
    for (((&from, &to), (&on, &off)), (count, (first, spacing))) in lines.zip(out) {
        let (whole, counted) = whole(to, on, off);
        *count = to_i32(whole);
        fits &= counted;
        (*first, *spacing) = place(from, to, on, off);
    }
    fits
}

/// Whole thresholds in a distance, with its sign; whether they can be counted.
#[inline]
fn whole<R: Real>(d: R, on: R, off: R) -> (R, bool) {
    let theta = if d >= R::ZERO { on } else { off };
    let quotient = d.abs() / theta;
    // In single precision the tolerance of a large count would be more than an event.
    let half = R::of(0.5);
    let hair = quotient * R::TIE;
    let whole = (quotient + if hair < half { hair } else { half }).floor();
    let counted = whole <= R::of_i32(MOST);
    (if d >= R::ZERO { whole } else { -whole }, counted)
}

/// A whole number within 2^31, without the checks of `as` that keep a loop from being
/// vectorised: added to 1.5 * 2^52, it stands in the lowest bits.
#[inline]
fn to_i32<R: Real>(whole: R) -> i32 {
    (whole.to_f64() + 6_755_399_441_055_744.0).to_bits() as i32
}

/// Where a line from one distance to another meets the first threshold, and how far the next
/// is, by linear interpolation between the frames.
///
/// Where the line does not rise, a disturbance made the crossing: it is seen at the frame.
#[inline]
fn place<R: Real>(from: R, to: R, on: R, off: R) -> (R, R) {
    let theta = if to >= R::ZERO { on } else { off };
    let start = if to >= R::ZERO { from } else { -from };
    let rise = to.abs() - start;
    let rises = rise > R::ZERO;
    let per = R::ONE / if rises { rise } else { R::ONE };
    let place = (theta - start) * per;
    let place = if place > R::ZERO { place } else { R::ZERO };
    let place = if place < R::ONE { place } else { R::ONE };
    (
        if rises { place } else { R::ONE },
        if rises { theta * per } else { R::ZERO },
    )
}

/// The one decision of a memory that snaps: 1, 0 or -1 event, when the frame is taken.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn snap<R: Real>(distances: Distances<'_, R>, row: &mut TrainRow<R>) {
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
        let [mut row, mut untimed] = [TrainRow::new(1), TrainRow::new(1)];
        cross(distances, true, &mut row).unwrap();
        cross(distances, false, &mut untimed).unwrap();
        assert_eq!(row.counts, untimed.counts);
        row
    }

    fn snapped(d: f64) -> i32 {
        let mut row = TrainRow::new(1);
        let distances = Distances {
            from: &[0.0],
            to: &[d],
            on: &ON,
            off: &OFF,
        };
        snap(distances, &mut row);
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
        let distances = Distances {
            from: &[0.0],
            to: &[0.3f32 + 0.3],
            on: &[0.2],
            off: &[0.2],
        };
        let mut row = TrainRow::new(1);
        cross(distances, false, &mut row).unwrap();
        assert_eq!(row.counts, [3]);
    }

    #[test]
    fn what_cannot_be_counted_is_refused() {
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
                from: &[0.0; 3],
                to: &[1.0, d, 1.0],
                on: &[1.0; 3],
                off: &[1.0; 3],
            };
            for times in [false, true] {
                let mut row = TrainRow::new(3);
                let crossed = cross(distances, times, &mut row);
                assert_eq!(crossed, if fits { Ok(()) } else { Err(1) }, "{d}");
                assert!(!fits || f64::from(row.counts[1]) == d);
            }
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
