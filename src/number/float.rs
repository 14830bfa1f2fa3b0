//! The four floats.

// What is not inlined into a loop is not compiled for its vectors.
#![allow(clippy::inline_always)]

use super::{Format, HeldBf16, HeldF16, Number};

/// IEEE binary64: the arithmetic that all others are measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct F64;

/// IEEE binary32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct F32;

/// IEEE binary16: 11 bits of precision, to 65504.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct F16;

/// bfloat16: the upper half of a binary32, 8 bits of precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bf16;

/// The two that the machine calculates with.
macro_rules! float_number {
    ($name:ident, $float:ident, $format:expr) => {
        impl Number for $name {
            type Held = $float;
            type Real = $float;
            const ZERO: $float = 0.0;

            #[inline]
            fn format(&self) -> Format {
                $format
            }
            #[inline]
            fn hold(&self, real: f64) -> $float {
                real as $float
            }
            #[inline]
            fn value(&self, held: $float) -> f64 {
                f64::from(held)
            }
            #[inline]
            fn real(&self, held: $float) -> $float {
                held
            }
            #[inline]
            fn hold_real(&self, real: $float) -> $float {
                real
            }
            #[inline]
            fn add(&self, a: $float, b: $float) -> $float {
                a + b
            }
            #[inline]
            fn sub(&self, a: $float, b: $float) -> $float {
                a - b
            }
            #[inline]
            fn mul(&self, a: $float, b: $float) -> $float {
                a * b
            }
        }
    };
}

float_number!(F64, f64, Format::F64);
float_number!(F32, f32, Format::F32);

/// The two halves add in f32 and round again: 24 bits are at least twice 11 plus two, so that
/// the first rounding can never spoil the second (Figueroa 1995, doi:10.1145/221332.221334).
macro_rules! half_number {
    ($name:ident, $held:ident, $format:expr) => {
        impl Number for $name {
            type Held = $held;
            type Real = f32;
            const ZERO: $held = $held::ZERO;

            #[inline]
            fn format(&self) -> Format {
                $format
            }
            #[inline(always)]
            fn hold(&self, real: f64) -> $held {
                $held::new(narrow_to_odd(real))
            }
            #[inline(always)]
            fn value(&self, held: $held) -> f64 {
                f64::from(held.real())
            }
            #[inline(always)]
            fn real(&self, held: $held) -> f32 {
                held.real()
            }
            #[inline(always)]
            fn hold_real(&self, real: f32) -> $held {
                $held::new(real)
            }
            #[inline(always)]
            fn add(&self, a: $held, b: $held) -> $held {
                a.plus(b)
            }
            #[inline(always)]
            fn sub(&self, a: $held, b: $held) -> $held {
                a.minus(b)
            }
            #[inline(always)]
            fn mul(&self, a: $held, b: $held) -> $held {
                a.times(b)
            }
        }
    };
}

half_number!(F16, HeldF16, Format::F16);
half_number!(Bf16, HeldBf16, Format::Bf16);

/// f64 to f32, rounded to odd: what is cut off stays visible in the last bit, so that a second
/// rounding to fewer bits is as good as one. (`half::f16::from_f64` rounds twice on machines
/// that have the instruction for f32.)
#[inline(always)]
fn narrow_to_odd(real: f64) -> f32 {
    let near = real as f32;
    // Without a branch, for loops that run in vectors. NaN is not away from itself.
    let away = u32::from(f64::from(near).abs() > real.abs());
    let odd = u32::from(f64::from(near) < real || f64::from(near) > real);
    f32::from_bits((near.to_bits() - away) | odd)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_keeps_what_is_cut_off() {
        assert_eq!(narrow_to_odd(1.5), 1.5);
        assert_eq!(
            narrow_to_odd(1.0 + 2f64.powi(-40)),
            1.0 + 2f32.powi(-23),
            "just above one is odd"
        );
        assert_eq!(
            narrow_to_odd(1.0 - 2f64.powi(-40)),
            1.0 - 2f32.powi(-24),
            "just below one is odd"
        );
        assert_eq!(narrow_to_odd(1e300), f32::MAX);
        assert_eq!(narrow_to_odd(-1e-300), -f32::from_bits(1));
        assert_eq!(narrow_to_odd(f64::NEG_INFINITY), f32::NEG_INFINITY);
    }
}
