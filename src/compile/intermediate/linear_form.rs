//! Linear forms: what a register holds while a filter runs, as a sum of weighted, shifted
//! inputs. Weights are whole numbers of one small unit.

use crate::{isa::Direction, rng::GOLDEN};

/// One weight at one place relative to the pixel: `y` rows down, `x` columns to the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(in crate::compile) struct Tap {
    pub(in crate::compile) y: i16,
    pub(in crate::compile) x: i16,
    pub(in crate::compile) weight: i64,
}

/// `value(p) = sum of weight * input(p + (y, x))`; taps by place, none of weight 0.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(in crate::compile) struct LinearForm {
    taps: Vec<Tap>,
}

/// The largest weight that the search follows, so that sums stay far from overflow.
const LARGEST_WEIGHT: i64 = 1 << 40;

/// The farthest a value is moved, in pixels.
const FARTHEST: i16 = 64;

/// The NEWS cells that a pixel can read: its own, then its neighbours' in the order of
/// [`Direction::ALL`].
pub(in crate::compile) const NEWS_CELLS: [(i16, i16); 5] =
    [(0, 0), (-1, 0), (0, 1), (1, 0), (0, -1)];

/// The offset of a NEWS cell; `None` is the cell of the pixel itself.
pub(in crate::compile) fn step(view: Option<Direction>) -> (i16, i16) {
    view.map_or((0, 0), |direction| {
        let (y, x) = direction.step();
        (y as i16, x as i16)
    })
}

impl LinearForm {
    /// One weight, at the pixel itself.
    pub(in crate::compile) fn unit(weight: i64) -> Self {
        Self::new(vec![Tap { y: 0, x: 0, weight }])
    }

    /// A form of taps at different places.
    pub(in crate::compile) fn new(mut taps: Vec<Tap>) -> Self {
        taps.retain(|tap| tap.weight != 0);
        taps.sort_unstable();
        Self { taps }
    }

    pub(in crate::compile) fn taps(&self) -> &[Tap] {
        &self.taps
    }

    pub(in crate::compile) fn is_zero(&self) -> bool {
        self.taps.is_empty()
    }

    /// The weight at a place.
    pub(in crate::compile) fn at(&self, (y, x): (i16, i16)) -> i64 {
        let found = self
            .taps
            .binary_search_by_key(&(y, x), |tap| (tap.y, tap.x));
        found.map_or(0, |i| self.taps[i].weight)
    }

    /// Whether all weights and places are within the bounds of the search.
    pub(in crate::compile) fn is_bounded(&self) -> bool {
        self.taps.iter().all(|tap| {
            tap.weight.abs() <= LARGEST_WEIGHT && tap.y.abs() <= FARTHEST && tap.x.abs() <= FARTHEST
        })
    }

    pub(in crate::compile) fn times(&self, by: i64) -> Self {
        if by == 0 {
            return Self::default();
        }
        let mut taps = self.taps.clone();
        for tap in &mut taps {
            tap.weight *= by;
        }
        Self { taps }
    }

    /// Half of it; `None` where a weight is odd.
    pub(in crate::compile) fn half(&self) -> Option<Self> {
        let mut taps = self.taps.clone();
        for tap in &mut taps {
            if tap.weight % 2 != 0 {
                return None;
            }
            tap.weight /= 2;
        }
        Some(Self { taps })
    }

    /// The form read from a cell a step away: taps at t come to t + step.
    pub(in crate::compile) fn shifted(&self, (dy, dx): (i16, i16)) -> Self {
        let mut taps = self.taps.clone();
        for tap in &mut taps {
            tap.y += dy;
            tap.x += dx;
        }
        Self { taps }
    }

    /// Whether this is `times` the form that `other` is when it is read a step away.
    pub(in crate::compile) fn is_shifted(
        &self,
        other: &Self,
        (dy, dx): (i16, i16),
        times: i64,
    ) -> bool {
        self.taps.len() == other.taps.len()
            && self
                .taps
                .iter()
                .zip(&other.taps)
                .all(|(a, b)| (a.y, a.x, a.weight) == (b.y + dy, b.x + dx, b.weight * times))
    }

    /// A 64-bit hash of the form.
    pub(in crate::compile) fn fingerprint(&self) -> u64 {
        let mut hash = 0x243F_6A88_85A3_08D3u64;
        for tap in &self.taps {
            let place = (tap.y as u16 as u64) << 16 | tap.x as u16 as u64;
            hash = (hash ^ place).wrapping_mul(GOLDEN);
            hash = (hash.rotate_left(29) ^ tap.weight as u64).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        }
        hash ^ hash >> 31
    }

    /// `self + times * other`.
    pub(in crate::compile) fn plus(&self, other: &Self, times: i64) -> Self {
        let mut taps = Vec::with_capacity(self.taps.len() + other.taps.len());
        let (mut a, mut b) = (
            self.taps.iter().copied().peekable(),
            other.taps.iter().peekable(),
        );
        loop {
            let scaled = |tap: &Tap| Tap {
                weight: tap.weight * times,
                ..*tap
            };
            match (a.peek(), b.peek()) {
                (None, None) => break,
                (Some(tap), None) => {
                    taps.push(*tap);
                    a.next();
                }
                (None, Some(tap)) => {
                    taps.push(scaled(tap));
                    b.next();
                }
                (Some(p), Some(q)) => match (p.y, p.x).cmp(&(q.y, q.x)) {
                    std::cmp::Ordering::Less => {
                        taps.push(*p);
                        a.next();
                    }
                    std::cmp::Ordering::Greater => {
                        taps.push(scaled(q));
                        b.next();
                    }
                    std::cmp::Ordering::Equal => {
                        let weight = p.weight + q.weight * times;
                        if weight != 0 {
                            taps.push(Tap { weight, ..*p });
                        }
                        a.next();
                        b.next();
                    }
                },
            }
        }
        Self { taps }
    }

    /// Exact division by a sum of shifts: the form that, read from all these steps and summed,
    /// gives this one.
    pub(in crate::compile) fn divided(&self, steps: &[(i16, i16)]) -> Option<Self> {
        let (&lead, others) = steps.split_first()?;
        if others.is_empty() {
            return Some(self.shifted((-lead.0, -lead.1)));
        }
        let sum: i64 = self.taps.iter().map(|tap| tap.weight).sum();
        if sum % steps.len() as i64 != 0 {
            return None;
        }
        // From the first place on: the first step is the smallest, so each of its taps is final
        // once all before it are gone.
        let smallest = steps.iter().min()?;
        let last = self.taps.last().map(|tap| (tap.y, tap.x))?;
        let largest = steps.iter().max()?;
        let bound = (last.0 - largest.0, last.1 - largest.1);
        let columns = self.taps.iter().map(|tap| tap.x);
        let (left, right) = (columns.clone().min()?, columns.max()?);
        let side = steps.iter().map(|step| step.1);
        let (west, east) = (side.clone().min()?, side.max()?);
        let mut rest = self.clone();
        let mut quotient = Vec::new();
        while let Some(first) = rest.taps.first().copied() {
            let at = (first.y - smallest.0, first.x - smallest.1);
            if at > bound || at.1 + west < left || at.1 + east > right {
                return None;
            }
            let tap = Tap {
                y: at.0,
                x: at.1,
                weight: first.weight,
            };
            for (dy, dx) in steps {
                let shifted = Tap {
                    y: tap.y + dy,
                    x: tap.x + dx,
                    weight: tap.weight,
                };
                rest.subtract(shifted);
            }
            quotient.push(tap);
        }
        Some(Self::new(quotient))
    }

    fn subtract(&mut self, tap: Tap) {
        let found = self
            .taps
            .binary_search_by_key(&(tap.y, tap.x), |t| (t.y, t.x));
        match found {
            Ok(i) => {
                self.taps[i].weight -= tap.weight;
                if self.taps[i].weight == 0 {
                    self.taps.remove(i);
                }
            }
            Err(i) => self.taps.insert(
                i,
                Tap {
                    weight: -tap.weight,
                    ..tap
                },
            ),
        }
    }

    /// The largest form (greedily, from the first place on) that all these steps have in common:
    /// its sum over the steps uses each weight once.
    pub(in crate::compile) fn common(&self, steps: &[(i16, i16)]) -> Self {
        let mut rest = self.clone();
        let mut found = Vec::new();
        let Some(smallest) = steps.iter().min() else {
            return Self::default();
        };
        for tap in &self.taps {
            let at = (tap.y - smallest.0, tap.x - smallest.1);
            let weights = steps.iter().map(|(dy, dx)| rest.at((at.0 + dy, at.1 + dx)));
            let least = weights.clone().map(i64::abs).min().unwrap_or(0);
            let weight = least * tap.weight.signum();
            if weight == 0 || !weights.clone().all(|w| w.signum() == weight.signum()) {
                continue;
            }
            for (dy, dx) in steps {
                rest.subtract(Tap {
                    y: at.0 + dy,
                    x: at.1 + dx,
                    weight,
                });
            }
            found.push(Tap {
                y: at.0,
                x: at.1,
                weight,
            });
        }
        Self::new(found)
    }

    /// Whether reading this form a step away is safe at the border: no tap points back from
    /// beyond the array to a pixel that lies on it.
    pub(in crate::compile) fn is_outward(&self, (dy, dx): (i16, i16)) -> bool {
        self.taps
            .iter()
            .all(|tap| tap.y * dy >= 0 && tap.x * dx >= 0)
    }

    /// The lowest and the highest value for inputs from `low` to `high`, in units.
    pub(in crate::compile) fn bounds(&self, low: f64, high: f64) -> (f64, f64) {
        let mut ends = (0.0, 0.0);
        for tap in &self.taps {
            let weight = tap.weight as f64;
            ends.0 += (weight * low).min(weight * high);
            ends.1 += (weight * low).max(weight * high);
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::intermediate::random_form::forms;
    use proptest::prelude::*;

    fn product(form: &LinearForm, steps: &[(i16, i16)]) -> LinearForm {
        let none = LinearForm::default();
        steps
            .iter()
            .fold(none, |sum, step| sum.plus(&form.shifted(*step), 1))
    }

    proptest! {
        #[test]
        fn division_undoes_the_sum(form in forms(3, 5), which in 1usize..31) {
            prop_assume!(!form.is_zero());
            let steps: Vec<_> = (0..5).filter(|i| which >> i & 1 == 1).map(|i| NEWS_CELLS[i]).collect();
            let sum = product(&form, &steps);
            prop_assert_eq!(sum.divided(&steps), Some(form.clone()));
            let broken = sum.plus(&LinearForm::unit(1), 1);
            if let Some(other) = broken.divided(&steps) {
                prop_assert_eq!(product(&other, &steps), broken);
            }
        }

        #[test]
        fn what_is_common_and_the_rest_are_the_whole(form in forms(3, 5), which in 1usize..31) {
            let steps: Vec<_> = (0..5).filter(|i| which >> i & 1 == 1).map(|i| NEWS_CELLS[i]).collect();
            let common = form.common(&steps);
            let rest = form.plus(&product(&common, &steps), -1);
            let size = |form: &LinearForm| form.taps().iter().map(|tap| tap.weight.abs()).sum::<i64>();
            prop_assert_eq!(size(&rest) + steps.len() as i64 * size(&common), size(&form));
        }
    }
}
