//! The points that are still in a search, and their order.
//!
//! A rung ranks the points that it tries, and leaves out only what it has ranked. A point of which
//! nothing came on a part of its scene is not known to be bad: it goes on, behind those that are
//! ranked, and is ranked where a later part shows more. Those that no rung can rank stand in an order
//! that a hash gives, since that of the grid says nothing; the first of them are computed where too
//! few are ranked.

use std::collections::{HashMap, HashSet};

use crate::{order::Order, rng::Hash, study::sweep::measurement::run::Failed};

/// Points by their numbers.
#[derive(Debug)]
pub(super) struct Contenders {
    /// The best first; until a rung was tried, as in the grid.
    points: Vec<usize>,
    /// How many of them, the first, were ranked by the last rung.
    ranked: usize,
    are_tried: bool,
    /// Why no rung has ranked a point.
    unranked: HashMap<usize, String>,
}

impl Contenders {
    /// All of so many points.
    pub fn new(all: usize) -> Self {
        Self {
            points: (0..all).collect(),
            ranked: 0,
            are_tried: false,
            unranked: HashMap::new(),
        }
    }

    pub fn points(&self) -> &[usize] {
        &self.points
    }

    /// Whether a rung has tried them.
    pub const fn are_tried(&self) -> bool {
        self.are_tried
    }

    /// Leaves so many of those that were ranked, and all others.
    pub fn cut_ranked(&mut self, quota: usize) {
        if quota < self.ranked {
            self.points.drain(quota..self.ranked);
            self.ranked = quota;
        }
    }

    /// What a rung has found of them, which are counted in its order: those that it ranked, the best
    /// first, and those that it could not rank, and why. Others go no further.
    pub fn put_in_order(&mut self, ranked: &[usize], unranked: Vec<(usize, String)>, hash: Hash) {
        let of = |i: &usize| self.points.get(*i).copied();
        let mut points: Vec<usize> = ranked.iter().filter_map(of).collect();
        let mut behind: Vec<(usize, String)> = { unranked.into_iter() }
            .filter_map(|(i, why)| Some((of(&i)?, why)))
            .collect();
        if !self.are_tried {
            behind.order_by_key(|(point, _)| hash.with(*point as u64).bits());
        }
        let known: HashSet<usize> = points.iter().copied().collect();
        self.unranked.retain(|point, _| !known.contains(point));
        self.ranked = points.len();
        for (point, why) in behind {
            // One that an earlier rung has ranked keeps its rank.
            if !self.are_tried || self.unranked.contains_key(&point) {
                self.unranked.insert(point, why);
            }
            points.push(point);
        }
        self.points = points;
        self.are_tried = true;
    }

    /// The first of them, or all if none was tried; and those that are left out although no rung has
    /// ranked them, and why.
    pub fn finish(mut self, quota: usize) -> (Vec<usize>, Vec<Failed>) {
        if !self.are_tried {
            return (self.points, Vec::new());
        }
        let over = self.points.split_off(quota.min(self.points.len()));
        let mut unranked: Vec<Failed> = { over.into_iter() }
            .filter_map(|point| {
                let reason = self.unranked.remove(&point)?;
                Some(Failed { point, reason })
            })
            .collect();
        unranked.order_by_key(|failed| failed.point);
        (self.points, unranked)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn why(points: &[usize]) -> Vec<(usize, String)> {
        points.iter().map(|i| (*i, format!("why {i}"))).collect()
    }

    #[test]
    fn what_a_rung_cannot_rank_goes_on_behind_what_it_can() {
        let mut contenders = Contenders::new(8);
        contenders.cut_ranked(1);
        assert_eq!(contenders.points(), [0, 1, 2, 3, 4, 5, 6, 7]);
        // Point 6 is given up.
        contenders.put_in_order(&[5, 1, 4], why(&[0, 2, 3, 7]), Hash::new(0));
        assert_eq!(contenders.points()[..3], [5, 1, 4]);
        let behind = contenders.points()[3..].to_vec();
        assert_ne!(behind, [0, 2, 3, 7], "the first of the grid");
        contenders.cut_ranked(2);
        assert_eq!(contenders.points()[..2], [5, 1]);
        assert_eq!(contenders.points()[2..], behind);
        // Another part shows two of those that the first did not.
        contenders.put_in_order(&[5, 2], why(&[0, 1, 3, 4]), Hash::new(1));
        let order = [behind[3], behind[0], 5, 1, behind[1], behind[2]];
        assert_eq!(contenders.points(), order);
        let (left, unranked) = contenders.finish(3);
        assert_eq!(left, order[..3]);
        // Point 1 was ranked once.
        let points: HashSet<usize> = unranked.iter().map(|it| it.point).collect();
        assert_eq!(points, HashSet::from([behind[1], behind[2]]));
        assert!(
            unranked
                .iter()
                .all(|it| it.reason == "why 3" || it.reason == "why 4")
        );
    }

    #[test]
    fn what_nothing_has_tried_is_left_as_it_is() {
        let (left, unranked) = Contenders::new(5).finish(2);
        assert_eq!((left, unranked.len()), (vec![0, 1, 2, 3, 4], 0));
    }
}
