//! Quantities as types, so that words are never added to microseconds.

use std::{fmt, iter::Sum, ops};

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
