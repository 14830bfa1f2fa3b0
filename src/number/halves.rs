//! Between the halves and f32, without a branch or a call: for loops that run in vectors.
//!
//! To the bit what the `half` crate does; it converts one number at a time, or calls for every
//! eight.

// What is not inlined into such a loop is not compiled for its vectors.
#![allow(clippy::inline_always)]

use half::{bf16, f16};

/// The exponents of f32 above and below what f16 holds as normal numbers.
const ABOVE: u32 = (127 + 16) << 23;
const BELOW: u32 = (127 - 14) << 23;

/// A choice that is made on both sides.
#[inline(always)]
const fn choose(condition: bool, one: u32, other: u32) -> u32 {
    if condition { one } else { other }
}

/// Exactly.
#[inline(always)]
#[must_use]
pub(crate) fn f16_to_f32(half: f16) -> f32 {
    let half = u32::from(half.to_bits());
    let magnitude = (half & 0x7FFF) << 13;
    let exponent = magnitude & 0x7C00 << 13;
    let normal = magnitude + ((127 - 15) << 23);
    // Infinities and (quiet) NaN.
    let quiet = choose(magnitude > 0x7C00 << 13, 1 << 22, 0);
    let beyond = (normal + ((128 - 16) << 23)) | quiet;
    let small = f32::from_bits(normal + (1 << 23)) - f32::from_bits(BELOW);
    let bits = choose(exponent == 0, small.to_bits(), normal);
    let bits = choose(exponent == 0x7C00 << 13, beyond, bits);
    f32::from_bits(bits | (half & 0x8000) << 16)
}

/// The nearest, halves to even.
#[inline(always)]
#[must_use]
pub(crate) fn f32_to_f16(value: f32) -> f16 {
    let sign = value.to_bits() & 0x8000_0000;
    let bits = value.to_bits() ^ sign;
    // The sum rounds as the small number must, its lowest bits are the half.
    let magic = ((127 - 15) + (23 - 10) + 1) << 23;
    let small = (f32::from_bits(bits) + f32::from_bits(magic))
        .to_bits()
        .wrapping_sub(magic);
    let normal = bits
        .wrapping_sub((127 - 15) << 23)
        .wrapping_add(0xFFF + (bits >> 13 & 1))
        >> 13;
    let beyond = choose(bits > 0x7F80_0000, 0x7E00 | (bits >> 13 & 0x3FF), 0x7C00);
    let half = choose(bits < BELOW, small, normal);
    let half = choose(bits >= ABOVE, beyond, half);
    f16::from_bits((half | sign >> 16) as u16)
}

/// Exactly.
#[inline(always)]
#[must_use]
pub(crate) fn bf16_to_f32(half: bf16) -> f32 {
    let bits = u32::from(half.to_bits());
    let quiet = choose(bits & 0x7FFF > 0x7F80, 0x40, 0);
    f32::from_bits((bits | quiet) << 16)
}

/// The nearest, halves to even.
#[inline(always)]
#[must_use]
pub(crate) fn f32_to_bf16(value: f32) -> bf16 {
    let bits = value.to_bits();
    let rounded = bits.wrapping_add(0x7FFF + (bits >> 16 & 1)) >> 16;
    let nan = bits >> 16 | 0x40;
    let half = choose(bits & 0x7FFF_FFFF > 0x7F80_0000, nan, rounded);
    bf16::from_bits(half as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Around a number and around the middle between it and the next: wherever rounding
    /// changes, something here changes.
    fn near(bits: u32, step: u32) -> impl Iterator<Item = f32> {
        [bits, bits.wrapping_add(step / 2)]
            .into_iter()
            .flat_map(|at| [at.wrapping_sub(1), at, at.wrapping_add(1)])
            .map(f32::from_bits)
    }

    #[test]
    fn all_of_f16_is_as_the_crate_says() {
        for bits in 0..=u16::MAX {
            let half = f16::from_bits(bits);
            let wide = f16_to_f32(half);
            assert_eq!(wide.to_bits(), half.to_f32().to_bits(), "{bits:#x}");
            // The next f16 is this many f32 away, in the smallest binade fewer bits count.
            let next = f16::from_bits(bits.wrapping_add(1)).to_f32().to_bits();
            let step = next.wrapping_sub(wide.to_bits());
            for value in near(wide.to_bits(), step) {
                let expected = f16::from_f32(value).to_bits();
                assert_eq!(f32_to_f16(value).to_bits(), expected, "{value:e}");
                let middle = f32::midpoint(wide, f32::from_bits(next));
                for value in near(middle.to_bits(), 0) {
                    let expected = f16::from_f32(value).to_bits();
                    assert_eq!(f32_to_f16(value).to_bits(), expected, "{value:e}");
                }
            }
        }
        for value in [f32::MAX, f32::MIN, 65519.996, 65520.0, 1e-45, f32::NAN] {
            assert_eq!(f32_to_f16(value).to_bits(), f16::from_f32(value).to_bits());
        }
    }

    #[test]
    fn all_of_bf16_is_as_the_crate_says() {
        for bits in 0..=u16::MAX {
            let half = bf16::from_bits(bits);
            let wide = bf16_to_f32(half).to_bits();
            assert_eq!(wide, half.to_f32().to_bits(), "{bits:#x}");
            for value in near(wide, 1 << 16) {
                let expected = bf16::from_f32(value).to_bits();
                assert_eq!(f32_to_bf16(value).to_bits(), expected, "{value:e}");
            }
        }
    }
}
