//! Between which numbers a format lies, and what rounding can do to any of them.

use super::{Format, Overflow};

impl Format {
    /// What rounding to the nearest can change any number by, however small it is, in the
    /// number's unit: half an LSB in fixed point, half the smallest subnormal of a float. Of
    /// f64 that half is no double, and this is the whole of it.
    #[must_use]
    pub fn half_step(self) -> f64 {
        match self {
            Self::F64 => f64::from_bits(1),
            Self::F32 => f64::from(f32::from_bits(1)) / 2.0,
            Self::F16 => half::f16::MIN_POSITIVE_SUBNORMAL.to_f64() / 2.0,
            Self::Bf16 => half::bf16::MIN_POSITIVE_SUBNORMAL.to_f64() / 2.0,
            Self::Fixed(q) => 2f64.powi(-i32::from(q.fraction()) - 1),
        }
    }

    /// The smallest and the largest number that is held.
    #[must_use]
    pub fn limits(self) -> (f64, f64) {
        let float = |most: f64| (-most, most);
        match self {
            Self::F64 => float(f64::MAX),
            Self::F32 => float(f32::MAX.into()),
            Self::F16 => float(half::f16::MAX.to_f64()),
            Self::Bf16 => float(half::bf16::MAX.to_f64()),
            Self::Fixed(q) => {
                let end = 2f64.powi(i32::from(q.integer()) - 1);
                (-end, end - 2.0 * self.half_step())
            }
        }
    }

    /// Whether a result beyond [`Format::limits`] comes back as another number, and not as the
    /// nearest or as infinity.
    #[must_use]
    pub fn wraps(self) -> bool {
        matches!(self, Self::Fixed(q) if q.overflow() == Overflow::Wrap)
    }
}
