//! Between which values a number about the silicon may lie.

use serde::Serialize;

use super::Evidence;

/// What the public data allow of a number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The least.
    pub low: f64,
    /// The most.
    pub high: f64,
    /// How well its ends are known.
    pub evidence: Evidence,
    /// Why not less, and not more.
    pub why: String,
}

impl Interval {
    /// From which ratio of its ends on an interval is one of decades: what is drawn from it is
    /// drawn by its logarithm.
    const DECADES: f64 = 10.0;

    /// Whether it spans decades.
    #[must_use]
    pub fn is_logarithmic(&self) -> bool {
        self.low > 0.0 && self.high >= Self::DECADES * self.low
    }

    /// Both ends.
    #[must_use]
    pub const fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_from_zero_spans_no_decades() {
        let of = |low, high| Interval {
            low,
            high,
            evidence: Evidence::Guess,
            why: String::new(),
        };
        assert!(of(0.1, 1.0).is_logarithmic());
        for (low, high) in [(0.0, 1.0), (0.2, 1.0), (-10.0, 1.0), (-10.0, -1.0)] {
            assert!(!of(low, high).is_logarithmic(), "{low} {high}");
        }
    }
}
