//! The halves, held in f32: what they hold, and how a result in f32 becomes one of them.
//!
//! Nothing here branches or calls, so that loops run in vectors: a half is an f32 whose last bits
//! are 0, and a result is rounded where it stands. A machine that converts between the widths
//! takes longer.

// What is not inlined into such a loop is not compiled for its vectors.
#![allow(clippy::inline_always)]

/// A binary16, as the f32 that is 2^112 times as large: the two are infinite together, so that
/// rounding need not look for what is too large.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct HeldF16(f32);

/// A bfloat16, as the f32 that is equal to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct HeldBf16(f32);

const SIGN: u32 = 1 << 31;
const INFINITE: u32 = 0xFF << 23;
/// What a NaN has that is not to become infinite when it is cut.
const QUIET: u32 = 1 << 22;

/// Two to the power of `exponent`, in f32.
const fn power(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

/// The two sides of [`HeldF16`].
const UP: f32 = power(112);
const DOWN: f32 = power(-112);

/// A choice that is made on both sides.
#[inline(always)]
const fn choose(condition: bool, one: u32, other: u32) -> u32 {
    if condition { one } else { other }
}

/// Without its last bits, to the nearest, halves to even; finite, or with nothing in these bits.
#[inline(always)]
const fn cut<const BITS: u32>(bits: u32) -> u32 {
    let bias = (1 << (BITS - 1)) - 1;
    let even = bits >> BITS & 1;
    bits.wrapping_add(bias + even) & !((1 << BITS) - 1)
}

/// As [`cut`], of any number.
#[inline(always)]
const fn cut_any<const BITS: u32>(bits: u32) -> u32 {
    let quiet = (bits | QUIET) & !((1 << BITS) - 1);
    choose(bits & !SIGN > INFINITE, quiet, cut::<BITS>(bits))
}

/// A number whose size is less than `ONE` times 2^22, to the nearest whole multiple of `one`,
/// halves to even.
#[inline(always)]
fn multiple(value: f32, one: f32) -> u32 {
    // Where the last bit counts `one`, whatever the sign.
    let shift = 1.5 * one * power(23);
    ((value + shift) - shift).to_bits() | (value.to_bits() & SIGN)
}

impl HeldF16 {
    /// 0.
    pub(super) const ZERO: Self = Self(0.0);

    /// The nearest.
    #[inline(always)]
    pub(super) fn new(real: f32) -> Self {
        let scaled = real * UP;
        Self(f32::from_bits(Self::rounded(
            scaled,
            cut_any::<13>(scaled.to_bits()),
        )))
    }

    /// What is held.
    #[inline(always)]
    pub(super) fn real(self) -> f32 {
        self.0 * DOWN
    }

    /// Of a number that is 2^112 times as large, and was cut: below the normal numbers its last
    /// bit counts 2^-24.
    #[inline(always)]
    fn rounded(scaled: f32, cut: u32) -> u32 {
        let small = scaled.to_bits() & !SIGN < power(112 - 14).to_bits();
        choose(small, multiple(scaled, power(112 - 24)), cut)
    }

    /// A sum is a whole multiple of 2^-24, so that below the normal numbers it is exact.
    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self(f32::from_bits(cut::<13>((self.0 + other.0).to_bits())))
    }

    /// The same of a difference.
    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        Self(f32::from_bits(cut::<13>((self.0 - other.0).to_bits())))
    }

    /// The product in f32 is exact.
    #[inline(always)]
    pub(super) fn times(self, other: Self) -> Self {
        let scaled = self.real() * other.0;
        Self(f32::from_bits(Self::rounded(
            scaled,
            cut::<13>(scaled.to_bits()),
        )))
    }
}

impl HeldBf16 {
    /// 0.
    pub(super) const ZERO: Self = Self(0.0);

    /// The nearest.
    #[inline(always)]
    pub(super) fn new(real: f32) -> Self {
        Self(f32::from_bits(cut_any::<16>(real.to_bits())))
    }

    /// What is held.
    #[inline(always)]
    pub(super) const fn real(self) -> f32 {
        self.0
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self(f32::from_bits(cut::<16>((self.0 + other.0).to_bits())))
    }

    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        Self(f32::from_bits(cut::<16>((self.0 - other.0).to_bits())))
    }

    /// The product in f32 is exact where it is a normal number. A smaller one, but for 0, is
    /// computed 2^64 times as large.
    #[inline(always)]
    pub(super) fn times(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let bits = product.to_bits();
        let large = multiple(self.0 * power(64) * other.0, power(64 - 133));
        let small = (f32::from_bits(large) * power(-64)).to_bits();
        // One less than the magnitude: 0 is then the largest.
        let subnormal = (bits & !SIGN).wrapping_sub(1) < f32::MIN_POSITIVE.to_bits() - 1;
        Self(f32::from_bits(choose(subnormal, small, cut::<16>(bits))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use half::{bf16, f16};

    fn held_f16(half: f16) -> HeldF16 {
        HeldF16::new(half.to_f32())
    }

    fn held_bf16(half: bf16) -> HeldBf16 {
        HeldBf16::new(half.to_f32())
    }

    /// Around a number and around the middle between it and the next: wherever rounding
    /// changes, something here changes.
    fn near(bits: u32, step: u32) -> impl Iterator<Item = f32> {
        [bits, bits.wrapping_add(step / 2)]
            .into_iter()
            .flat_map(|at| [at.wrapping_sub(1), at, at.wrapping_add(1)])
            .map(f32::from_bits)
    }

    /// Equal to the bit, or both NaN.
    fn same(found: f32, expected: f32, of: impl std::fmt::Debug) {
        if expected.is_nan() {
            assert!(found.is_nan(), "{of:?}");
        } else {
            assert_eq!(found.to_bits(), expected.to_bits(), "{of:?}");
        }
    }

    #[test]
    fn all_of_f16_is_as_the_crate_says() {
        let is = |value: f32| {
            same(
                HeldF16::new(value).real(),
                f16::from_f32(value).to_f32(),
                value,
            );
        };
        for bits in 0..=u16::MAX {
            let wide = f16::from_bits(bits).to_f32();
            is(wide);
            // The next f16 is this many f32 away, in the smallest binade fewer bits count.
            let next = f16::from_bits(bits.wrapping_add(1)).to_f32().to_bits();
            let step = next.wrapping_sub(wide.to_bits());
            near(wide.to_bits(), step).for_each(is);
            let middle = f32::midpoint(wide, f32::from_bits(next));
            near(middle.to_bits(), 0).for_each(is);
        }
        [
            f32::MAX,
            f32::MIN,
            65519.996,
            65520.0,
            1e-45,
            f32::NAN,
            f32::from_bits(u32::MAX >> 1),
        ]
        .into_iter()
        .for_each(is);
    }

    #[test]
    fn all_of_bf16_is_as_the_crate_says() {
        for bits in 0..=u16::MAX {
            let wide = bf16::from_bits(bits).to_f32();
            for value in near(wide.to_bits(), 1 << 16) {
                same(
                    HeldBf16::new(value).real(),
                    bf16::from_f32(value).to_f32(),
                    value,
                );
            }
        }
    }

    /// Pairs of halves of all sizes and of neighbouring ones, where most results lie in the
    /// middle between two others, and all that is rare.
    fn pairs() -> impl Iterator<Item = (u16, u16)> {
        let rare = |k: u16| {
            let ends = [
                0, 1, 0x3F, 0x7F, 0x80, 0x3FF, 0x400, 0x7BFF, 0x7C00, 0x7C01, 0x7F7F, 0x7F80,
                0x7FFF,
            ];
            ends[usize::from(k) % ends.len()] | (k & 1) << 15
        };
        (0..1_000_000u32).map(move |k| {
            let mixed = k.wrapping_mul(0x9E37_79B9) ^ k.wrapping_mul(0x85EB_CA6B) >> 13;
            let (a, b) = (mixed as u16, (mixed >> 16) as u16);
            match k % 4 {
                0 => (a, b),
                1 => (a, (a & 0xFC00).wrapping_add(b & 0x87FF)),
                2 => (a, rare(b)),
                _ => (rare(a), rare(b)),
            }
        })
    }

    #[test]
    fn operations_round_once() {
        for (a, b) in pairs() {
            // f64 holds sums and products exactly, but for sums of bf16 far apart, which an odd
            // last bit stands for.
            let (x, y) = (f16::from_bits(a), f16::from_bits(b));
            let (one, other) = (held_f16(x), held_f16(y));
            let exact = |real: f64| once(real, 11, -24, 65504.0);
            let (x, y) = (x.to_f64(), y.to_f64());
            same(one.plus(other).real(), exact(x + y), (x, y));
            same(one.minus(other).real(), exact(x - y), (x, y));
            same(one.times(other).real(), exact(x * y), (x, y));
            let (x, y) = (bf16::from_bits(a), bf16::from_bits(b));
            let (one, other) = (held_bf16(x), held_bf16(y));
            let exact = |real: f64| once(real, 8, -133, bf16::MAX.to_f64());
            let (x, y) = (x.to_f64(), y.to_f64());
            same(one.plus(other).real(), exact(x + y), (x, y));
            same(one.minus(other).real(), exact(x - y), (x, y));
            same(one.times(other).real(), exact(x * y), (x, y));
        }
    }

    /// To so many bits, the last no less than 2^`least`, halves to even: by the definition.
    fn once(real: f64, bits: i32, least: i32, most: f64) -> f32 {
        if !real.is_finite() || real == 0.0 {
            return real as f32;
        }
        let exponent = (real.abs().to_bits() >> 52) as i32 - 1023;
        let unit = 2f64.powi((exponent - bits + 1).max(least));
        let rounded = (real / unit).round_ties_even() * unit;
        if rounded.abs() > most {
            return f32::INFINITY.copysign(real as f32);
        }
        (rounded as f32).copysign(real as f32)
    }
}
