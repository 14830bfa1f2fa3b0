//! Quantities as types, so that words are never added to microseconds.

use std::{fmt, iter::Sum, ops, str::FromStr};

/// Time in whole microseconds, as in every event and every file.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Serialize,
    serde::Deserialize,
)]
#[serde(transparent)]
pub struct Micros(pub u64);

impl Micros {
    /// The nearest microsecond to `seconds`.
    ///
    /// Times before zero become zero; a sensor starts at its first frame.
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        // `as` saturates, which is what is meant.
        Self((seconds * 1e6).round() as u64)
    }

    /// This time in seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-6
    }
}

impl fmt::Display for Micros {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} us", self.0)
    }
}

/// A text that is no duration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is not a duration in whole microseconds, such as 100us, 1ms or 0.5s")]
#[diagnostic(help("write a number and one of the units us, ms, s"))]
pub struct DurationError {
    /// What was given.
    pub text: String,
}

impl FromStr for Micros {
    type Err = DurationError;

    /// Reads `100us`, `1ms`, `0.5s`: a decimal number and a unit, exact to the microsecond.
    fn from_str(text: &str) -> Result<Self, DurationError> {
        let read = || {
            // The longer units first: `s` ends all of them.
            let (number, decimals) = [("us", 0), ("µs", 0), ("ms", 3), ("s", 6)]
                .into_iter()
                .find_map(|(unit, decimals)| Some((text.strip_suffix(unit)?, decimals)))?;
            let (whole, fraction) = number.trim().split_once('.').unwrap_or((number.trim(), ""));
            let fraction = fraction.trim_end_matches('0');
            let digits = format!("{whole}{fraction:0<decimals$}");
            let plain = digits.bytes().all(|b| b.is_ascii_digit());
            (plain && fraction.len() <= decimals && !whole.is_empty())
                .then(|| digits.parse().ok().map(Self))?
        };
        read().ok_or_else(|| DurationError {
            text: text.to_owned(),
        })
    }
}

/// Instruction words: what a program costs on the chip, one clock of the array each.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Serialize,
    serde::Deserialize,
)]
#[serde(transparent)]
pub struct Words(pub u64);

impl ops::Add for Words {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl ops::AddAssign for Words {
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl ops::Mul<u64> for Words {
    type Output = Self;
    fn mul(self, times: u64) -> Self {
        Self(self.0 * times)
    }
}

impl Sum for Words {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self(0), ops::Add::add)
    }
}

impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} words", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_read_to_the_microsecond() {
        for (text, micros) in [
            ("1us", 1),
            ("100us", 100),
            ("7µs", 7),
            ("1ms", 1_000),
            ("0.25 ms", 250),
            ("10ms", 10_000),
            ("0.5s", 500_000),
            ("1.000001s", 1_000_001),
            ("3.500s", 3_500_000),
            ("0us", 0),
        ] {
            assert_eq!(text.parse(), Ok(Micros(micros)), "{text}");
        }
    }

    #[test]
    fn what_is_no_duration_is_refused() {
        for text in [
            "",
            "1",
            "ms",
            ".5s",
            "1m",
            "1 min",
            "-1ms",
            "0.5us",
            "1.0000001s",
            "1e3us",
            "1,5ms",
            "1.2.3s",
            "99999999999999999999us",
            "nans",
        ] {
            assert!(text.parse::<Micros>().is_err(), "{text}");
        }
    }
}
