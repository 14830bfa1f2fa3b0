//! The draw: which tiles stand for the others.
//!
//! Each tile has a size: what goes on in it, and a floor, since noise and rare events are everywhere.
//! Tiles are put in order of their size, and the order is cut into strata of equal size, one for
//! each tile that can be afforded. One is drawn of each, all from one number (systematic sampling),
//! with a probability in proportion to its size. A tile that alone fills a stratum is
//! certain: it is drawn with probability 1, and stands for itself alone. So what moves most is
//! always run.

use crate::{order::Order, rng::Hash};

/// A tile of the draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn {
    /// Its number.
    pub tile: usize,
    /// With which probability it was drawn.
    pub probability: f64,
}

/// The part of the mean that every tile counts at least.
const FLOOR: f64 = 0.25;

/// Draws at most so many tiles. `activity` of each tile: below 0 where nothing can ever fire, which
/// is known and not drawn. `certain` are taken whatever they count.
#[must_use]
pub fn draw(activity: &[f64], certain: &[usize], count: usize, seed: u64) -> Vec<Drawn> {
    let may = |tile: &usize| activity.get(*tile).is_some_and(|a| *a >= 0.0);
    let mut tiles: Vec<usize> = (0..activity.len()).filter(may).collect();
    let total: f64 = tiles.iter().filter_map(|tile| activity.get(*tile)).sum();
    let mean = if total > 0.0 {
        total / tiles.len() as f64
    } else {
        1.0
    };
    let hash = |tile: usize| Hash::new(seed).with(tile as u64);
    let size = |tile: usize| activity.get(tile).copied().unwrap_or(0.0) + FLOOR * mean;
    // In order of size; equal ones in an order of chance.
    let key = |tile: &usize| (size(*tile), hash(*tile).bits());
    tiles.order_by(|a, b| {
        let ((a, x), (b, y)) = (key(a), key(b));
        b.total_cmp(&a).then(x.cmp(&y))
    });
    let mut drawn: Vec<Drawn> = Vec::new();
    let sure = |tile| Drawn {
        tile,
        probability: 1.0,
    };
    for tile in certain {
        if drawn.len() < count && may(tile) && !drawn.iter().any(|one| one.tile == *tile) {
            drawn.push(sure(*tile));
        }
    }
    tiles.retain(|tile| !drawn.iter().any(|one| one.tile == *tile));
    let mut left: f64 = tiles.iter().map(|tile| size(*tile)).sum();
    let mut first = 0;
    // Rounding is not to leave out one of all.
    let all = tiles.len() <= count - drawn.len();
    while let Some(tile) = tiles.get(first)
        && drawn.len() < count
        && (all || size(*tile) * (count - drawn.len()) as f64 >= left)
    {
        drawn.push(sure(*tile));
        left -= size(*tile);
        first += 1;
    }
    let strata = count - drawn.len();
    let rest = tiles.get(first..).unwrap_or_default();
    if strata == 0 || rest.is_empty() {
        return drawn;
    }
    let stratum = left / strata as f64;
    let mut next = Hash::new(seed).with(u64::MAX).uniform() * stratum;
    let mut before = 0.0;
    for tile in rest {
        let own = size(*tile);
        before += own;
        if next < before {
            next += stratum;
            drawn.push(Drawn {
                tile: *tile,
                probability: own / stratum,
            });
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over many seeds each tile comes as often as its probability says.
    #[test]
    fn tiles_come_as_often_as_they_should() {
        const SEEDS: u64 = 4000;
        let activity: Vec<f64> = (0..40)
            .map(|i| f64::from(i % 10) * if i == 39 { 20.0 } else { 1.0 })
            .collect();
        let mut came = [0u64; 40];
        let mut said = [0.0; 40];
        for seed in 0..SEEDS {
            for one in draw(&activity, &[3], 12, seed) {
                came[one.tile] += 1;
                said[one.tile] = one.probability;
            }
        }
        for tile in 0..40 {
            let part = came[tile] as f64 / SEEDS as f64;
            assert!(
                (part - said[tile]).abs() < 0.04,
                "{tile}: {part}, not {}",
                said[tile]
            );
            assert!(said[tile] > 0.05);
        }
        assert_eq!((said[3], said[39]), (1.0, 1.0));
    }

    #[test]
    fn what_cannot_fire_is_not_drawn() {
        let mut activity = vec![-1.0; 30];
        for tile in [4, 7, 20] {
            activity[tile] = 1.0;
        }
        let drawn = draw(&activity, &[0], 10, 1);
        let mut tiles: Vec<usize> = drawn.iter().map(|one| one.tile).collect();
        tiles.sort_unstable();
        assert_eq!(tiles, [4, 7, 20]);
        assert!(drawn.iter().all(|one| one.probability == 1.0));
        assert!(draw(&[], &[], 10, 1).is_empty() && draw(&activity, &[], 0, 1).is_empty());
    }

    /// Of tiles of one size, too, whose sums are rounded.
    #[test]
    fn a_sample_of_every_tile_is_certain() {
        for tiles in [30, 690, 1000] {
            let drawn = draw(&vec![0.1; tiles], &[7, 3], tiles, 0);
            assert_eq!(drawn.len(), tiles);
            assert!(drawn.iter().all(|one| one.probability == 1.0));
        }
    }

    #[test]
    fn as_many_are_drawn_as_asked_for() {
        for seed in 0..50 {
            let activity: Vec<f64> = (0..500)
                .map(|i| Hash::new(seed).with(i).uniform().powi(4))
                .collect();
            let drawn = draw(&activity, &[], 40, seed);
            assert!((39..=40).contains(&drawn.len()), "{}", drawn.len());
            let stands: f64 = drawn.iter().map(|one| 1.0 / one.probability).sum();
            assert!((stands / 500.0 - 1.0).abs() < 0.5, "{stands}");
        }
    }
}
