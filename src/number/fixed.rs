//! Fixed point: an integer that counts steps of `2^-fraction`.

// What is not inlined into a loop in vectors is not compiled for its vectors.
#![allow(clippy::inline_always)]

use std::fmt::Debug;

use wide::{i8x16, i16x16, i32x8};

use super::{FixedFormat, Format, Number, Overflow};

/// An integer that fixed point is held in.
pub trait Width: Copy + Debug + Default + Ord + Into<i64> + Send + Sync + 'static {
    /// Holds sums of at least 2^15 of this width.
    type Wide: Wide;
    /// Number of bits, sign included.
    const BITS: u8;
    /// Zero.
    const ZERO: Self;
    /// The smallest and the largest.
    const LIMITS: (Self, Self);
    /// The nearest of this width.
    fn saturate(wide: i64) -> Self;
    /// The lowest bits of `wide`.
    fn wrap(wide: i64) -> Self;
    /// The nearest of this width, halves to even; 0 for NaN. All widths fit into one integer,
    /// so that a loop can leave it to another to make them narrow.
    fn nearest(real: f64) -> i32;
    /// The lowest bits.
    fn low(bits: i32) -> Self;
    /// The same, wider.
    fn widen(self) -> Self::Wide;
    /// The nearest of this width.
    fn saturate_wide(wide: Self::Wide) -> Self;
    /// The lowest bits of `wide`.
    fn wrap_wide(wide: Self::Wide) -> Self;
    /// The difference, saturated.
    #[must_use]
    fn less(self, other: Self) -> Self;
    /// The sum, saturated.
    #[must_use]
    fn more(self, other: Self) -> Self;
    /// The difference, wrapped.
    #[must_use]
    fn wrapping_less(self, other: Self) -> Self;
    /// The sum, wrapped.
    #[must_use]
    fn wrapping_more(self, other: Self) -> Self;
    /// `new` where `take` is 1, `old` where it is 0; without a branch.
    #[must_use]
    fn choose(old: Self, new: Self, take: u8) -> Self;
    /// Half the sum, halves to even.
    #[must_use]
    fn middle(self, other: Self) -> Self;
    /// A bit for each that is above zero, the lowest for the first.
    #[must_use]
    fn above(cells: &[Self; 64]) -> u64;
}

/// An integer for sums.
pub trait Wide: Copy + Debug + Default + Ord + Into<i64> + Send + Sync + 'static {
    /// The sum; the caller knows that it fits.
    #[must_use]
    fn plus(self, other: Self) -> Self;
    /// The product; the caller knows that it fits.
    #[must_use]
    fn times(self, times: i32) -> Self;
    /// As [`divide`].
    #[must_use]
    fn divided(self, by: u32) -> Self;
    /// As [`divide`], by two to the power of `bits`; without a division.
    #[must_use]
    fn shifted(self, bits: u32) -> Self;
}

macro_rules! wide {
    ($($int:ty)*) => {$(
        impl Wide for $int {
            #[inline]
            fn plus(self, other: Self) -> Self {
                self + other
            }
            #[inline]
            fn times(self, times: i32) -> Self {
                self * <$int>::from(times)
            }
            #[inline]
            fn divided(self, by: u32) -> Self {
                match by {
                    1 => self,
                    2 => (self >> 1) + (self & self >> 1 & 1),
                    _ => {
                        let by = by as $int;
                        let (floor, twice) = (self.div_euclid(by), 2 * self.rem_euclid(by));
                        let up = twice > by || (twice == by && floor & 1 == 1);
                        floor + <$int>::from(up)
                    }
                }
            }
            #[inline]
            fn shifted(self, bits: u32) -> Self {
                if bits == 0 {
                    return self;
                }
                // Rounding bias: one unit less than half, and half itself where that makes it even.
                let half = 1 << (bits - 1);
                (self + (half - 1) + (self >> bits & 1)) >> bits
            }
        }
    )*};
}
wide!(i32 i64);

macro_rules! width {
    ($($int:ty: $wide:ty, $above:path;)*) => {$(
        impl Width for $int {
            type Wide = $wide;
            const BITS: u8 = <$int>::BITS as u8;
            const ZERO: $int = 0;
            const LIMITS: ($int, $int) = (<$int>::MIN, <$int>::MAX);
            #[inline]
            fn saturate(wide: i64) -> Self {
                wide.clamp(<$int>::MIN.into(), <$int>::MAX.into()) as $int
            }
            #[inline]
            fn wrap(wide: i64) -> Self {
                wide as $int
            }
            #[inline]
            fn nearest(real: f64) -> i32 {
                // 1.5 * 2^52: in a float so large the lowest bits count ones. A sum, which rounds, where a
                // conversion would have no instruction on vectors.
                const SHIFT: f64 = 6_755_399_441_055_744.0;
                let number = u64::from(!real.is_nan()).wrapping_neg();
                let real = f64::from_bits(real.to_bits() & number);
                let limited = real.clamp(<$int>::MIN.into(), <$int>::MAX.into());
                (limited + SHIFT).to_bits() as i32
            }
            #[inline]
            fn low(bits: i32) -> Self {
                bits as $int
            }
            #[inline]
            fn widen(self) -> $wide {
                self.into()
            }
            #[inline]
            fn saturate_wide(wide: $wide) -> Self {
                wide.clamp(<$int>::MIN.into(), <$int>::MAX.into()) as $int
            }
            #[inline]
            fn wrap_wide(wide: $wide) -> Self {
                wide as $int
            }
            #[inline]
            fn less(self, other: Self) -> Self {
                self.saturating_sub(other)
            }
            #[inline]
            fn more(self, other: Self) -> Self {
                self.saturating_add(other)
            }
            #[inline]
            fn wrapping_less(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            #[inline]
            fn wrapping_more(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            #[inline]
            fn choose(old: Self, new: Self, take: u8) -> Self {
                old ^ ((old ^ new) & (take as $int).wrapping_neg())
            }
            #[inline]
            fn middle(self, other: Self) -> Self {
                // What both have, and half of what one has.
                let floor = (self & other) + ((self ^ other) >> 1);
                floor + ((self ^ other) & floor & 1)
            }
            #[inline(always)]
            fn above(cells: &[Self; 64]) -> u64 {
                $above(cells)
            }
        }
    )*};
}
width! {
    i8: i32, above_8;
    i16: i32, above_16;
    i32: i64, above_32;
}

#[inline(always)]
fn above_8(cells: &[i8; 64]) -> u64 {
    joined(cells, |some| {
        i8x16::new(*some).simd_gt(i8x16::ZERO).to_bitmask()
    })
}

#[inline(always)]
fn above_16(cells: &[i16; 64]) -> u64 {
    // What is above zero stays so.
    let narrow = |some: &[i16; 16]| i8x16::from_i16x16_saturate(i16x16::new(*some));
    joined(cells, |some| narrow(some).simd_gt(i8x16::ZERO).to_bitmask())
}

#[inline(always)]
fn above_32(cells: &[i32; 64]) -> u64 {
    joined(cells, |some| {
        i32x8::new(*some).simd_gt(i32x8::ZERO).to_bitmask()
    })
}

/// The bits of `N` cells after those of the `N` before.
#[inline(always)]
fn joined<T, const N: usize>(cells: &[T; 64], bits: impl Fn(&[T; N]) -> u32) -> u64 {
    let parts = cells.as_chunks().0.iter().enumerate();
    parts.fold(0, |word, (k, some)| word | u64::from(bits(some)) << (N * k))
}

/// `numerator / denominator` to the nearest, halves to even.
///
/// The denominator is positive, and at most 2^62.
#[must_use]
#[inline]
pub const fn divide(numerator: i64, denominator: i64) -> i64 {
    let floor = numerator.div_euclid(denominator);
    let twice = 2 * numerator.rem_euclid(denominator);
    let up = twice > denominator || (twice == denominator && floor & 1 == 1);
    floor + up as i64
}

/// Fixed point in an integer of width `T`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Q<T> {
    fraction: u8,
    overflow: Overflow,
    width: std::marker::PhantomData<T>,
}

impl<T: Width> Q<T> {
    /// With `fraction` bits after the point (no more than the width), saturating.
    #[must_use]
    pub fn new(fraction: u8) -> Self {
        Self {
            fraction: fraction.min(T::BITS),
            overflow: Overflow::Saturate,
            width: std::marker::PhantomData,
        }
    }

    /// The same with another rule for overflow.
    #[must_use]
    pub fn with_overflow(self, overflow: Overflow) -> Self {
        Self { overflow, ..self }
    }

    /// The rule for overflow.
    #[must_use]
    #[inline]
    pub const fn overflow(&self) -> Overflow {
        self.overflow
    }

    /// Brings a sum or quotient of held integers back to the width.
    #[must_use]
    #[inline]
    pub fn fit(&self, wide: i64) -> T {
        match self.overflow {
            Overflow::Saturate => T::saturate(wide),
            Overflow::Wrap => T::wrap(wide),
        }
    }

    /// As [`Q::fit`], of the width's own sums.
    #[must_use]
    #[inline]
    pub fn narrow(&self, wide: T::Wide) -> T {
        match self.overflow {
            Overflow::Saturate => T::saturate_wide(wide),
            Overflow::Wrap => T::wrap_wide(wide),
        }
    }

    /// How many steps make one.
    #[must_use]
    #[inline]
    pub fn one(&self) -> i64 {
        1 << self.fraction
    }
}

impl<T: Width> Number for Q<T> {
    type Held = T;
    type Real = f64;
    const ZERO: T = T::ZERO;

    fn format(&self) -> Format {
        Format::Fixed(FixedFormat::new(T::BITS, self.fraction, self.overflow))
    }

    #[inline]
    fn hold(&self, real: f64) -> T {
        // Scaling by a power of two is exact, or overflows to infinity, which saturates.
        let steps = real * self.one() as f64;
        match self.overflow {
            Overflow::Wrap if steps.is_finite() => {
                // The remainder of floats is exact, so nothing of a huge number is lost.
                T::wrap((steps.round_ties_even() % 2f64.powi(T::BITS.into())) as i64)
            }
            _ => T::low(T::nearest(steps)),
        }
    }

    #[inline]
    fn value(&self, held: T) -> f64 {
        let steps: i64 = held.into();
        // The inverse of a power of two is exact, and no width is more than 32 bits.
        f64::from(steps as i32) * (1.0 / self.one() as f64)
    }

    #[inline]
    fn real(&self, held: T) -> f64 {
        self.value(held)
    }

    #[inline]
    fn hold_real(&self, real: f64) -> T {
        self.hold(real)
    }

    #[inline]
    fn add(&self, a: T, b: T) -> T {
        match self.overflow {
            Overflow::Saturate => a.more(b),
            Overflow::Wrap => a.wrapping_more(b),
        }
    }

    #[inline]
    fn sub(&self, a: T, b: T) -> T {
        match self.overflow {
            Overflow::Saturate => a.less(b),
            Overflow::Wrap => a.wrapping_less(b),
        }
    }

    #[inline]
    fn mul(&self, a: T, b: T) -> T {
        let b: i64 = b.into();
        self.narrow(a.widen().times(b as i32).shifted(self.fraction.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::{Wide, divide};

    #[test]
    fn a_shift_is_a_division() {
        for bits in 0..=16 {
            for n in -70_000..70_000 {
                let exact = divide(n.into(), 1 << bits);
                assert_eq!(i64::from(n.shifted(bits)), exact, "{n} by {bits} bits");
                assert_eq!(i64::from(n).shifted(bits), exact);
            }
        }
        for n in [1 << 62, (1 << 62) - 1, 3 << 31, -(1 << 62), -(3 << 31) - 1] {
            assert_eq!(i64::shifted(n, 32), divide(n, 1 << 32));
        }
    }
}
