//! From the two 16-bit floats to f32 and back, without a branch, so that rows of them can be
//! converted in vectors. The crate `half` has the types, and is what this is tested against.

use half::{bf16, f16};

/// The value, exactly.
#[inline]
#[must_use]
pub fn widen_f16(half: f16) -> f32 {
    let bits = u32::from(half.to_bits());
    let sign = (bits & 0x8000) << 16;
    let magnitude = (bits & 0x7FFF) << 13;
    // Exponents count from 2^-15 in one and from 2^-127 in the other.
    let finite = (f32::from_bits(magnitude) * f32::from_bits((127 + 112) << 23)).to_bits();
    let beyond = magnitude | 0x7F80_0000;
    f32::from_bits(
        sign | if bits & 0x7C00 == 0x7C00 {
            beyond
        } else {
            finite
        },
    )
}

/// The nearest, halves to even.
#[inline]
#[must_use]
pub fn narrow_f16(single: f32) -> f16 {
    let bits = single.to_bits();
    let sign = (bits >> 16) & 0x8000;
    let magnitude = bits & 0x7FFF_FFFF;
    let odd = (magnitude >> 13) & 1;
    let normal = magnitude.wrapping_add(0x0FFF + odd).wrapping_sub(112 << 23) >> 13;
    // Added to one half, whose last bit is worth 2^-24, the sum is rounded as a subnormal is.
    let small = (f32::from_bits(magnitude) + 0.5)
        .to_bits()
        .wrapping_sub(0.5f32.to_bits());
    let nan = 0x7E00 | (magnitude >> 13) & 0x3FF;
    let half = if magnitude < (127 - 14) << 23 {
        small
    } else if magnitude > 0x7F80_0000 {
        nan
    } else if normal > 0x7C00 {
        0x7C00
    } else {
        normal
    };
    f16::from_bits((sign | half) as u16)
}

/// The value, exactly.
#[inline]
#[must_use]
pub fn widen_bf16(half: bf16) -> f32 {
    f32::from_bits(u32::from(half.to_bits()) << 16)
}

/// The nearest, halves to even.
#[inline]
#[must_use]
pub fn narrow_bf16(single: f32) -> bf16 {
    let bits = single.to_bits();
    let odd = (bits >> 16) & 1;
    let near = bits.wrapping_add(0x7FFF + odd) >> 16;
    let nan = bits >> 16 | 0x40;
    bf16::from_bits(if single.is_nan() { nan } else { near } as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Around every half, every value between two of them that rounding could mistake.
    fn singles() -> impl Iterator<Item = f32> {
        (0..=u16::MAX).flat_map(|top| {
            let near =
                |bits: u32| [bits.wrapping_sub(1), bits, bits.wrapping_add(1)].map(f32::from_bits);
            let tops = u32::from(top) << 16;
            let fine = widen_f16(f16::from_bits(top)).to_bits();
            [tops, tops | 0x8000, fine, fine.wrapping_add(0x1000)]
                .into_iter()
                .flat_map(near)
                .chain([f32::from_bits(u32::from(top)) * 1e7])
        })
    }

    #[test]
    fn every_half_widens_to_its_value() {
        for bits in 0..=u16::MAX {
            let (a, b) = (f16::from_bits(bits), bf16::from_bits(bits));
            let same = |ours: f32, theirs: f32| {
                ours.to_bits() == theirs.to_bits() || ours.is_nan() && theirs.is_nan()
            };
            assert!(same(widen_f16(a), a.to_f32()), "{bits:#06x}");
            assert!(same(widen_bf16(b), b.to_f32()), "{bits:#06x}");
        }
    }

    #[test]
    fn every_single_narrows_to_the_nearest() {
        for single in singles() {
            let same = |ours: u16, theirs: u16, nan: bool| ours == theirs || nan && single.is_nan();
            let (a, b) = (narrow_f16(single), narrow_bf16(single));
            let (a_half, b_half) = (f16::from_f32(single), bf16::from_f32(single));
            assert!(
                same(a.to_bits(), a_half.to_bits(), a.is_nan()),
                "{single:e}: {a:?} {a_half:?}"
            );
            assert!(
                same(b.to_bits(), b_half.to_bits(), b.is_nan()),
                "{single:e}: {b:?} {b_half:?}"
            );
        }
    }
}
