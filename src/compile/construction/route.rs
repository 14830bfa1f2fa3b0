//! The route of a walk over the places of a kernel: a travelling salesman problem, solved by 2-opt
//! from several start tours.

use std::{cell::RefCell, collections::BTreeMap};

use crate::{compile::intermediate::signed_digit::Place, order::Order};

/// Routes that were found, each once: walks that differ in their signs alone take the same.
#[derive(Default)]
pub(super) struct Routes(RefCell<BTreeMap<Asked, Vec<Place>>>);

/// The places, and where the walk is that comes to them.
type Asked = (Vec<Place>, Option<Place>);

impl Routes {
    /// An order in which to visit `visits`, starting at `from` if the walk has begun, and ending at
    /// the pixel: the best of boustrophedon lines and spirals, improved by 2-opt.
    pub(super) fn ordered<T: Clone>(
        &self,
        visits: &[(Place, T)],
        from: Option<Place>,
    ) -> Vec<(Place, T)> {
        let places: Vec<Place> = visits.iter().map(|(place, _)| *place).collect();
        let mut known = self.0.borrow_mut();
        let best = known
            .entry((places, from))
            .or_insert_with_key(|(places, from)| shortest(places, *from));
        let visit = |place: &Place| visits.iter().find(|(known, _)| known == place).cloned();
        best.iter().filter_map(visit).collect()
    }
}

fn shortest(places: &[Place], from: Option<Place>) -> Vec<Place> {
    start_tours(places)
        .into_iter()
        .map(|route| improved(route, from))
        .min_by_key(|route| length(route, from))
        .unwrap_or_else(|| places.to_vec())
}

/// The distance between two places, in words: two words move by two pixels at most.
fn distance(a: Place, b: Place) -> u32 {
    let apart = a.0.abs_diff(b.0) + a.1.abs_diff(b.1);
    2 * u32::from(apart).div_ceil(2)
}

fn length(route: &[Place], from: Option<Place>) -> u32 {
    let mut total = 0;
    let mut at = from;
    for &place in route.iter().chain([&(0, 0)]) {
        total += at.map_or(0, |at| distance(at, place));
        at = Some(place);
    }
    total
}

fn start_tours(places: &[Place]) -> Vec<Vec<Place>> {
    let mut all = Vec::new();
    for flips in 0..8 {
        let turned = |(y, x): Place| {
            let (y, x) = if flips & 1 == 0 { (y, x) } else { (x, y) };
            let y = if flips & 2 == 0 { y } else { -y };
            (y, if flips & 4 == 0 { x } else { -x })
        };
        let mut lines = places.to_vec();
        lines.order_by_key(|place| {
            let (y, x) = turned(*place);
            (y, if y.rem_euclid(2) == 0 { x } else { -x })
        });
        all.push(lines);
        let mut spiral = places.to_vec();
        spiral.order_by_key(|place| {
            let (y, x) = turned(*place);
            let ring = y.abs().max(x.abs());
            // Continue around the next ring, beginning beside the end of the ring outside it.
            let side = if y == -ring && x < ring {
                x + ring
            } else if x == ring && y < ring {
                3 * ring + y
            } else if y == ring && x > -ring {
                5 * ring - x
            } else {
                7 * ring - y
            };
            (-ring, side)
        });
        all.push(spiral);
    }
    all
}

/// 2-opt: reverses parts of the tour as long as that shortens it.
fn improved(mut route: Vec<Place>, from: Option<Place>) -> Vec<Place> {
    let end = (0, 0);
    loop {
        let mut better = false;
        for i in 0..route.len() {
            for j in i + 1..route.len() {
                let before = if i == 0 { from } else { Some(route[i - 1]) };
                let after = route.get(j + 1).copied().unwrap_or(end);
                let way = |first: Place, last: Place| {
                    before.map_or(0, |before| distance(before, first)) + distance(last, after)
                };
                if way(route[j], route[i]) < way(route[i], route[j]) {
                    route[i..=j].reverse();
                    better = true;
                }
            }
        }
        if !better {
            return route;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_square_is_visited_without_a_detour() {
        let places = (-2..=2).flat_map(|y| (-2..=2).map(move |x| ((y, x), ())));
        let visits: Vec<_> = places.collect();
        let routes = Routes::default();
        let found: Vec<Place> = { routes.ordered(&visits, None).into_iter() }
            .map(|(place, ())| place)
            .collect();
        assert_eq!(length(&found, None), 48);
    }
}
