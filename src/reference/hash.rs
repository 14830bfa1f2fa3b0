//! Chance as a hash of where and why it is drawn, so that the order of work cannot change it.

/// Why a number is drawn: no two reasons share their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Why {
    ThresholdOn = 1,
    ThresholdOff = 2,
    LeakRate = 3,
    ShotCount = 4,
    ShotSign = 5,
    ShotPlace = 6,
    HotPixel = 7,
    HotCount = 8,
    HotPlace = 9,
    Jitter = 10,
}

/// A cell to draw for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) seed: u64,
    pub(super) channel: usize,
    pub(super) y: usize,
    pub(super) x: usize,
}

impl Place {
    /// A uniform number in [0, 1); `step` is the pair, or whatever else comes again.
    pub(super) fn uniform(self, why: Why, step: u64) -> f64 {
        let cell = ((self.channel as u64) << 48) | ((self.y as u64) << 24) | self.x as u64;
        let mut h = mix(self.seed.wrapping_add(GOLDEN));
        for part in [why as u64, cell, step] {
            h = mix((h ^ part).wrapping_add(GOLDEN));
        }
        (h >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A standard normal number (Box & Muller, 1958).
    pub(super) fn normal(self, why: Why, step: u64) -> f64 {
        let radius = 1.0 - self.uniform(why, 2 * step);
        let angle = self.uniform(why, 2 * step + 1);
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    }

    /// A Poisson count of this mean, by inverting its distribution.
    pub(super) fn poisson(self, why: Why, step: u64, mean: f64) -> u64 {
        let drawn = self.uniform(why, step);
        // A mean this large is a pixel that does nothing else; beyond, exp(-mean) ends.
        let mean = mean.min(500.0);
        let (mut count, mut term) = (0, (-mean).exp());
        let mut sum = term;
        while drawn >= sum && count < 2000 {
            count += 1;
            term *= mean / count as f64;
            sum += term;
        }
        count
    }
}

const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// The finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: u64 = 200_000;

    fn place(i: u64) -> Place {
        Place {
            seed: 7,
            channel: 0,
            y: (i / 400) as usize,
            x: (i % 400) as usize,
        }
    }

    fn mean(of: impl Fn(Place, u64) -> f64) -> f64 {
        (0..DRAWS).map(|i| of(place(i), i % 5)).sum::<f64>() / DRAWS as f64
    }

    /// Means within 4 sigma of what the distribution says.
    #[test]
    fn draws_have_their_moments() {
        let near = |got: f64, want: f64, sigma: f64| {
            let bound = 4.0 * sigma / (DRAWS as f64).sqrt();
            assert!(
                (got - want).abs() < bound,
                "{got}, not {want} within {bound}"
            );
        };
        near(
            mean(|p, s| p.uniform(Why::Jitter, s)),
            0.5,
            (1f64 / 12.0).sqrt(),
        );
        near(mean(|p, s| p.normal(Why::Jitter, s)), 0.0, 1.0);
        near(
            mean(|p, s| p.normal(Why::Jitter, s).powi(2)),
            1.0,
            2f64.sqrt(),
        );
        for m in [0.01, 0.7, 5.0] {
            near(
                mean(|p, s| p.poisson(Why::ShotCount, s, m) as f64),
                m,
                m.sqrt(),
            );
        }
        // Neighbours, steps, reasons and seeds are not alike.
        let product = |p: Place, q: Place| {
            (p.uniform(Why::Jitter, 0) - 0.5) * (q.uniform(Why::Jitter, 0) - 0.5)
        };
        near(
            mean(|p, _| product(p, Place { x: p.x + 1, ..p })),
            0.0,
            1.0 / 12.0,
        );
        near(
            mean(|p, _| product(p, Place { seed: 8, ..p })),
            0.0,
            1.0 / 12.0,
        );
    }
}
