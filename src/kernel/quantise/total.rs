//! Levels with a required sum, as near to the values as possible.
//!
//! For consecutive whole numbers by greedy steps; for other levels by dynamic programming over the
//! sums of the first few weights.

use std::{cmp::Ordering, collections::BinaryHeap};

use super::Sum;

/// What `levels_of` finds for the sum that is `asked`, which is `exact` rounded; where it is to be
/// kept as near as the levels allow, for the nearest to `exact` in the range that they can have, of
/// two the smaller. What is farther is another kernel's: weights that are clipped would draw all
/// others after them.
pub(super) fn as_near_as_can_be<T>(
    sum: Sum,
    (exact, asked): (f64, f64),
    (low, high): (f64, f64),
    mut levels_of: impl FnMut(f64) -> Option<T>,
) -> Option<T> {
    /// Sums on either side that are tried.
    const TRIED: i32 = 64;
    if sum != Sum::Kept {
        return levels_of(asked);
    }
    let inward = if asked > 0.0 { -1.0 } else { 1.0 };
    let nearer = if exact == asked {
        inward
    } else {
        (exact - asked).signum()
    };
    let beside = (1..=TRIED).map(f64::from);
    std::iter::once(asked)
        .chain(beside.flat_map(|off| [asked + nearer * off, asked - nearer * off]))
        .filter(|sum| (low..=high).contains(sum))
        .find_map(levels_of)
}

/// The levels, one of `all` for each value, whose sum is `sum` and that are nearest to the
/// values; `None` when there are none.
pub(super) fn nearest(values: &[f64], all: &[i64], sum: i64) -> Option<Vec<f64>> {
    let (least, most) = (*all.first()?, *all.last()?);
    let n = values.len() as i64;
    let (low, high) = ((n * least).min(0), (n * most).max(0));
    if !(low..=high).contains(&sum) {
        return None;
    }
    let width = (high - low + 1) as usize;
    let place = |sum: i64| (sum - low) as usize;
    let mut cost = vec![f64::INFINITY; width];
    cost[place(0)] = 0.0;
    // The level chosen for each reachable sum, weight by weight, for tracing back.
    let mut taken: Vec<Vec<u16>> = Vec::with_capacity(values.len());
    for (i, value) in (1..).zip(values) {
        let mut next = vec![f64::INFINITY; width];
        let mut by = vec![0u16; width];
        let before = (((i - 1) * least).min(0), ((i - 1) * most).max(0));
        for (k, level) in all.iter().enumerate() {
            let more = (*level as f64 - value).powi(2);
            for from in before.0..=before.1 {
                let to = from + level;
                if !(low..=high).contains(&to) {
                    continue;
                }
                let total = cost[place(from)] + more;
                if total < next[place(to)] {
                    next[place(to)] = total;
                    by[place(to)] = k as u16;
                }
            }
        }
        cost = next;
        taken.push(by);
    }
    if cost[place(sum)].is_infinite() {
        return None;
    }
    let mut levels = vec![0.0; values.len()];
    let mut left = sum;
    for (level, by) in levels.iter_mut().zip(&taken).rev() {
        let chosen = all[usize::from(by[place(left)])];
        *level = chosen as f64;
        left -= chosen;
    }
    Some(levels)
}

/// Moves weights by single steps, each time the one with the least increase of squared error, until
/// they sum to `asked`.
///
/// The increase grows with each step of a weight (convexity), so the greedy choice is optimal. Many
/// steps are taken at once, up to a threshold below which every step is among the cheapest; the
/// last few go one by one.
pub(super) fn settle(
    values: &[f64],
    steps: &mut [f64],
    (low, high): (f64, f64),
    asked: f64,
) -> Option<()> {
    let missing = asked - steps.iter().sum::<f64>();
    let way = missing.signum();
    let mut left = missing.abs();
    let end = if way > 0.0 { high } else { low };
    let room = |step: f64| (way * (end - step)).max(0.0);
    if left > steps.iter().map(|step| room(*step)).sum::<f64>() {
        return None;
    }
    // How far a weight is ahead of its value: half of the increase by a step, less a half.
    let ahead = |i: usize, step: f64| way * (step - values[i]);
    let up_to =
        |level: f64, i: usize, step: f64| (level - ahead(i, step)).floor().clamp(0.0, room(step));
    let many = left > steps.len() as f64;
    if many {
        let places = || steps.iter().enumerate();
        let first = places()
            .map(|(i, s)| ahead(i, *s))
            .fold(f64::INFINITY, f64::min);
        let (mut under, mut over) = (first, first + left + 1.0);
        while over - under > 0.25 && f64::midpoint(under, over) > under {
            let level = f64::midpoint(under, over);
            let taken: f64 = places().map(|(i, s)| up_to(level, i, *s)).sum();
            if taken > left {
                over = level;
            } else {
                under = level;
            }
        }
        // A level lower, so that no step is taken that does not hurt less than those left.
        for (i, step) in steps.iter_mut().enumerate() {
            let taken = up_to(under - 1.0, i, *step);
            *step += way * taken;
            left -= taken;
        }
    }
    // Where steps are many, squares would lose what tells them apart; the order is the same.
    let hurt = |i: usize, step: f64| {
        if many {
            ahead(i, step)
        } else {
            (step + way - values[i]).powi(2) - (step - values[i]).powi(2)
        }
    };
    let mut next: BinaryHeap<Step> = (0..steps.len())
        .filter(|i| room(steps[*i]) >= 1.0)
        .map(|i| Step(hurt(i, steps[i]), i))
        .collect();
    for _ in 0..left as u64 {
        let Step(_, least) = next.pop()?;
        steps[least] += way;
        if room(steps[least]) >= 1.0 {
            next.push(Step(hurt(least, steps[least]), least));
        }
    }
    Some(())
}

/// What a step of a weight hurts; the greatest is what hurts least, the first weight of equals.
struct Step(f64, usize);

impl Ord for Step {
    fn cmp(&self, other: &Self) -> Ordering {
        (other.0.total_cmp(&self.0)).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Step {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Step {}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step after the other, as the words say it.
    fn one_by_one(values: &[f64], steps: &mut [f64], (low, high): (f64, f64), asked: f64) -> bool {
        let missing = asked - steps.iter().sum::<f64>();
        let way = missing.signum();
        (0..missing.abs() as u64).all(|_| {
            let hurt =
                |i: usize| (steps[i] + way - values[i]).powi(2) - (steps[i] - values[i]).powi(2);
            let room = |i: &usize| (low..=high).contains(&(steps[*i] + way));
            let least = (0..steps.len())
                .filter(room)
                .min_by(|a, b| hurt(*a).total_cmp(&hurt(*b)));
            least.map(|least| steps[least] += way).is_some()
        })
    }

    #[test]
    fn many_steps_at_once_are_the_steps_one_by_one() {
        let values: [f64; 7] = [0.3, -40.25, 12.5, 12.5, 99.0, -3.75, 0.0];
        for asked in -300_i32..300 {
            let asked = f64::from(asked);
            let mut fast: Vec<_> = values.iter().map(|v| v.round()).collect();
            let mut slow = fast.clone();
            let bounds = (-40.0, 99.0);
            let done = one_by_one(&values, &mut slow, bounds, asked);
            assert_eq!(settle(&values, &mut fast, bounds, asked).is_some(), done);
            if done {
                assert_eq!(fast, slow, "{asked}");
            }
        }
    }

    #[test]
    fn more_steps_than_there_is_time_for() {
        let end = 2f64.powi(47);
        let mut steps = [0.0; 3];
        settle(&[0.0; 3], &mut steps, (-end, end - 1.0), 3e13).unwrap();
        assert_eq!(steps, [1e13; 3]);
        assert!(settle(&[0.0; 3], &mut steps, (-end, end - 1.0), 1e16).is_none());
    }
}
