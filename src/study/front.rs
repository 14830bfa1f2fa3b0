//! Pareto fronts: what is not dominated in two costs.

use crate::order::Order;

/// Two costs of one thing; the smaller the better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// The one, finite.
    pub x: f64,
    /// The other, finite.
    pub y: f64,
}

impl Cost {
    /// At most as high in both, and lower in one.
    #[must_use]
    pub fn dominates(self, other: Self) -> bool {
        self.x <= other.x && self.y <= other.y && (self.x < other.x || self.y < other.y)
    }
}

/// For each cost, what dominates it: of those on the front that do, the one of the lowest `y`; none
/// for those on the front. Equal ones do not dominate each other.
#[must_use]
pub fn dominators(costs: &[Cost]) -> Vec<Option<usize>> {
    let mut order: Vec<usize> = (0..costs.len()).collect();
    let place = |i: &usize| costs.get(*i).map_or((0.0, 0.0), |cost| (cost.x, cost.y));
    order.order_by(|a, b| {
        let ((ax, ay), (bx, by)) = (place(a), place(b));
        ax.total_cmp(&bx).then(ay.total_cmp(&by))
    });
    let mut by = vec![None; costs.len()];
    // The lowest `y` of all that cost no more of `x`.
    let mut best: Option<(usize, Cost)> = None;
    for i in order {
        let Some(cost) = costs.get(i).copied() else {
            continue;
        };
        match best {
            Some((front, least)) if least.dominates(cost) => {
                if let Some(by) = by.get_mut(i) {
                    *by = Some(front);
                }
            }
            Some((_, least)) if least == cost => {}
            _ => best = Some((i, cost)),
        }
    }
    by
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against the definition, written out.
        #[test]
        fn fronts_are_those_of_the_definition(
            costs in proptest::collection::vec((0..9_u8, 0..9_u8), 0..40)
        ) {
            let costs: Vec<Cost> = costs
                .into_iter()
                .map(|(x, y)| Cost { x: x.into(), y: y.into() })
                .collect();
            let found = dominators(&costs);
            for (cost, by) in costs.iter().zip(&found) {
                let mut slow = costs.iter().filter(|other| other.dominates(*cost));
                prop_assert_eq!(by.is_none(), slow.next().is_none());
                if let Some(by) = by {
                    prop_assert!(costs[*by].dominates(*cost));
                    prop_assert_eq!(found[*by], None);
                    let lowest = costs.iter().enumerate().filter(|(i, other)| {
                        found[*i].is_none() && other.dominates(*cost)
                    });
                    let lowest = lowest.map(|(_, other)| other.y).fold(f64::INFINITY, f64::min);
                    prop_assert_eq!(costs[*by].y, lowest);
                }
            }
        }
    }
}
