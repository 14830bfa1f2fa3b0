//! A number about hardware, with its unit, its source and how well it is known.

use super::named::Named;
use crate::isa::{Device, Evidence, Figure, Quantity};

/// A number, or an interval where more is not known.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// The least that it can be.
    pub low: f64,
    /// The most; the same where it is one number.
    pub high: f64,
    /// Its unit.
    pub unit: &'static str,
    /// How well it is known: as well as the weakest number that it is made of.
    pub evidence: Evidence,
    /// Who says so, or what it is made of.
    pub source: String,
    /// The chip's numbers that it is made of, by the names that `figures` has them under.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<String>,
}

impl Estimate {
    /// One number.
    pub(super) fn one(
        value: f64,
        unit: &'static str,
        evidence: Evidence,
        source: impl Into<String>,
    ) -> Self {
        Self::between([value, value], unit, evidence, source)
    }

    /// An interval.
    pub(super) fn between(
        [low, high]: [f64; 2],
        unit: &'static str,
        evidence: Evidence,
        source: impl Into<String>,
    ) -> Self {
        Self {
            low,
            high,
            unit,
            evidence,
            source: source.into(),
            inputs: Vec::new(),
        }
    }

    /// A number about the chip, as its data says.
    pub(super) fn figure(device: &Device, figure: Figure) -> Self {
        let Quantity {
            value,
            source,
            evidence,
            ..
        } = device.figure(figure);
        let mut one = Self::one(*value, figure.unit(), *evidence, source.clone());
        one.inputs.push(Named::Figure(figure).name());
        one
    }

    /// What is made of numbers of the chip, of which each lies in its interval: no better known
    /// than the weakest of them.
    pub(super) fn made_of(mut self, device: &Device, figures: &[Named]) -> Self {
        for named in figures {
            if let Some(quantity) = named.quantity(device) {
                self.evidence = Evidence::weakest([self.evidence, quantity.interval_evidence()]);
                let name = named.name();
                if named.is_told(device) && !self.inputs.contains(&name) {
                    self.inputs.push(name);
                }
            }
        }
        self
    }

    /// What is made of another number: no better known than that, and of the same figures.
    pub(super) fn with(mut self, other: &Self) -> Self {
        self.evidence = Evidence::weakest([self.evidence, other.evidence]);
        for name in &other.inputs {
            if !self.inputs.contains(name) {
                self.inputs.push(name.clone());
            }
        }
        self
    }

    /// Both ends times a factor, in another unit.
    pub(super) fn times(&self, factor: f64, unit: &'static str, source: impl Into<String>) -> Self {
        let ends = [self.low * factor, self.high * factor];
        Self::between(ends, unit, self.evidence, source).with(self)
    }

    /// Both ends.
    #[must_use]
    pub const fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }
}

impl std::fmt::Display for Estimate {
    /// `19.0 us`, `19.0 to 62.7 us`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (low, high) = (short(self.low), short(self.high));
        match (low == high, self.unit) {
            (true, "1") => write!(f, "{low}"),
            (true, unit) => write!(f, "{low} {unit}"),
            (false, "1") => write!(f, "{low} to {high}"),
            (false, unit) => write!(f, "{low} to {high} {unit}"),
        }
    }
}

/// A number with three digits that count, or all of a whole one.
pub(super) fn short(value: f64) -> String {
    let decimals = match value.abs() {
        0.0 => 0,
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        size if size >= 0.01 => 4,
        _ => return format!("{value:.2e}"),
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_keeps_what_the_chip_s_data_says_of_it() {
        let device = Device::scamp5();
        let power = Estimate::figure(&device, Figure::Power);
        assert_eq!((power.low, power.high, power.unit), (1.2, 1.2, "W"));
        assert_eq!(power.evidence, Evidence::Quoted);
        assert!(power.source.contains("535 GOPS/W"));
        let half = power.times(500.0, "mW", "half of it");
        assert_eq!((half.low, half.unit), (600.0, "mW"));
        assert_eq!(half.inputs, ["clock.power"]);
    }

    #[test]
    fn what_is_made_of_a_guess_is_one() {
        let device = Device::scamp5();
        let plain = || Estimate::one(1.0, "us", Evidence::Measured, "test");
        let clock = Named::Figure(Figure::Clock);
        let launch = Named::Figure(Figure::Launch);
        assert_eq!(
            plain().made_of(&device, &[clock]).evidence,
            Evidence::Quoted
        );
        let made = plain().made_of(&device, &[clock, launch]);
        assert_eq!(made.evidence, Evidence::Guess);
        assert_eq!(made.inputs, ["clock.rate", "clock.launch"]);
        let of_it = plain().with(&made);
        assert_eq!(
            (of_it.evidence, of_it.inputs),
            (Evidence::Guess, made.inputs)
        );
    }

    #[test]
    fn intervals_as_text() {
        let text = |low, high, unit| {
            Estimate::between([low, high], unit, Evidence::Guess, "test").to_string()
        };
        assert_eq!(text(19.0, 62.7, "us"), "19.0 to 62.7 us");
        assert_eq!(text(0.05, 0.05, "1"), "0.0500");
        assert_eq!(text(0.0, 1200.0, "mW"), "0 to 1200 mW");
    }
}
