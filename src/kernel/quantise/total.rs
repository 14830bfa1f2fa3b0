//! Levels with a given sum: the nearest of all.
//!
//! Where the levels are whole numbers without a gap, by steps; otherwise by dynamic
//! programming over the sums that the first few weights can have.

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
    // Which level led to each sum, weight by weight.
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

/// Moves weights by a step, each time the one that it hurts least, until they sum to `asked`.
///
/// What a step costs grows with each step that a weight has taken, so no other choice of
/// steps from here is nearer.
pub(super) fn settle(
    values: &[f64],
    steps: &mut [f64],
    (low, high): (f64, f64),
    asked: f64,
) -> Option<()> {
    let missing = asked - steps.iter().sum::<f64>();
    let way = missing.signum();
    for _ in 0..missing.abs() as u64 {
        let hurt = |i: usize| (steps[i] + way - values[i]).powi(2) - (steps[i] - values[i]).powi(2);
        let room = |i: &usize| (low..=high).contains(&(steps[*i] + way));
        let least = (0..steps.len())
            .filter(room)
            .min_by(|a, b| hurt(*a).total_cmp(&hurt(*b)))?;
        steps[least] += way;
    }
    Some(())
}
