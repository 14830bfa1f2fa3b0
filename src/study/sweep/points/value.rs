//! What a key is set to, and how it is said again: in one way only.

use std::fmt;

use super::thresholds::Thresholds;
use crate::{config::Place, elementary};

/// One value of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(u64),
    /// A name; tables of a sensor file in canonical TOML.
    Word(String),
    /// Whether something is so.
    Flag(bool),
    /// Thresholds.
    Threshold(Thresholds),
    /// A refractory period.
    Refractory {
        /// Microseconds.
        us: f64,
        /// `dead-time` or `authors`.
        rule: &'static str,
    },
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Whole(number) => number.fmt(f),
            Self::Word(word) => f.write_str(word),
            Self::Flag(flag) => flag.fmt(f),
            Self::Threshold(thresholds) => thresholds.fmt(f),
            Self::Refractory { us, rule } => write!(f, "{{ us = {us:?}, rule = {rule:?} }}"),
        }
    }
}

/// Spaced values from one end to the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// The first value.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How many, ends included; none: any number between.
    pub steps: Option<u64>,
    /// Equal factors instead of equal steps.
    pub log: bool,
}

impl Ramp {
    /// How far from one end to the other a step is, 0 to 1.
    #[must_use]
    pub fn part(&self, step: u64) -> f64 {
        step as f64 / self.steps.unwrap_or(2).saturating_sub(1).max(1) as f64
    }

    /// The value at a part of the way, 0 to 1.
    #[must_use]
    pub fn at(&self, part: f64) -> f64 {
        // The ends are met exactly.
        if part <= 0.0 {
            self.from
        } else if part >= 1.0 {
            self.to
        } else if self.log {
            self.from * elementary::pow(self.to / self.from, part)
        } else {
            self.from + (self.to - self.from) * part
        }
    }
}

/// The values of an axis as they were written.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// One by one, each with its place.
    List(Vec<(Value, Place)>),
    /// Between two ends.
    Ramp(Ramp),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_meets_its_ends() {
        let ramp = Ramp {
            from: 0.1,
            to: 0.7,
            steps: Some(7),
            log: true,
        };
        assert_eq!(ramp.at(0.0), 0.1);
        assert_eq!(ramp.at(1.0), 0.7);
        assert!((ramp.at(0.5) - (0.07_f64).sqrt()).abs() < 1e-12);
    }
}
