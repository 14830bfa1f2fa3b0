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

/// Two costs of one thing, each known to lie between two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// The least that they can be.
    pub low: Cost,
    /// The most.
    pub high: Cost,
}

impl From<Cost> for Between {
    fn from(cost: Cost) -> Self {
        Self {
            low: cost,
            high: cost,
        }
    }
}

/// For each cost, what dominates it: of those on the front that do, the one of the lowest `y`; none
/// for those on the front. Equal ones do not dominate each other.
#[must_use]
pub fn dominators(costs: &[Cost]) -> Vec<Option<usize>> {
    let all: Vec<Between> = costs.iter().copied().map(Between::from).collect();
    sure_dominators(&all)
}

/// The same of costs that lie between two numbers: what dominates one wherever both lie, by the
/// most that it can cost.
#[must_use]
pub fn sure_dominators(all: &[Between]) -> Vec<Option<usize>> {
    let order = |cost: fn(&Between) -> Cost| {
        let place = |i: usize| all.get(i).map_or((0.0, 0.0), |it| (cost(it).x, cost(it).y));
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.order_by(|a, b| {
            let ((ax, ay), (bx, by)) = (place(*a), place(*b));
            ax.total_cmp(&bx).then(ay.total_cmp(&by))
        });
        order
    };
    let mut by = vec![None; all.len()];
    let mut surely = order(|it| it.high).into_iter().peekable();
    // The lowest `y` of all that surely cost no more of `x`.
    let mut best: Option<(usize, Cost)> = None;
    for i in order(|it| it.low) {
        let Some(Between { low, .. }) = all.get(i).copied() else {
            continue;
        };
        while let Some(next) =
            surely.next_if(|next| all.get(*next).is_some_and(|it| it.high.x <= low.x))
        {
            let Some(Between { high, .. }) = all.get(next).copied() else {
                continue;
            };
            if best.is_none_or(|(_, least)| high.y < least.y) {
                best = Some((next, high));
            }
        }
        if let (Some((front, least)), Some(by)) = (best, by.get_mut(i)) {
            *by = least.dominates(low).then_some(front);
        }
    }
    by
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_may_cost_as_much_is_not_surely_better() {
        let cost = |x: f64, y: f64| Cost { x, y };
        let all = [
            Between::from(cost(1.0, 1.0)),
            // Its y may be that of the first, or less.
            Between {
                low: cost(2.0, 0.5),
                high: cost(2.0, 1.5),
            },
            // All of it is above the first, and above the most of the second.
            Between {
                low: cost(3.0, 1.6),
                high: cost(3.0, 2.0),
            },
            // Nobody knows its x.
            Between {
                low: cost(0.0, 0.1),
                high: cost(f64::INFINITY, 0.1),
            },
        ];
        assert_eq!(sure_dominators(&all), [None, None, Some(0), None]);
    }

    proptest! {
        /// Against the definition, written out.
        #[test]
        fn sure_fronts_are_those_of_the_definition(
            costs in proptest::collection::vec((0..9_u8, 0..9_u8, 0..3_u8, 0..3_u8), 0..40)
        ) {
            let all: Vec<Between> = costs
                .into_iter()
                .map(|(x, y, wide, high)| Between {
                    low: Cost { x: x.into(), y: y.into() },
                    high: Cost { x: (x + wide).into(), y: (y + high).into() },
                })
                .collect();
            let found = sure_dominators(&all);
            for (it, by) in all.iter().zip(&found) {
                let any = all.iter().any(|other| other.high.dominates(it.low));
                prop_assert_eq!(by.is_some(), any);
                if let Some(by) = by {
                    prop_assert!(all[*by].high.dominates(it.low));
                    prop_assert_eq!(found[*by], None);
                }
            }
        }

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
