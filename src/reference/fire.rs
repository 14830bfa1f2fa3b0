//! Fire: how many thresholds the drive has crossed, and when.
//!
//! With the drive's distance from memory `d = S - M`, the threshold `θ = θ_on` for `d ≥ 0`
//! and `θ_off` below, and `p = sign(d)`:
//!
//! - a memory that **steps** counts whole thresholds, `N = floor(|d| / θ)`. A crossing by
//!   equality fires: a relative tolerance of 2^-40 absorbs what rounding does to `0.6 / 0.2`.
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

use crate::event::Polarity;

use super::{description::Threshold, train::Train};

/// What rounding may take from a quotient before it is no longer the same crossing.
const TOLERANCE: f64 = 1.0 / (1u64 << 40) as f64;

/// Sign and size of a distance from memory, and the threshold on that side.
pub(super) fn side(d: f64, threshold: Threshold) -> (Polarity, f64, f64) {
    if d >= 0.0 {
        (Polarity::On, d, threshold.on)
    } else {
        (Polarity::Off, -d, threshold.off)
    }
}

/// Whole thresholds in a distance: `floor(|d| / θ)`, ties fire.
///
/// Saturates at `u64::MAX`; the memory refuses what it cannot count long before.
pub(super) fn crossings(distance: f64, threshold: f64) -> u64 {
    let quotient = distance / threshold;
    (quotient + quotient * TOLERANCE).floor() as u64
}

/// All crossings of a pair, by linear interpolation between the frames.
///
/// `None` when there are none.
pub(super) fn ramp(d0: f64, d1: f64, threshold: Threshold) -> Option<Train> {
    let (polarity, distance, theta) = side(d1, threshold);
    let count = crossings(distance, theta);
    if count == 0 {
        return None;
    }
    let start = f64::from(polarity.sign()) * d0;
    let rise = distance - start;
    let (first, spacing) = if rise > 0.0 {
        (((theta - start) / rise).clamp(0.0, 1.0), theta / rise)
    } else {
        // The line does not rise, so a disturbance made the crossing: it is seen at the frame.
        (1.0, 0.0)
    };
    Some(Train {
        polarity,
        count,
        first,
        spacing,
    })
}

/// The one decision of a memory that snaps.
pub(super) fn snap(d: f64, threshold: Threshold) -> Option<Polarity> {
    let (polarity, distance, theta) = side(d, threshold);
    (distance > theta).then_some(polarity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const THETA: Threshold = Threshold {
        on: 0.2,
        off: 0.1,
        sigma: 0.0,
    };

    #[test]
    fn a_tie_fires_when_it_steps_and_not_when_it_snaps() {
        assert_eq!(crossings(0.6, 0.2), 3);
        assert_eq!(crossings(0.6 - 1e-9, 0.2), 2);
        assert_eq!(crossings(1e6 * 0.2, 0.2), 1_000_000);
        assert_eq!(snap(0.2, THETA), None);
        assert_eq!(snap(0.2 + 1e-15, THETA), Some(Polarity::On));
        assert_eq!(snap(-0.11, THETA), Some(Polarity::Off));
    }

    proptest! {
        /// The slow twin: walk along the line in small steps and note when a level is passed.
        #[test]
        fn crossings_lie_where_the_line_meets_the_levels(d0 in -0.0999f64..0.1999, d1 in -3.0f64..3.0) {
            let Some(train) = ramp(d0, d1, THETA) else {
                prop_assert!(d1 < 0.2 && d1 > -0.1);
                return Ok(());
            };
            let theta = if d1 > 0.0 { 0.2 } else { 0.1 };
            for i in 0..train.count {
                let u = train.at(i);
                let line = d0 + u * (d1 - d0);
                let level = f64::from(train.polarity.sign()) * theta * (i + 1) as f64;
                prop_assert!((line - level).abs() < 1e-12, "event {i} at {u}: {line} is not {level}");
            }
            // No further level is reached.
            prop_assert!(d1.abs() < theta * (train.count + 1) as f64);
        }
    }
}
