//! The floats in which values that follow from held numbers are computed.

use std::{
    fmt::Debug,
    ops::{Add, Div, Mul, Neg, Sub},
};

/// f32 or f64, as what a held number is worth.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// The relative difference under which two results of a few operations are a tie:
    /// 2^12 units in the last place of f64, 2^5 of f32.
    const TIE: Self;
    /// Whole numbers whose magnitude is below this are integers by [`Real::to_i32_in_range`].
    const IN_RANGE: Self;

    /// The nearest.
    fn from_f64(value: f64) -> Self;

    /// Exactly.
    fn to_f64(self) -> f64;

    /// The nearest to a whole number.
    fn from_i32(value: i32) -> Self;

    /// The whole part; saturates.
    fn to_i32(self) -> i32;

    /// A whole number below [`Real::IN_RANGE`], whatever its sign, as an integer: the lowest 32 bits
    /// of it. The same as `as`, whose checks would keep loops from being vectorised.
    fn to_i32_in_range(self) -> i32;

    /// The largest whole number not above.
    #[must_use]
    fn floor(self) -> Self;

    /// Without its sign.
    #[must_use]
    fn abs(self) -> Self;

    /// Times the sign of `other`, a zero's included: the sign bits are combined.
    #[must_use]
    fn mul_sign(self, other: Self) -> Self;

    /// The maximum of two numbers that are not negative, nor −0.
    #[must_use]
    fn max_nonnegative(self, other: Self) -> Self;
}

macro_rules! real {
    ($($float:ident $tie:expr, $small:expr, $shift:expr;)*) => {$(
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const TIE: Self = $tie;
            const IN_RANGE: Self = $small;

            #[inline]
            fn from_f64(value: f64) -> Self {
                value as $float
            }
            #[inline]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline]
            fn from_i32(value: i32) -> Self {
                value as $float
            }
            #[inline]
            fn to_i32(self) -> i32 {
                self as i32
            }
            #[inline]
            fn to_i32_in_range(self) -> i32 {
                // 1.5 times the power of two whose last bit counts ones: added to it, a whole number
                // stands in the lowest bits.
                const SHIFT: $float = $shift;
                (self + SHIFT).to_bits().wrapping_sub(SHIFT.to_bits()) as i32
            }
            #[inline]
            fn floor(self) -> Self {
                $float::floor(self)
            }
            #[inline]
            fn abs(self) -> Self {
                $float::abs(self)
            }
            #[inline]
            fn mul_sign(self, other: Self) -> Self {
                let sign = other.to_bits() & (-0.0 as $float).to_bits();
                <$float>::from_bits(self.to_bits() ^ sign)
            }
            #[inline]
            fn max_nonnegative(self, other: Self) -> Self {
                // As integers they are in the same order, and a loop can be vectorised.
                <$float>::from_bits(self.to_bits().max(other.to_bits()))
            }
        }
    )*};
}

real! {
    // 2^22 and 1.5 * 2^23; 2^51 and 1.5 * 2^52, of which an integer takes the lowest bits.
    f32 f32::EPSILON * 32.0, 4_194_304.0, 12_582_912.0;
    f64 f64::EPSILON * 4096.0, 2_251_799_813_685_248.0, 6_755_399_441_055_744.0;
}

#[cfg(test)]
mod tests {
    use super::Real;

    #[test]
    fn signs_turn_and_the_larger_is_found() {
        assert_eq!(2f32.mul_sign(-0.5), -2.0);
        assert_eq!((-2f64).mul_sign(-0.5), 2.0);
        assert_eq!((-2f64).mul_sign(0.0), -2.0);
        assert_eq!(2f64.mul_sign(-0.0), -2.0);
        for (a, b) in [
            (0.0, 1e-300),
            (1e-300, 0.5),
            (0.5, 2e9),
            (2e9, f64::INFINITY),
        ] {
            assert_eq!((a.max_nonnegative(b), b.max_nonnegative(a)), (b, b));
        }
    }

    /// On both sides of zero, up to the last.
    fn small<R: Real>(most: i32) {
        for n in [0, 1, 2, 77, most / 2, most - 1, most] {
            for n in [n, -n] {
                assert!(R::from_i32(n).abs() < R::IN_RANGE);
                assert_eq!(R::from_i32(n).to_i32_in_range(), n);
            }
        }
    }

    #[test]
    fn small_whole_numbers_become_integers() {
        small::<f32>((1 << 22) - 1);
        small::<f64>(i32::MAX);
        // Two to the 31st, of either sign, is the integer that has no opposite.
        assert_eq!(2_147_483_648f64.to_i32_in_range(), i32::MIN);
        assert_eq!((-2_147_483_648f64).to_i32_in_range(), i32::MIN);
    }
}
