//! Which numbers a key takes.

/// An interval of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least, or minus infinity.
    pub least: f64,
    /// The most, or infinity.
    pub most: f64,
    /// Whether `least` itself is out.
    pub above: bool,
    /// Whether `most` itself is out.
    pub below: bool,
    /// Whether infinity and NaN are out.
    pub finite: bool,
}

impl Range {
    /// Whatever TOML calls a number, infinity and NaN included: checked elsewhere.
    pub const FREE: Self = Self {
        finite: false,
        ..Self::FINITE
    };

    /// Every finite number.
    pub const FINITE: Self = Self {
        least: f64::NEG_INFINITY,
        most: f64::INFINITY,
        above: false,
        below: false,
        finite: true,
    };

    /// Zero or more.
    pub const NOT_NEGATIVE: Self = Self::least(0.0);

    /// More than zero.
    pub const POSITIVE: Self = Self::above(0.0);

    /// From this number on.
    #[must_use]
    pub const fn least(least: f64) -> Self {
        Self {
            least,
            ..Self::FINITE
        }
    }

    /// Above this number.
    #[must_use]
    pub const fn above(least: f64) -> Self {
        Self {
            least,
            above: true,
            ..Self::FINITE
        }
    }

    /// From one number to another.
    #[must_use]
    pub const fn between(least: f64, most: f64) -> Self {
        Self {
            least,
            most,
            ..Self::FINITE
        }
    }

    /// Whether a number lies in it.
    #[must_use]
    pub fn holds(&self, number: f64) -> bool {
        if !self.finite {
            return true;
        }
        number.is_finite()
            && (number > self.least || (!self.above && number == self.least))
            && (number < self.most || (!self.below && number == self.most))
    }

    /// What it is, in words.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { least, most, .. } = self;
        let below = if self.below { "below " } else { "" };
        match (least.is_finite(), most.is_finite()) {
            (false, false) if self.finite => "a finite number".to_owned(),
            (false, false) => "a number".to_owned(),
            (true, false) if self.above => format!("a number above {least}"),
            (true, false) => format!("a number of at least {least}"),
            (false, true) => format!("a number up to {below}{most}"),
            (true, true) if self.above => format!("a number above {least} up to {below}{most}"),
            (true, true) => format!("a number from {least} to {below}{most}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_in_or_out() {
        assert!(Range::NOT_NEGATIVE.holds(0.0) && !Range::POSITIVE.holds(0.0));
        assert!(!Range::FINITE.holds(f64::NAN) && Range::FREE.holds(f64::NAN));
        let part = Range {
            below: true,
            ..Range::between(0.0, 1.0)
        };
        assert!(part.holds(0.0) && !part.holds(1.0));
        assert_eq!(part.words(), "a number from 0 to below 1");
        assert_eq!(Range::POSITIVE.words(), "a number above 0");
    }
}
