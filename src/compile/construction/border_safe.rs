//! Border-safe plans: they always exist and are right up to the border.
//!
//! Sums move only towards the pixel, along rows first and then along columns, so that no partial
//! sum passes a place off the array. As on a [`walk`](super::walk), the held multiples of the input
//! are added at both ends of a move.

use super::plan_builder::{PlanBuilder, Sum};
use crate::{
    compile::intermediate::{
        linear_form::LinearForm,
        plan::{Plan, SOURCES, Value},
        signed_digit::{Digit, Visits, groups, most_halved, scaling},
    },
    isa::Direction,
};

/// Plans for one goal that differ in words and in registers.
pub(in crate::compile) fn border_safe_plans(goal: &LinearForm, unit: i64) -> Vec<Plan> {
    PlanBuilder::variants(|held, builder, columns_first| {
        plan(goal, unit, held, builder, columns_first)
    })
}

fn plan(
    goal: &LinearForm,
    unit: i64,
    held: usize,
    builder: PlanBuilder,
    columns_first: bool,
) -> Plan {
    let Some((groups, last)) = groups(goal, held) else {
        return PlanBuilder::new(false, false).zero();
    };
    let mut writer = BorderSafe {
        builder,
        columns_first,
    };
    let mut total: Option<Sum> = None;
    for visits in groups {
        for _ in 0..held {
            total = total.map(|total| writer.builder.halved(total));
        }
        writer.builder.hold(most_halved(&visits));
        total = writer.gathered(total, visits);
    }
    // A goal without a digit has no group; it is the plan of a kernel of zeros.
    let Some(total) = total else {
        return writer.builder.zero();
    };
    writer.builder.finished(total, scaling(unit, last))
}

#[derive(Clone)]
struct BorderSafe {
    builder: PlanBuilder,
    /// Whether columns are summed up before rows.
    columns_first: bool,
}

/// An arm: the digits to be added at each distance from the middle, from the far end inwards.
type Arm = Vec<(i16, Vec<Digit>)>;

impl BorderSafe {
    /// Adds all digits of a group to `total`, a sum that lies at the pixel already.
    fn gathered(&mut self, mut total: Option<Sum>, mut visits: Visits) -> Option<Sum> {
        if self.columns_first {
            for ((y, x), _) in &mut visits {
                std::mem::swap(y, x);
            }
        }
        let of = |y: i16| -> Vec<(i16, Vec<Digit>)> {
            let row = visits.iter().filter(|((row, _), _)| *row == y);
            row.map(|((_, x), digits)| (*x, digits.clone())).collect()
        };
        let far = visits.iter().map(|((y, _), _)| y.abs()).max().unwrap_or(0);
        for (direction, sign) in [(Direction::North, -1), (Direction::South, 1)] {
            let mut part = None;
            for y in (1..=far).rev() {
                part = self.row(part, of(sign * y));
                part = part.map(|part| {
                    self.news(direction, vec![part.value]);
                    let sum = self.builder.register(vec![None], vec![], false);
                    // Stored twice.
                    Sum { value: sum, ..part }
                });
            }
            if let Some(part) = part {
                total = Some(self.merged(total, part));
            }
        }
        self.row(total, of(0))
    }

    fn news(&mut self, direction: Direction, values: Vec<Value>) {
        let direction = match direction {
            other if !self.columns_first => other,
            Direction::North => Direction::West,
            Direction::South => Direction::East,
            Direction::West => Direction::North,
            Direction::East => Direction::South,
        };
        self.builder.news(Some(direction), values);
    }

    fn merged(&mut self, a: Option<Sum>, b: Sum) -> Sum {
        let Some(mut a) = a else { return b };
        if a.negative != b.negative {
            a = self.builder.negated(a);
        }
        let both = self.builder.register(vec![], vec![a.value, b.value], false);
        Sum::stored(both, a.negative)
    }

    /// Adds a row's digits to `to`, a sum that lies in the row's middle already.
    fn row(&mut self, to: Option<Sum>, row: Vec<(i16, Vec<Digit>)>) -> Option<Sum> {
        let mut sum = to;
        let (middle, sides): (Arm, Arm) = row.into_iter().partition(|(x, _)| *x == 0);
        let mut pending: Vec<Digit> = middle.into_iter().flat_map(|(_, digits)| digits).collect();
        for (direction, sign) in [(Direction::West, -1), (Direction::East, 1)] {
            let arm = sides.iter().filter(|(x, _)| x * sign > 0);
            let arm: Arm = arm.map(|(x, d)| (x.abs(), d.clone())).collect();
            if arm.is_empty() {
                continue;
            }
            // Begins with the sign that costs fewer words.
            let tries = [false, true].map(|negative| {
                let (mut writer, mut left) = (self.clone(), pending.clone());
                let sum = writer.arm(&arm, direction, negative, sum, &mut left);
                (writer, left, sum)
            });
            let best = tries.into_iter().min_by_key(|(writer, left, sum)| {
                let open = usize::from(!left.is_empty()) + usize::from(sum.negative);
                (2 * writer.builder.plan.words.len() + open, left.len())
            });
            if let Some((writer, left, found)) = best {
                (*self, pending, sum) = (writer, left, Some(found));
            }
        }
        match sum {
            Some(sum) => Some(self.builder.add_all(sum, &mut pending)),
            None if pending.is_empty() => None,
            None => {
                let values = self.builder.take(&mut pending, false, SOURCES);
                let sum = Sum::stored(self.builder.register(vec![], values, false), false);
                Some(self.builder.add_all(sum, &mut pending))
            }
        }
    }

    /// Sums up one side of a row, moves the sum to the middle, and adds what fits of the digits
    /// there; it begins with the given sign.
    fn arm(
        &mut self,
        arm: &Arm,
        direction: Direction,
        mut negative: bool,
        to: Option<Sum>,
        middle: &mut Vec<Digit>,
    ) -> Sum {
        let own = |at: i16| {
            let found = arm.iter().find(|(x, _)| *x == at);
            found.map_or(Vec::new(), |(_, digits)| digits.clone())
        };
        let far = arm.iter().map(|(x, _)| *x).max().unwrap_or(0);
        let mut to = to;
        let mut sum: Vec<Value> = Vec::new();
        let mut pending = own(far);
        for x in (1..=far).rev() {
            loop {
                let room = SOURCES - sum.len();
                sum.extend(self.builder.take(&mut pending, negative, room));
                negative = !negative;
                if pending.is_empty() {
                    break;
                }
                sum = vec![self.builder.register(vec![], sum, false)];
            }
            self.news(direction, sum);
            pending = if x > 1 {
                own(x - 1)
            } else {
                std::mem::take(middle)
            };
            let fits = |to: &mut Sum| x == 1 && to.negative == negative;
            let taken = to.take_if(fits).map(|to| to.value);
            let room = SOURCES - 1 - usize::from(taken.is_some());
            let mut values = self.builder.take(&mut pending, negative, room);
            values.extend(taken);
            sum = vec![self.builder.register(vec![None], values, false)];
            negative = !negative;
        }
        *middle = pending;
        let sum = Sum {
            value: sum.first().copied().unwrap_or(0),
            negative,
        };
        self.merged(to, sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::intermediate::random_form::forms;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn border_safe_plans_make_what_is_asked_up_to_the_border(goal in forms(5, 300), exponent in 0u32..9) {
            let unit = 1i64 << exponent;
            let fine = 1 << 20;
            for plan in border_safe_plans(&goal, unit) {
                let trace = plan.trace(unit * fine).unwrap();
                prop_assert!(trace.border);
                prop_assert_eq!(&trace.values[plan.goals[0]], &goal.times(fine));
            }
        }
    }
}
