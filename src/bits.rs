//! Bits packed from bytes into words of 64, in loops that compile to vector instructions.

// What is not inlined into such a loop is not compiled for its vectors.
#![allow(clippy::inline_always)]

use wide::u8x16;

/// Packs bytes that are 0 or 1 into the bits of a word, the first into the lowest.
#[inline(always)]
#[must_use]
pub fn packed(bytes: &[u8; 64]) -> u64 {
    let mut word = 0;
    for (k, some) in bytes.as_chunks::<16>().0.iter().enumerate() {
        let some = u8x16::new(*some).simd_eq(u8x16::ONE);
        word |= u64::from(some.to_bitmask()) << (16 * k);
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_bits() {
        for word in [0, 1, !0, 0x8000_0000_0000_0001, 0x0123_4567_89AB_CDEF] {
            let bytes = std::array::from_fn(|i| (word >> i & 1) as u8);
            assert_eq!(packed(&bytes), word);
        }
    }
}
