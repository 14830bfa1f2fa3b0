//! Random numbers: a hash of (seed, reason, place, step), never a stream, so that no order of
//! work and no number of threads can change one.
//!
//! A [`struct@Hash`] begins with the seed and takes in one word after the other; any hash gives 64 random
//! bits, a uniform number or, two of them, a normal one. Each room that draws has its own list of
//! reasons. `row` has the form for rows of the array, in 32 bits for wide vectors.

pub(crate) mod row;

use crate::elementary;

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

/// A number in [0, 1) from a mixed word: its upper 53 bits.
#[inline]
#[must_use]
pub const fn uniform(word: u64) -> f64 {
    (word >> 11) as f64 / (1u64 << 53) as f64
}

/// A standard normal number from two independent uniform ones in [0, 1) (Box & Muller, 1958);
/// at most 8.6 in size.
#[inline]
#[must_use]
pub fn normal(radius: f64, angle: f64) -> f64 {
    (-2.0 * elementary::ln(1.0 - radius)).sqrt() * elementary::cos(std::f64::consts::TAU * angle)
}

/// The hash of what a number is drawn for.
///
/// Two hashes that took in other words, or the same ones in another order, have nothing in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hash(u64);

impl Hash {
    /// The hash of a seed.
    #[inline]
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self::raw(seed).nth(1)
    }

    /// A word as it stands: for seeds that are mixed already or that
    /// [`nth`](Self::nth) mixes.
    #[inline]
    #[must_use]
    pub const fn raw(word: u64) -> Self {
        Self(word)
    }

    /// The hash with one more word: a reason, a place, a step.
    #[inline]
    #[must_use]
    pub const fn with(self, word: u64) -> Self {
        Self(mix((self.0 ^ word).wrapping_add(GOLDEN)))
    }

    /// As [`with`](Self::with), a step shorter: a hash and a word that are alike give 0.
    #[inline]
    #[must_use]
    pub const fn with_mixed(self, word: u64) -> Self {
        Self(mix(self.0 ^ word))
    }

    /// The `n`-th hash of a sequence: what `SplitMix64` gives from this one as its state.
    #[inline]
    #[must_use]
    pub const fn nth(self, n: u64) -> Self {
        Self(mix(self.0.wrapping_add(GOLDEN.wrapping_mul(n))))
    }

    /// Its 64 random bits.
    #[inline]
    #[must_use]
    pub const fn bits(self) -> u64 {
        self.0
    }

    /// A number in [0, 1).
    #[inline]
    #[must_use]
    pub const fn uniform(self) -> f64 {
        uniform(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs of `SplitMix64` from seed 0, as published with it.
    #[test]
    fn words_are_those_of_the_generator() {
        let words = [1, 2, 3].map(|n| Hash::raw(0).nth(n).bits());
        let published = [
            0xE220_A839_7B1D_CDAF,
            0x6E78_9E6A_A1B9_65F4,
            0x06C4_5D18_8009_454F,
        ];
        assert_eq!(words, published);
        assert_eq!(Hash::new(0).bits(), published[0]);
    }

    #[test]
    fn keys_differ_by_every_word_and_by_their_order() {
        let key = Hash::new(7).with(1).with(2);
        for other in [
            Hash::new(8).with(1).with(2),
            Hash::new(7).with(2).with(1),
            Hash::new(7).with(1).with_mixed(2),
            Hash::new(7).with(1).with(2).nth(1),
            Hash::new(7).with(1).nth(2),
        ] {
            assert_ne!(key, other);
        }
    }

    /// Means within 4 sigma; the ends of the uniform numbers give finite normal ones.
    #[test]
    fn normal_numbers_have_their_moments() {
        const DRAWS: u64 = 200_000;
        let drawn: Vec<f64> = (0..DRAWS)
            .map(|i| Hash::new(3).with(i))
            .map(|key| normal(key.uniform(), key.nth(1).uniform()))
            .collect();
        let moment = |power| drawn.iter().map(|x| x.powi(power)).sum::<f64>() / DRAWS as f64;
        let sigma = 4.0 / (DRAWS as f64).sqrt();
        assert!(moment(1).abs() < sigma, "{}", moment(1));
        assert!(
            (moment(2) - 1.0).abs() < sigma * 2f64.sqrt(),
            "{}",
            moment(2)
        );
        let most = uniform(u64::MAX);
        assert_eq!(normal(0.0, 0.0).abs(), 0.0);
        assert!(
            (8.5..8.6).contains(&normal(most, 0.0)),
            "{}",
            normal(most, 0.0)
        );
    }
}
