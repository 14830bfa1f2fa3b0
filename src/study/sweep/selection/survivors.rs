//! Who goes on: points by non-dominated rank, and within a rank by what they add to the
//! hypervolume.
//!
//! The hypervolume of some points is the area of all that one of them dominates, up to a corner
//! that is worse than every point (Zitzler & Thiele 1998). Points are ranked by fronts (Deb et al.,
//! NSGA-II, 2002): the first is what nothing dominates, the second what nothing dominates without
//! the first. Points that are equal add nothing to each other: of them one goes on before the rest.

use crate::{
    order::Order,
    study::front::{Cost, dominators},
};

/// The area that points dominate up to a corner; points beyond it count nothing.
#[must_use]
pub fn hypervolume(points: &[Cost], corner: Cost) -> f64 {
    let mut inside: Vec<Cost> = { points.iter() }
        .filter(|point| point.x < corner.x && point.y < corner.y)
        .copied()
        .collect();
    inside.order_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let (mut area, mut lowest) = (0.0, corner.y);
    for point in inside {
        if point.y < lowest {
            area += (corner.x - point.x) * (lowest - point.y);
            lowest = point.y;
        }
    }
    area
}

/// The numbers of `quota` points that go on, the best first.
#[must_use]
pub fn survivors(points: &[Cost], quota: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let at = |i: usize| points.get(i).copied().unwrap_or(Cost { x: 0.0, y: 0.0 });
    order.order_by(|a, b| {
        let (a, b) = (at(*a), at(*b));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
    });
    // Of equal ones the first.
    let (mut left, mut equal): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
    for i in order {
        let is_equal = left.last().is_some_and(|last| at(*last) == at(i));
        if is_equal { &mut equal } else { &mut left }.push(i);
    }
    let mut chosen = Vec::new();
    while chosen.len() < quota && !left.is_empty() {
        let costs: Vec<Cost> = left.iter().map(|i| at(*i)).collect();
        let by = dominators(&costs);
        let mut front = Vec::new();
        let mut rest = Vec::new();
        for (i, by) in left.iter().zip(by) {
            if by.is_none() { &mut front } else { &mut rest }.push(*i);
        }
        let mut adds: Vec<(f64, usize)> = Vec::new();
        for (k, i) in front.iter().enumerate() {
            // Its own part of the area: a rectangle between its neighbours on the front.
            let before = k.checked_sub(1).and_then(|k| front.get(k));
            let after = front.get(k + 1);
            let own = match (before, after) {
                (Some(before), Some(after)) => {
                    (at(*after).x - at(*i).x) * (at(*before).y - at(*i).y)
                }
                // The ends are the best that there is of one of both.
                _ => f64::INFINITY,
            };
            adds.push((own, *i));
        }
        adds.order_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        chosen.extend(adds.into_iter().map(|(_, i)| i));
        left = rest;
    }
    chosen.extend(equal);
    chosen.truncate(quota);
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Hash;

    fn cost(x: f64, y: f64) -> Cost {
        Cost { x, y }
    }

    /// Against counting the cells of a grid that are dominated.
    #[test]
    fn the_hypervolume_is_the_area_that_is_dominated() {
        for seed in 0..20 {
            let digit = |i: u64| (Hash::new(seed).with(i).uniform() * 12.0).floor();
            let points: Vec<Cost> = (0..8)
                .map(|i| cost(digit(2 * i), digit(2 * i + 1)))
                .collect();
            let mut cells = 0;
            for x in 0..10 {
                for y in 0..10 {
                    let is = |p: &Cost| p.x <= f64::from(x) && p.y <= f64::from(y);
                    cells += i32::from(points.iter().any(is));
                }
            }
            assert_eq!(hypervolume(&points, cost(10.0, 10.0)), f64::from(cells));
        }
        assert_eq!(hypervolume(&[], cost(1.0, 1.0)), 0.0);
    }

    #[test]
    fn the_front_goes_on_before_what_it_beats() {
        let points = [
            cost(3.0, 3.0), // beaten
            cost(1.0, 5.0),
            cost(5.0, 1.0),
            cost(2.0, 2.0),
            cost(2.0, 2.0), // the same
            cost(4.0, 1.9), // hardly adds
        ];
        assert_eq!(survivors(&points, 2), [1, 2]);
        assert_eq!(survivors(&points, 3), [1, 2, 3]);
        assert_eq!(survivors(&points, 4), [1, 2, 3, 5]);
        assert_eq!(survivors(&points, 9), [1, 2, 3, 5, 0, 4]);
    }
}
