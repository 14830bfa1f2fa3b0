//! The floats that follow-up arithmetic is done in.

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

    /// The nearest.
    fn of(value: f64) -> Self;

    /// Exactly.
    fn to_f64(self) -> f64;

    /// The nearest to a whole number.
    fn of_i32(value: i32) -> Self;

    /// The whole part; saturates.
    fn to_i32(self) -> i32;

    /// The largest whole number not above.
    #[must_use]
    fn floor(self) -> Self;

    /// Without its sign.
    #[must_use]
    fn abs(self) -> Self;
}

macro_rules! real {
    ($($float:ident $tie:expr),*) => {$(
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const TIE: Self = $tie;

            #[inline]
            fn of(value: f64) -> Self {
                value as $float
            }
            #[inline]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline]
            fn of_i32(value: i32) -> Self {
                value as $float
            }
            #[inline]
            fn to_i32(self) -> i32 {
                self as i32
            }
            #[inline]
            fn floor(self) -> Self {
                $float::floor(self)
            }
            #[inline]
            fn abs(self) -> Self {
                $float::abs(self)
            }
        }
    )*};
}

real!(f32 f32::EPSILON * 32.0, f64 f64::EPSILON * 4096.0);
