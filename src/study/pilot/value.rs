//! Light of a pixel as it is kept: a byte, or a number.

use crate::rng::GOLDEN;

/// Light of a pixel.
pub(super) trait Value: Copy + PartialOrd {
    fn light(self) -> f64;

    /// One of 256 numbers that different light hardly shares.
    fn bucket(self) -> u8;
}

impl Value for u8 {
    #[inline]
    fn light(self) -> f64 {
        self.into()
    }

    #[inline]
    fn bucket(self) -> u8 {
        self
    }
}

impl Value for f64 {
    #[inline]
    fn light(self) -> f64 {
        self
    }

    #[inline]
    fn bucket(self) -> u8 {
        (self.to_bits().wrapping_mul(GOLDEN) >> 56) as u8
    }
}
