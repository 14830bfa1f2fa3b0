//! The nearest kernel in few values.

use amacrine::{
    kernel::{
        Kernel,
        quantise::{QuantiseError, Sum},
    },
    plane::Plane,
};

use super::{
    error::LevelsError,
    list::Levels,
    orbits::{Orbits, Symmetry},
};

/// Turns of the search for a scale where the sum is held to 0; each is nearer than the last.
const TURNS: usize = 50;

/// A kernel in few values.
#[derive(Clone, Debug, PartialEq)]
pub struct Projected {
    /// Whole levels.
    pub levels: Plane<f64>,
    /// What they are to be multiplied by to come nearest to the latent kernel.
    pub scale: f64,
}

impl Levels {
    /// The nearest kernel in these levels: `|latent - scale levels|²` is least.
    ///
    /// For `ternary` it is the least of all, with and without a sum of 0 and a symmetry; for others
    /// it is the least of all where the sum is free, and else the least at its scale and the best
    /// scale for its levels. Ties fall to the earlier place.
    ///
    /// # Errors
    /// When all levels would be 0, a weight is not finite, or a symmetry does not fit.
    pub fn project(&self, latent: &Plane<f64>) -> Result<Projected, LevelsError> {
        let shape = latent.dim();
        let orbits = Orbits::new(self.symmetry, shape)?;
        let means = orbits.means(latent);
        let even = orbits.plane(&means, shape);
        // With a free sum equal weights get equal levels, and without a symmetry nothing ties them:
        // then the library's search is the exact one.
        let alone = self.symmetry == Symmetry::None || !self.zero_sum;
        let (levels, scale) = if alone {
            let kernel = Kernel::new(even.clone())?;
            let sum = if self.zero_sum { Sum::Zero } else { Sum::Free };
            let found = match self.quantiser.quantise(&kernel, sum, 0) {
                Err(QuantiseError::Nothing | QuantiseError::Vanished { .. }) => {
                    Err(LevelsError::Empty)
                }
                other => Ok(other?),
            }?;
            (found.levels.weights().clone(), found.scale)
        } else {
            let tied = Tied::new(&orbits, &means);
            let own = if self.largest() == 1 {
                tied.ternary()
            } else {
                tied.alternating(self)
            };
            let (levels, scale) = own.ok_or(LevelsError::Empty)?;
            let levels: Vec<f64> = levels.iter().map(|l| f64::from(*l)).collect();
            (orbits.plane(&levels, shape), scale)
        };
        Ok(Projected::new(&levels, scale))
    }

    /// Levels that were chosen elsewhere, as near to `latent` as their scale makes them.
    ///
    /// # Errors
    /// As [`Levels::project`].
    pub(super) fn chosen(
        &self,
        levels: &Plane<f64>,
        latent: &Plane<f64>,
    ) -> Result<Projected, LevelsError> {
        let orbits = Orbits::new(self.symmetry, latent.dim())?;
        let even = orbits.plane(&orbits.means(latent), latent.dim());
        let scale = (levels * &even).sum() / (levels * levels).sum();
        Ok(Projected::new(levels, scale.max(f64::MIN_POSITIVE)))
    }
}

impl Projected {
    /// Whole levels and their scale; what is 0 has no sign.
    #[must_use]
    pub fn new(levels: &Plane<f64>, scale: f64) -> Self {
        Self {
            levels: levels.mapv(|level| level + 0.0),
            scale,
        }
    }

    /// The levels at a norm of 1: what the forward pass correlates with.
    #[must_use]
    pub fn unit(&self) -> Plane<f64> {
        &self.levels / self.norm()
    }

    /// The norm of the levels: thresholds for [`Projected::unit`] are to be multiplied by it.
    #[must_use]
    pub fn norm(&self) -> f64 {
        (&self.levels * &self.levels).sum().sqrt()
    }

    /// The kernel for the compiler: levels without a common factor, and of at most 1 by a power of two;
    /// and what they were divided by in all. A point of light at level 15 is one at level 1.
    ///
    /// # Errors
    /// Never, unless the levels were changed.
    pub fn kernel(&self) -> Result<(Kernel, f64), LevelsError> {
        let whole = self.levels.iter().map(|level| level.abs() as u64);
        let factor = whole.fold(0, common).max(1) as f64;
        let largest =
            { self.levels.iter() }.fold(1.0, |most: f64, level| most.max(level.abs() / factor));
        let mut power = factor;
        while power < largest * factor {
            power *= 2.0;
        }
        Ok((Kernel::new(&self.levels / power)?, power))
    }
}

/// The largest common factor.
const fn common(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common(b, a % b) }
}

/// One weight for each orbit.
struct Tied<'a> {
    /// How many places share it, and what it is.
    weights: Vec<(usize, f64)>,
    orbits: &'a Orbits,
}

impl<'a> Tied<'a> {
    fn new(orbits: &'a Orbits, means: &[f64]) -> Self {
        let counts = orbits.all.iter().map(Vec::len);
        Self {
            weights: counts.zip(means.iter().copied()).collect(),
            orbits,
        }
    }

    /// The best of -1, 0 and 1 that sum to 0: the residual falls by `<w, l>² / <l, l>`, so for each
    /// `<l, l>` the largest `<w, l>` of sum 0 is found, orbit after orbit.
    fn ternary(&self) -> Option<(Vec<i32>, f64)> {
        let places: usize = self.weights.iter().map(|(count, _)| count).sum();
        let (sums, sizes) = (2 * places + 1, places + 1);
        let at = |sum: usize, size: usize| sum * sizes + size;
        let mut best = vec![f64::NEG_INFINITY; sums * sizes];
        best[at(places, 0)] = 0.0;
        let mut taken: Vec<Vec<i8>> = Vec::new();
        for (count, weight) in &self.weights {
            let mut next = vec![f64::NEG_INFINITY; best.len()];
            let mut by = vec![0_i8; best.len()];
            for (sum, size) in (0..sums).flat_map(|sum| (0..sizes).map(move |size| (sum, size))) {
                let own = best[at(sum, size)];
                if own == f64::NEG_INFINITY {
                    continue;
                }
                let mut take = |level: i8, sum: usize, size: usize, value: f64| {
                    if value > next[at(sum, size)] {
                        next[at(sum, size)] = value;
                        by[at(sum, size)] = level;
                    }
                };
                take(0, sum, size, own);
                if size + count <= places {
                    let gain = *count as f64 * weight;
                    if sum + count < sums {
                        take(1, sum + count, size + count, own + gain);
                    }
                    if sum >= *count {
                        take(-1, sum - count, size + count, own - gain);
                    }
                }
            }
            best = next;
            taken.push(by);
        }
        let gain = |size: usize| {
            let both = best[at(places, size)].max(0.0);
            both * both / size as f64
        };
        let chosen =
            (1..sizes).reduce(|most, size| if gain(size) > gain(most) { size } else { most })?;
        if gain(chosen) <= 0.0 {
            return None;
        }
        let (mut sum, mut size) = (places, chosen);
        let mut levels = vec![0; self.weights.len()];
        for (i, (count, _)) in self.weights.iter().enumerate().rev() {
            let level = taken[i][at(sum, size)];
            levels[i] = i32::from(level);
            if level != 0 {
                size -= count;
                sum = if level > 0 { sum - count } else { sum + count };
            }
        }
        Some((levels, best[at(places, chosen)] / chosen as f64))
    }

    /// The nearest levels of sum 0 at a scale, then the best scale for them, until nothing changes.
    fn alternating(&self, levels: &Levels) -> Option<(Vec<i32>, f64)> {
        let places: usize = self.orbits.all.iter().map(Vec::len).sum();
        let largest = self
            .weights
            .iter()
            .fold(0.0, |most: f64, (_, w)| most.max(w.abs()));
        let mut all: Vec<i32> = levels.magnitudes.iter().flat_map(|l| [-l, *l]).collect();
        all.sort_unstable();
        all.dedup();
        let mut scale = largest / f64::from(levels.largest());
        let mut found: Option<Vec<i32>> = None;
        for _ in 0..TURNS {
            if scale <= 0.0 {
                return None;
            }
            let next = self.nearest(&all, scale, places)?;
            let product = |f: fn(f64, f64) -> f64| -> f64 {
                let each = self.weights.iter().zip(&next);
                each.map(|((count, w), l)| *count as f64 * f(*w, f64::from(*l)))
                    .sum()
            };
            let (both, own) = (product(|w, l| w * l), product(|_, l| l * l));
            if both <= 0.0 {
                // Too coarse a scale leaves nothing: a finer one.
                scale /= 2.0;
                if scale < largest * 1e-6 {
                    return None;
                }
                continue;
            }
            let settled = found.as_ref() == Some(&next);
            scale = both / own;
            found = Some(next);
            if settled {
                break;
            }
        }
        found.map(|levels| (levels, scale))
    }

    /// The levels of sum 0 that are nearest to the weights at a scale.
    fn nearest(&self, all: &[i32], scale: f64, places: usize) -> Option<Vec<i32>> {
        let most = *all.last()? * places as i32;
        let width = (2 * most + 1) as usize;
        let mut cost = vec![f64::INFINITY; width];
        cost[most as usize] = 0.0;
        let mut taken: Vec<Vec<u8>> = Vec::new();
        let mut reach = 0;
        for (count, weight) in &self.weights {
            let mut next = vec![f64::INFINITY; width];
            let mut by = vec![0_u8; width];
            for (k, level) in all.iter().enumerate() {
                let off = f64::from(*level) - weight / scale;
                let more = *count as f64 * off * off;
                let step = level * *count as i32;
                for from in -reach..=reach {
                    let to = from + step + most;
                    let total = cost[(from + most) as usize] + more;
                    if total < next[to as usize] {
                        next[to as usize] = total;
                        by[to as usize] = k as u8;
                    }
                }
            }
            reach += all.last()? * *count as i32;
            cost = next;
            taken.push(by);
        }
        let mut left = most;
        let mut levels = vec![0; self.weights.len()];
        for (i, (count, _)) in self.weights.iter().enumerate().rev() {
            let level = all[usize::from(taken[i][left as usize])];
            levels[i] = level;
            left -= level * *count as i32;
        }
        Some(levels)
    }
}
