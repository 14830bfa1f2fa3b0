//! Sixty-four bits in a word, and as bytes, which loops in vectors can make and take.

// What is not inlined into such a loop is not compiled for its vectors.
#![allow(clippy::inline_always)]

/// The lowest bit of each byte; none has others.
#[inline(always)]
#[must_use]
pub fn packed(bytes: &[u8; 64]) -> u64 {
    let (eights, _) = bytes.as_chunks::<8>();
    let mut words = [0; 8];
    for (word, eight) in words.iter_mut().zip(eights) {
        // Bits come together in pairs, fours and eights.
        let ones = u64::from_le_bytes(*eight);
        let ones = (ones | ones >> 7) & 0x0003_0003_0003_0003;
        let ones = (ones | ones >> 14) & 0x0000_000F_0000_000F;
        *word = (ones | ones >> 28) & 0xFF;
    }
    let mut all = 0;
    for (k, word) in words.into_iter().enumerate() {
        all |= word << (8 * k);
    }
    all
}

/// A byte, 0 or 1, for every bit.
#[inline(always)]
#[must_use]
pub fn spread(word: u64) -> [u8; 64] {
    let mut bytes = [0; 64];
    let (eights, _) = bytes.as_chunks_mut::<8>();
    for (k, eight) in eights.iter_mut().enumerate() {
        // Each byte keeps a bit of its own; it carries into the highest, which goes to the
        // lowest.
        let all = (word >> (8 * k) & 0xFF) * 0x0101_0101_0101_0101;
        let own = all & 0x8040_2010_0804_0201;
        let ones = (own + 0x7F7F_7F7F_7F7F_7F7F) >> 7 & 0x0101_0101_0101_0101;
        *eight = ones.to_le_bytes();
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_become_bits_and_bits_bytes() {
        for word in [0, 1, !0, 0x8000_0000_0000_0001, 0x0123_4567_89AB_CDEF] {
            let bytes = std::array::from_fn(|i| (word >> i & 1) as u8);
            assert_eq!(packed(&bytes), word);
            assert_eq!(spread(word), bytes);
        }
    }
}
