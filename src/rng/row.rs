//! Random numbers for the array: nearly normal, in `f32`, and a row of pixels at a time.
//!
//! Silicon draws a number for every pixel of every store, so a row is drawn in 32 bits, without a
//! branch: that runs in wide vectors, which a [`Hash`] for each pixel does not.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use super::Hash;

/// A word from a seed, a kind of event, a register, a step and a pixel.
#[inline]
pub(crate) const fn hash(seed: u64, kind: u64, register: u8, step: u64, pixel: u64) -> u64 {
    let reason = Hash::raw(seed).nth(1 + kind);
    let place = reason.with_mixed((register as u64) << 56 ^ step);
    place.nth(pixel).bits()
}

/// Nearly normal, mean 0 and variance 1: the sum of the eight bytes of a random word, so never
/// beyond 4.9.
#[inline]
pub(crate) fn normal(word: u64) -> f32 {
    // Bytes in pairs, then in fours: no loop.
    let pairs = (word & 0x00FF_00FF_00FF_00FF) + (word >> 8 & 0x00FF_00FF_00FF_00FF);
    let sum = pairs.wrapping_mul(0x0001_0001_0001_0001) >> 48;
    // 8 · 127.5, and the root of 8 · (256² - 1) / 12.
    (sum as f32 - 1020.0) * (1.0 / 209.022_33)
}

/// The chance of one word on one register: a value for every pixel, nearly normal, mean 0 and
/// variance 1, never beyond 4.9.
///
/// All of it in 32 bits, so that it runs in wide vectors. The multipliers are those of
/// `lowbias32` (C. Wellons, public domain); the second half of the key comes in between, so
/// that two words whose first halves lie close do not repeat each other a few pixels on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draws {
    first: u32,
    second: u32,
}

impl Draws {
    /// From what [`hash`] takes, the pixel excepted.
    #[inline]
    pub(crate) const fn new(seed: u64, kind: u64, register: u8, step: u64) -> Self {
        let key = hash(seed, kind, register, step, 0);
        Self {
            first: key as u32,
            second: (key >> 32) as u32,
        }
    }

    /// What [`normal`](Self::normal) is made of, for each of the pixels from `first` on: the
    /// bytes of two words, summed to two halves.
    ///
    /// In three loops: the chain of operations in each is so short that the processor works on
    /// more pixels at once, and their constants stay in its registers.
    #[inline(always)]
    pub(crate) fn draw(self, first: u32, halves: &mut [u32]) {
        let mut pixel = first.wrapping_add(self.first);
        for half in &mut *halves {
            *half = (pixel ^ pixel >> 16).wrapping_mul(0x7FEB_352D);
            pixel = pixel.wrapping_add(1);
        }
        for half in &mut *halves {
            let word = (*half ^ *half >> 15 ^ self.second).wrapping_mul(0x846C_A68B);
            *half = word ^ word >> 16;
        }
        for half in &mut *halves {
            let one = *half;
            let other = one.wrapping_mul(0x9E37_79B1);
            let other = other ^ other >> 15;
            let pairs = (one & 0x00FF_00FF) + (one >> 8 & 0x00FF_00FF);
            *half = pairs + (other & 0x00FF_00FF) + (other >> 8 & 0x00FF_00FF);
        }
    }

    /// The value of a pixel.
    #[inline(always)]
    pub(crate) fn normal(halves: u32) -> f32 {
        let sum = (halves & 0xFFFF) + (halves >> 16);
        (sum as i32 as f32 - 1020.0) * (1.0 / 209.022_33)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_is_normal_and_differs_by_every_part_of_the_place() {
        let n = 100_000;
        let draws: Vec<f64> = (0..n)
            .map(|i| f64::from(normal(hash(1, 2, 3, 4, i))))
            .collect();
        let moment = |power| draws.iter().map(|x| x.powi(power)).sum::<f64>() / n as f64;
        assert!(moment(1).abs() < 0.015, "{}", moment(1));
        assert!((moment(2) - 1.0).abs() < 0.02, "{}", moment(2));
        assert!(moment(3).abs() < 0.04, "{}", moment(3));
        // Eight summands: an excess of -0.15.
        assert!((moment(4) - 2.85).abs() < 0.08, "{}", moment(4));
        let together: f64 = (0..n)
            .map(|i| f64::from(normal(hash(1, 2, 3, 4, i)) * normal(hash(1, 2, 3, 5, i))))
            .sum();
        assert!((together / n as f64).abs() < 0.015);
        let place = hash(1, 2, 3, 4, 5);
        for other in [
            hash(0, 2, 3, 4, 5),
            hash(1, 0, 3, 4, 5),
            hash(1, 2, 0, 4, 5),
            hash(1, 2, 3, 0, 5),
            hash(1, 2, 3, 4, 0),
        ] {
            assert_ne!(place, other);
        }
    }

    #[test]
    fn draws_are_normal_and_alike_in_nothing() {
        let n = 1 << 18;
        let plane = |seed, register, step| -> Vec<f64> {
            let mut drawn = vec![0; n as usize];
            Draws::new(seed, 3, register, step).draw(0, &mut drawn);
            { drawn.into_iter() }
                .map(|halves| f64::from(Draws::normal(halves)))
                .collect()
        };
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / f64::from(n);
        for step in 0..20 {
            let draws = plane(5, 2, step);
            let moment = |power| mean(&mut draws.iter().map(|x| x.powi(power)));
            // Four standard errors.
            assert!(moment(1).abs() < 0.008, "{}", moment(1));
            assert!((moment(2) - 1.0).abs() < 0.011, "{}", moment(2));
            assert!(moment(3).abs() < 0.03, "{}", moment(3));
            assert!((moment(4) - 2.85).abs() < 0.08, "{}", moment(4));
            // With itself some pixels on, with the next step, register and seed.
            for lag in [1, 2, 3, 8, 255, 256, 257, 512, 65536] {
                let along = mean(&mut draws.iter().zip(&draws[lag..]).map(|(a, b)| a * b));
                assert!(along.abs() < 0.008, "{lag}: {along}");
            }
            for other in [plane(5, 2, step + 1), plane(5, 3, step), plane(6, 2, step)] {
                let with = mean(&mut draws.iter().zip(&other).map(|(a, b)| a * b));
                assert!(with.abs() < 0.008, "{with}");
            }
        }
    }

    #[test]
    fn the_sum_of_bytes_is_the_sum_of_bytes() {
        for i in 0..1000 {
            let word = Hash::raw(i).nth(1).bits();
            let slow: f32 = word.to_le_bytes().iter().map(|b| f32::from(*b)).sum();
            assert_eq!(normal(word), (slow - 1020.0) * (1.0 / 209.022_33));
        }
    }
}
