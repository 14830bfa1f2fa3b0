//! Walks, plans that always exist: a running sum is moved over the places of the kernel to the
//! pixel, and the input is added on the way, digit by digit of the weights.
//!
//! One word stores the sum into a NEWS cell, the next one reads it from there: each can move the
//! sum by one pixel. Where one move ends and the next begins, each of the two words can add held
//! multiples of the input, one with a positive sign, the other with a negative one. The input and
//! its halves are held, at a word each, so that one visit adds all digits of a weight. Digits below
//! those that are held are added first, on a walk of their own, and are halved with the sum.

use super::{
    plan_builder::{PlanBuilder, Sum},
    route::Routes,
};
use crate::{
    compile::intermediate::{
        linear_form::LinearForm,
        plan::{Plan, SOURCES, Value},
        signed_digit::{Place, Visits, groups, most_halved, scaling},
    },
    isa::Direction,
};

/// Registers that the narrowest walk needs, the input's included.
pub(in crate::compile) const FEWEST_REGISTERS: usize = 3;

/// Plans for one goal that differ in words and in registers.
pub(in crate::compile) fn walks(goal: &LinearForm, unit: i64) -> Vec<Plan> {
    let routes = Routes::default();
    PlanBuilder::variants(|held, builder, negative| {
        walk((goal, unit, &routes), held, builder, negative)
    })
}

/// A walk that adds `held` exponents at a time and begins with the given sign.
fn walk(
    (goal, unit, routes): (&LinearForm, i64, &Routes),
    held: usize,
    builder: PlanBuilder,
    negative: bool,
) -> Plan {
    let Some((groups, last)) = groups(goal, held) else {
        return PlanBuilder::new(false, false).zero();
    };
    let mut walk = Walk {
        builder,
        place: At::Nowhere,
        negative,
        cursor: (0, 0),
    };
    for visits in groups {
        walk.halve(held);
        walk.builder.hold(most_halved(&visits));
        let begun = !matches!(walk.place, At::Nowhere);
        walk.visit(&routes.ordered(&visits, begun.then_some(walk.cursor)));
    }
    let sum = walk.home();
    walk.builder.finished(sum, scaling(unit, last))
}

#[derive(Clone, Copy, Debug)]
enum At {
    Nowhere,
    News,
    Register(Value),
}

struct Walk {
    builder: PlanBuilder,
    /// The register or NEWS cell in which the sum is.
    place: At,
    /// Whether the negated sum is held.
    negative: bool,
    /// The place of the kernel to which a digit belongs if it is added now.
    cursor: Place,
}

impl Walk {
    /// The direction of a first step to a place, as seen from there; moves the cursor.
    fn towards(&mut self, to: Place) -> Option<Direction> {
        let (dy, dx) = (self.cursor.0 - to.0, self.cursor.1 - to.1);
        let direction = match (dy, dx) {
            (0, 0) => return None,
            (0, dx) if dx > 0 => Direction::East,
            (0, _) => Direction::West,
            (dy, _) if dy > 0 => Direction::South,
            _ => Direction::North,
        };
        let (y, x) = direction.step();
        self.cursor = (self.cursor.0 - y as i16, self.cursor.1 - x as i16);
        Some(direction)
    }

    /// Visits all places and adds their digits.
    fn visit(&mut self, visits: &Visits) {
        for (i, (place, digits)) in visits.iter().enumerate() {
            if matches!(self.place, At::Nowhere) {
                self.cursor = *place;
            }
            let mut pending = digits.clone();
            let next = visits.get(i + 1).map(|(place, _)| *place);
            loop {
                match self.place {
                    At::News => {
                        let from = self.towards(*place);
                        let mut values = Vec::new();
                        if self.cursor == *place {
                            values = self.builder.take(&mut pending, self.negative, SOURCES - 1);
                        }
                        self.read(from, values);
                    }
                    At::Register(sum) if self.cursor != *place => {
                        let to = self.towards(*place);
                        self.news(to, vec![sum]);
                    }
                    At::Register(_) if pending.is_empty() => break,
                    At::Nowhere | At::Register(_) => {
                        let mut values: Vec<Value> = match self.place {
                            At::Register(sum) => vec![sum],
                            At::Nowhere | At::News => vec![],
                        };
                        let room = SOURCES - values.len();
                        values.extend(self.builder.take(&mut pending, self.negative, room));
                        if let (true, Some(next)) = (pending.is_empty(), next) {
                            let to = self.towards(next);
                            self.news(to, values);
                            break;
                        }
                        let sum = self.builder.register(vec![], values, false);
                        self.stored(At::Register(sum));
                    }
                }
            }
        }
    }

    fn stored(&mut self, place: At) {
        self.place = place;
        self.negative = !self.negative;
    }

    fn news(&mut self, from: Option<Direction>, values: Vec<Value>) {
        self.builder.news(from, values);
        self.stored(At::News);
    }

    fn read(&mut self, from: Option<Direction>, values: Vec<Value>) {
        let sum = self.builder.register(vec![from], values, false);
        self.stored(At::Register(sum));
    }

    /// Moves the sum to the pixel itself, and into a register.
    fn home(&mut self) -> Sum {
        loop {
            match self.place {
                At::Register(value) if self.cursor == (0, 0) => {
                    return Sum {
                        value,
                        negative: self.negative,
                    };
                }
                At::Register(value) => {
                    let direction = self.towards((0, 0));
                    self.news(direction, vec![value]);
                }
                At::News | At::Nowhere => {
                    let direction = self.towards((0, 0));
                    self.read(direction, vec![]);
                }
            }
        }
    }

    /// Halves the running sum, if there is one.
    fn halve(&mut self, times: usize) {
        if matches!(self.place, At::News) {
            self.read(None, vec![]);
        }
        if let At::Register(value) = self.place {
            let mut sum = Sum {
                value,
                negative: self.negative,
            };
            for _ in 0..times {
                sum = self.builder.halved(sum);
            }
            self.place = At::Register(sum.value);
            self.negative = sum.negative;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::intermediate::random_form::forms;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn walks_make_what_is_asked(goal in forms(5, 300), exponent in 0u32..9) {
            let unit = 1i64 << exponent;
            // The halves on the way need finer units.
            let fine = 1 << 20;
            let plans = walks(&goal, unit);
            prop_assert!(plans.iter().any(|plan| plan.pressure(true) <= FEWEST_REGISTERS));
            for plan in plans {
                let trace = plan.trace(unit * fine).unwrap();
                prop_assert_eq!(&trace.values[plan.goals[0]], &goal.times(fine));
            }
        }
    }
}
