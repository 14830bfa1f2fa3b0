//! A number about hardware, with its unit, its source and how well it is known.

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
        Self::one(*value, figure.unit(), *evidence, source.clone())
    }

    /// Both ends times a factor, in another unit.
    pub(super) fn times(&self, factor: f64, unit: &'static str, source: impl Into<String>) -> Self {
        Self::between(
            [self.low * factor, self.high * factor],
            unit,
            self.evidence,
            source,
        )
    }
}

/// The weakest of some evidences.
pub(super) fn weakest(of: impl IntoIterator<Item = Evidence>) -> Evidence {
    let rank = |evidence: &Evidence| match evidence {
        Evidence::Measured => 0,
        Evidence::Quoted => 1,
        Evidence::Modelled => 2,
        Evidence::Guess => 3,
    };
    of.into_iter().max_by_key(rank).unwrap_or(Evidence::Guess)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_as_strong_as_its_weakest_link() {
        use Evidence::{Guess, Measured, Modelled, Quoted};
        assert_eq!(weakest([Measured, Quoted]), Quoted);
        assert_eq!(weakest([Modelled, Measured, Quoted]), Modelled);
        assert_eq!(weakest([Guess, Modelled]), Guess);
        assert_eq!(weakest([]), Guess);
    }

    #[test]
    fn a_figure_keeps_what_the_chip_s_data_says_of_it() {
        let device = Device::scamp5();
        let power = Estimate::figure(&device, Figure::Power);
        assert_eq!((power.low, power.high, power.unit), (1.2, 1.2, "W"));
        assert_eq!(power.evidence, Evidence::Quoted);
        assert!(power.source.contains("535 GOPS/W"));
        let half = power.times(500.0, "mW", "half of it");
        assert_eq!((half.low, half.unit), (600.0, "mW"));
    }
}
