//! Neighbours of a kernel, compiled and judged.

use std::sync::Arc;

use amacrine::plane::Plane;

use super::{
    chip::{Chip, OnChip},
    error::LevelsError,
    list::Levels,
    orbits::Orbits,
    project::Projected,
};

/// What a search found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The best kernel.
    pub kernel: Projected,
    /// What the chip makes of it.
    pub chip: Arc<OnChip>,
    /// Its score.
    pub score: f64,
    /// How many kernels were judged.
    pub judged: usize,
}

/// Looks among kernels that differ from `start` by one step of one level (of one orbit, and of a
/// second one where the sum is 0) for one that scores less; from the best of them again, until none
/// is better or `most` were judged. Those nearest to `latent` are judged first, one whose levels are less in
/// all and one of the others in turn; those that do not
/// compile are passed over. All are compiled for one threshold: [`Chip::compile`].
///
/// # Errors
/// When `start` cannot be compiled, or as [`Levels::project`].
pub fn search(
    levels: &Levels,
    (start, latent): (&Projected, &Plane<f64>),
    (chip, threshold): (&Chip, f64),
    most: usize,
    mut score: impl FnMut(&Projected, &OnChip) -> f64,
) -> Result<Found, LevelsError> {
    let made = chip.compile(std::slice::from_ref(start), threshold)?;
    let mut best = Found {
        score: score(start, &made),
        kernel: start.clone(),
        chip: made,
        judged: 1,
    };
    let mut seen = vec![start.levels.clone()];
    loop {
        // Half of what is left, so that a second round has some.
        let turn = (most.saturating_sub(best.judged)).div_ceil(2);
        let mut next: Option<Found> = None;
        let mut judged = 0;
        for kernel in neighbours(levels, &best.kernel, latent)? {
            if judged == turn {
                break;
            }
            if seen.contains(&kernel.levels) {
                continue;
            }
            seen.push(kernel.levels.clone());
            judged += 1;
            let Ok(made) = chip.compile(std::slice::from_ref(&kernel), threshold) else {
                continue;
            };
            let own = score(&kernel, &made);
            if own < next.as_ref().map_or(best.score, |one| one.score) {
                next = Some(Found {
                    kernel,
                    chip: made,
                    score: own,
                    judged: 0,
                });
            }
        }
        let all = best.judged + judged;
        match next {
            Some(found) => {
                best = Found {
                    judged: all,
                    ..found
                }
            }
            None => {
                return Ok(Found {
                    judged: all,
                    ..best
                });
            }
        }
    }
}

/// All neighbours, one of less and one of more in turn, the nearest to the latent kernel first.
fn neighbours(
    levels: &Levels,
    kernel: &Projected,
    latent: &Plane<f64>,
) -> Result<Vec<Projected>, LevelsError> {
    let shape = latent.dim();
    let orbits = Orbits::new(levels.symmetry, shape)?;
    let own = orbits.means(&kernel.levels);
    let mut all: Vec<i32> = levels.magnitudes.iter().flat_map(|l| [-l, *l]).collect();
    all.sort_unstable();
    all.dedup();
    // The next levels above and below each.
    let steps: Vec<(usize, i32)> = (0..own.len())
        .flat_map(|i| {
            let at = all.partition_point(|level| f64::from(*level) < own[i]);
            let near = [at.checked_sub(1), Some(at + 1)].into_iter().flatten();
            near.filter_map(|k| all.get(k))
                .map(move |level| (i, *level))
                .collect::<Vec<_>>()
        })
        .collect();
    let change = |(i, to): (usize, i32)| (f64::from(to) - own[i]) * orbits.all[i].len() as f64;
    let mut found = Vec::new();
    let mut take = |moves: &[(usize, i32)]| -> Result<(), LevelsError> {
        let mut values = own.clone();
        for (i, to) in moves {
            values[*i] = f64::from(*to);
        }
        if values.iter().any(|level| *level != 0.0) {
            let chosen = levels.chosen(&orbits.plane(&values, shape), latent)?;
            let off = (&(&chosen.levels * chosen.scale) - latent)
                .mapv(|v| v * v)
                .sum();
            found.push((off, chosen));
        }
        Ok(())
    };
    for (n, first) in steps.iter().enumerate() {
        if !levels.zero_sum || change(*first) == 0.0 {
            take(&[*first])?;
            continue;
        }
        for second in &steps[n + 1..] {
            if second.0 != first.0 && change(*first) + change(*second) == 0.0 {
                take(&[*first, *second])?;
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A larger level costs a kernel less than a smaller one, so that the nearest are nearly all larger.
    let size = |levels: &Plane<f64>| levels.iter().map(|level| level.abs()).sum::<f64>();
    let all = size(&kernel.levels);
    let (less, more): (Vec<_>, Vec<_>) = { found.into_iter().map(|(_, kernel)| kernel) }
        .partition(|kernel| size(&kernel.levels) < all);
    let turns = less.len().max(more.len());
    let (mut less, mut more) = (less.into_iter(), more.into_iter());
    Ok((0..turns)
        .flat_map(|_| [less.next(), more.next()])
        .flatten()
        .collect())
}
