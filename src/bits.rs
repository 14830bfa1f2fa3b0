//! Sixty-four bits in a word, and as bytes, which loops in vectors can make.

// What is not inlined into such a loop is not compiled for its vectors.
#![allow(clippy::inline_always)]

/// The lowest bit of each byte; none has others.
#[inline(always)]
#[must_use]
pub fn packed(bytes: &[u8; 64]) -> u64 {
    // Bit k of byte j of this is byte j of the k-th eight.
    let mut square = 0;
    for (k, eight) in bytes.as_chunks::<8>().0.iter().enumerate() {
        square |= u64::from_le_bytes(*eight) << k;
    }
    // Rows and columns of the square change places, in blocks of 1, 2 and 4.
    let swapped = |square: u64, by: u32, mask: u64| {
        let moved = (square ^ square >> by) & mask;
        square ^ moved ^ moved << by
    };
    let square = swapped(square, 7, 0x00AA_00AA_00AA_00AA);
    let square = swapped(square, 14, 0x0000_CCCC_0000_CCCC);
    swapped(square, 28, 0x0000_0000_F0F0_F0F0)
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
