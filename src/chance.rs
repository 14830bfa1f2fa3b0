//! Chance as a hash, so that no order of work can change it.

/// What consecutive numbers are spread by before they are mixed: 2^64 over the golden ratio.
pub const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// A well-mixed word (the finaliser of `SplitMix64`: Steele, Lea, Flood 2014,
/// doi:10.1145/2714064.2660195).
#[inline]
#[must_use]
pub const fn mix(word: u64) -> u64 {
    let word = (word ^ word >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ word >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ word >> 31
}

/// A number in [0, 1) from a mixed word.
#[inline]
#[must_use]
pub const fn uniform(word: u64) -> f64 {
    (word >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs of `SplitMix64` from seed 0, as published with it.
    #[test]
    fn words_are_those_of_the_generator() {
        let words = [1, 2, 3].map(|n| mix(GOLDEN.wrapping_mul(n)));
        let published = [
            0xE220_A839_7B1D_CDAF,
            0x6E78_9E6A_A1B9_65F4,
            0x06C4_5D18_8009_454F,
        ];
        assert_eq!(words, published);
    }
}
