//! Dyadic rationals: what sums and halves of whole numbers can be.

use std::fmt;

/// `numerator · 2^exponent`, exactly. The numerator is odd, or both are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Dyadic {
    numerator: i128,
    exponent: i32,
}

impl Dyadic {
    /// Nought.
    pub const ZERO: Self = Self {
        numerator: 0,
        exponent: 0,
    };

    /// One.
    pub const ONE: Self = Self {
        numerator: 1,
        exponent: 0,
    };

    /// `numerator · 2^exponent`.
    #[must_use]
    pub const fn new(numerator: i128, exponent: i32) -> Self {
        if numerator == 0 {
            return Self::ZERO;
        }
        let twos = numerator.trailing_zeros();
        Self {
            numerator: numerator >> twos,
            exponent: exponent.saturating_add(twos as i32),
        }
    }

    /// A float, exactly; `None` for infinities and NaN.
    #[must_use]
    pub fn from_f64(value: f64) -> Option<Self> {
        if !value.is_finite() {
            return None;
        }
        let bits = value.to_bits();
        let fraction = (bits & ((1 << 52) - 1)) as i128;
        let (numerator, exponent) = match (bits >> 52 & 0x7FF) as i32 {
            0 => (fraction, -1074),
            exponent => (fraction | 1 << 52, exponent - 1075),
        };
        Some(Self::new(
            if value < 0.0 { -numerator } else { numerator },
            exponent,
        ))
    }

    /// Whether this is 0.
    #[must_use]
    pub const fn is_zero(self) -> bool {
        self.numerator == 0
    }

    /// The sum; `None` beyond 127 bits.
    #[must_use]
    pub fn plus(self, other: Self) -> Option<Self> {
        if self.is_zero() {
            return Some(other);
        }
        if other.is_zero() {
            return Some(self);
        }
        let exponent = self.exponent.min(other.exponent);
        let at = |value: Self| {
            let by = u32::try_from(value.exponent - exponent).ok()?;
            let factor = 1i128.checked_shl(by).filter(|factor| *factor > 0)?;
            value.numerator.checked_mul(factor)
        };
        Some(Self::new(at(self)?.checked_add(at(other)?)?, exponent))
    }

    /// The product; `None` beyond 127 bits.
    #[must_use]
    pub fn times(self, other: Self) -> Option<Self> {
        Some(Self::new(
            self.numerator.checked_mul(other.numerator)?,
            self.exponent.checked_add(other.exponent)?,
        ))
    }

    /// Divided by a whole number; `None` where that is not a power of two.
    #[must_use]
    pub fn divided(self, by: u32) -> Option<Self> {
        if !by.is_power_of_two() {
            return None;
        }
        let exponent = self.exponent.checked_sub(by.trailing_zeros() as i32)?;
        Some(Self::new(self.numerator, exponent))
    }

    /// The nearest float; exact up to 53 bits.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        // In two steps, so that neither factor is 0 or infinite while the product is not.
        let half = self.exponent / 2;
        self.numerator as f64 * 2f64.powi(half) * 2f64.powi(self.exponent - half)
    }
}

impl From<i32> for Dyadic {
    fn from(value: i32) -> Self {
        Self::new(value.into(), 0)
    }
}

/// As a fraction: `-3/32`.
impl fmt::Display for Dyadic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.exponent {
            0 => write!(f, "{}", self.numerator),
            -126..=-1 => write!(f, "{}/{}", self.numerator, 1i128 << -self.exponent),
            exponent => write!(f, "{} * 2^{exponent}", self.numerator),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reads_as_a_fraction() {
        let text = |value| Dyadic::from_f64(value).unwrap().to_string();
        assert_eq!(text(-3.0 / 32.0), "-3/32");
        assert_eq!((text(0.0), text(7.0)), ("0".into(), "7".into()));
        assert_eq!(text(12.0), "3 * 2^2");
        assert_eq!(Dyadic::ONE.divided(3), None);
        assert_eq!(Dyadic::from_f64(f64::NAN), None);
    }

    proptest! {
        #[test]
        fn is_the_arithmetic_of_small_floats(a in -4000i32..4000, b in -4000i32..4000, shift in 0u32..8) {
            let by = 1 << shift;
            let x = f64::from(a) / f64::from(by);
            let y = f64::from(b);
            let [p, q] = [x, y].map(|v| Dyadic::from_f64(v).unwrap());
            prop_assert_eq!(p.plus(q).unwrap().to_f64(), x + y);
            prop_assert_eq!(p.times(q).unwrap().to_f64(), x * y);
            prop_assert_eq!(Dyadic::from(a).divided(by as u32).unwrap(), p);
            prop_assert_eq!(p.plus(Dyadic::from_f64(-x).unwrap()).unwrap(), Dyadic::ZERO);
        }

        #[test]
        fn every_float_is_one(bits: u64) {
            let value = f64::from_bits(bits);
            let expected = value.is_finite().then_some(value);
            prop_assert_eq!(Dyadic::from_f64(value).map(Dyadic::to_f64), expected.map(|v| v + 0.0));
        }
    }
}
