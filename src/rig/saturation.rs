//! Warnings of values at the end of what holds them.

use super::guard::{About, Warning};

impl Warning {
    /// Values at the end of what holds them: how many of how many in `place`, which ends at
    /// `ends`.
    #[must_use]
    pub fn saturation(subject: &str, place: &str, counted: (u64, u64), ends: [f64; 2]) -> Self {
        Self::new(
            About::Saturation,
            subject,
            format!(
                "{} in {place} lie at the end of its range, {}",
                share("value", counted),
                from_to(ends)
            ),
            "larger values are clipped there",
            "halve more often before sums, reduce light or gain, or use a wider format",
        )
    }

    /// Numbers of a program that its format does not hold, whatever it is shown: what, what becomes
    /// of them, and the format to take.
    #[must_use]
    pub fn unheld(subject: &str, seen: impl Into<String>, why: &str, change: String) -> Self {
        Self::new(About::Saturation, subject, seen, why, change)
    }

    /// Signals or drives beyond their number format's range, at so many of a study's points.
    #[must_use]
    pub fn saturated_points(points: usize, of: usize) -> Self {
        Self::new(
            About::Saturation,
            &format!("{points} of {of} points"),
            "signals or drives lie beyond the range of their number format",
            "larger values are clipped or wrap around",
            "use more bits before the point, or reduce light, weights or gain",
        )
    }

    /// Values beyond what the chip's registers hold, in an arithmetic that holds them.
    #[must_use]
    pub fn beyond(subject: &str, place: &str, counted: (u64, u64), ends: [f64; 2]) -> Self {
        Self::new(
            About::Saturation,
            subject,
            format!(
                "{} in {place} lie beyond the range of a register, {}",
                share("value", counted),
                from_to(ends)
            ),
            "this arithmetic holds them, the chip does not",
            "run with --clip on or --domain silicon to see what is left, or halve before sums",
        )
    }
}

/// So many of so many: `12 of 24 values (50 %)`.
pub(super) fn share(thing: &str, (at, all): (u64, u64)) -> String {
    let percent = 100.0 * at as f64 / all.max(1) as f64;
    let percent = if percent < 1.0 {
        "below 1 %".to_owned()
    } else {
        format!("{percent:.0} %")
    };
    format!("{at} of {all} {thing}s ({percent})")
}

/// A range to its last digit.
pub(super) fn from_to([low, high]: [f64; 2]) -> String {
    format!("{low} to {high}")
}
