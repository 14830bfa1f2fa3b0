//! A plan that always exists and is right up to the border: sums move only towards the pixel,
//! rows along rows, then all of them along columns, so that nothing passes a place off the array.

use super::{
    field::Field,
    plan::{Plan, Store, Value, Word},
    walk::planes,
};
use crate::isa::Direction;

/// Registers that a comb needs, the input's included.
pub(super) const LEAST: usize = 5;

/// A value, and whether it is minus what it stands for.
type Signed = (Value, bool);

/// A plan for one goal that keeps to so many registers; `None` with fewer than [`LEAST`].
pub(super) fn comb(goal: &Field, unit: i64, registers: usize) -> Option<Plan> {
    if registers < LEAST {
        return None;
    }
    let mut comb = Comb::default();
    if registers > LEAST {
        comb.minus = Some(comb.store(vec![], vec![0], false));
    }
    let planes = planes(goal);
    let count = planes.len();
    let mut total: Option<Signed> = None;
    for plane in planes {
        total = total.map(|total| comb.halved(total));
        let of = |y: i16| {
            let row = plane.iter().filter(move |((row, _), _)| *row == y);
            row.map(|((_, x), negative)| (*x, *negative))
                .collect::<Vec<_>>()
        };
        let far = plane.iter().map(|((y, _), _)| y.abs()).max().unwrap_or(0);
        for (direction, sign) in [(Direction::North, -1), (Direction::South, 1)] {
            let mut part = None;
            for y in (1..=far).rev() {
                part = comb.row(part, &of(sign * y));
                part = part.map(|part| comb.moved(part, direction, None));
            }
            if let Some(part) = part {
                total = Some(comb.sum(total, part));
            }
        }
        total = comb.row(total, &of(0));
    }
    let Some(mut total) = total else {
        let zero = comb.store(vec![], vec![], false);
        comb.plan.goals = vec![zero];
        return Some(comb.plan);
    };
    let one = unit.trailing_zeros() as usize + 1;
    for _ in count..one {
        total = comb.halved(total);
    }
    for _ in one..count {
        let other = (comb.store(vec![], vec![total.0], false), !total.1);
        comb.news(None, vec![total.0]);
        total = (comb.store(vec![None], vec![other.0], false), total.1);
    }
    if total.1 {
        total = (comb.store(vec![], vec![total.0], false), false);
    }
    comb.plan.goals = vec![total.0];
    Some(comb.plan)
}

#[derive(Default)]
struct Comb {
    plan: Plan,
    stores: usize,
    /// Minus the input.
    minus: Option<Value>,
}

impl Comb {
    fn store(&mut self, views: Vec<Option<Direction>>, values: Vec<Value>, halved: bool) -> Value {
        self.plan.words.push(Word {
            store: Store::Register,
            views,
            values,
            halved,
        });
        self.stores += 1;
        self.stores
    }

    fn news(&mut self, from: Option<Direction>, values: Vec<Value>) {
        self.plan.words.push(Word {
            store: Store::News(from.map(Direction::opposite)),
            views: vec![],
            values,
            halved: false,
        });
    }

    fn halved(&mut self, (value, negative): Signed) -> Signed {
        (self.store(vec![], vec![value], true), !negative)
    }

    /// The input or minus the input, as it is held.
    fn input(&self, negative: bool) -> Signed {
        match (negative, self.minus) {
            (false, _) => (0, false),
            (true, Some(minus)) => (minus, false),
            (true, None) => (0, true),
        }
    }

    fn sum(&mut self, a: Option<Signed>, b: Signed) -> Signed {
        let Some(mut a) = a else { return b };
        if a.1 != b.1 {
            a = (self.store(vec![], vec![a.0], false), b.1);
        }
        (self.store(vec![], vec![a.0, b.0], false), !b.1)
    }

    /// What is seen in this direction, and the input besides.
    fn moved(&mut self, a: Signed, direction: Direction, tap: Option<bool>) -> Signed {
        self.news(Some(direction), vec![a.0]);
        let mut values = Vec::new();
        let mut left = tap;
        if let Some(negative) = tap {
            // In the sum, what NEWS holds has the other sign by now.
            let input = if negative == a.1 { self.minus } else { Some(0) };
            if let Some(input) = input {
                values.push(input);
                left = None;
            }
        }
        let seen = (self.store(vec![None], values, false), a.1);
        match left {
            None => seen,
            Some(negative) => {
                let input = self.input(negative);
                self.sum(Some(seen), input)
            }
        }
    }

    /// A row's sum, to a sum that lies in this row already.
    fn row(&mut self, to: Option<Signed>, taps: &[(i16, bool)]) -> Option<Signed> {
        let mut to = to;
        for (direction, sign) in [(Direction::West, -1), (Direction::East, 1)] {
            let at = |x: i16| taps.iter().find(|tap| tap.0 == sign * x).map(|tap| tap.1);
            let far = taps.iter().map(|tap| tap.0 * sign).max().unwrap_or(0);
            let mut part = None;
            for x in (1..=far).rev() {
                part = match (part, at(x)) {
                    (None, Some(negative)) => Some(self.input(negative)),
                    (part, _) => part,
                };
                let next = if x > 1 { at(x - 1) } else { None };
                part = part.map(|part| self.moved(part, direction, next));
            }
            if let Some(part) = part {
                to = Some(self.sum(to, part));
            }
        }
        if let Some((_, negative)) = taps.iter().find(|tap| tap.0 == 0) {
            let input = self.input(*negative);
            to = Some(self.sum(to, input));
        }
        to
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::field::tests::fields;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_comb_makes_what_is_asked_up_to_the_border(goal in fields(5, 300), exponent in 0u32..9, registers in 5usize..7) {
            let unit = 1i64 << exponent;
            let plan = comb(&goal, unit, registers).unwrap();
            let fine = 1 << 20;
            let trace = plan.trace(unit * fine).unwrap();
            prop_assert!(trace.border);
            prop_assert_eq!(&trace.values[plan.goals[0]], &goal.times(fine));
        }
    }
}
