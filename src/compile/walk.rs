//! A plan that always exists: the accumulator walks over the kernel and takes the input in,
//! digit by digit of the weights, from the smallest to the largest.

use super::{
    field::Field,
    plan::{Plan, Store, Value, Word},
};
use crate::isa::Direction;

/// Registers that a walk needs, the input's included.
pub(super) const LEAST: usize = 3;

/// A plan for one goal that keeps to so many registers; `None` with fewer than [`LEAST`].
pub(super) fn walk(goal: &Field, unit: i64, registers: usize) -> Option<Plan> {
    if registers < LEAST {
        return None;
    }
    let mut walk = Walk {
        plan: Plan::default(),
        next: 1,
        minus: None,
        place: At::Nowhere,
        negative: false,
        cursor: (0, 0),
    };
    if goal.is_zero() {
        let zero = walk.register(vec![], vec![], false);
        walk.plan.goals = vec![zero];
        return Some(walk.plan);
    }
    if registers > LEAST {
        walk.minus = Some(walk.register(vec![], vec![0], false));
    }
    let planes = planes(goal);
    let last = planes.len() - 1;
    for (exponent, mut plane) in planes.into_iter().enumerate() {
        if exponent > 0 && !matches!(walk.place, At::Nowhere) {
            walk.halve();
        }
        order(&mut plane, walk.cursor);
        walk.visit(&plane);
    }
    walk.home();
    let one = unit.trailing_zeros() as usize;
    for _ in last..one {
        walk.halve();
    }
    for _ in one..last {
        walk.double();
    }
    if walk.negative {
        walk.still();
    }
    let At::Register(value) = walk.place else {
        return None;
    };
    walk.plan.goals = vec![value];
    Some(walk.plan)
}

/// Places and signs by the digit's exponent.
pub(super) fn planes(goal: &Field) -> Vec<Vec<((i16, i16), bool)>> {
    let mut planes: Vec<Vec<_>> = Vec::new();
    for tap in goal.taps() {
        let (mut left, mut exponent) = (tap.weight, 0);
        while left != 0 {
            if left % 2 != 0 {
                // 1 or -1, so that the next digit is 0.
                let digit = 2 - left.rem_euclid(4);
                left -= digit;
                if planes.len() <= exponent {
                    planes.resize(exponent + 1, Vec::new());
                }
                planes[exponent].push(((tap.y, tap.x), digit < 0));
            }
            left /= 2;
            exponent += 1;
        }
    }
    planes
}

/// Row by row to and fro, from the corner that is nearest.
fn order(plane: &mut [((i16, i16), bool)], from: (i16, i16)) {
    let ordered = |down: bool, right: bool| {
        let mut list = plane.to_vec();
        let mut rows: Vec<i16> = list.iter().map(|((y, _), _)| *y).collect();
        rows.sort_unstable();
        rows.dedup();
        if !down {
            rows.reverse();
        }
        list.sort_by_key(|((y, x), _)| {
            let row = rows.iter().position(|row| row == y).unwrap_or(0);
            (row, if (row % 2 == 0) == right { *x } else { -*x })
        });
        list
    };
    let length = |list: &[((i16, i16), bool)]| {
        let mut at = from;
        let mut total = 0;
        for (place, _) in list {
            total += (place.0 - at.0).abs() + (place.1 - at.1).abs();
            at = *place;
        }
        total + at.0.abs() + at.1.abs()
    };
    let best = [(true, true), (true, false), (false, true), (false, false)]
        .map(|(down, right)| ordered(down, right))
        .into_iter()
        .min_by_key(|list| length(list));
    if let Some(best) = best {
        plane.copy_from_slice(&best);
    }
}

#[derive(Clone, Copy, Debug)]
enum At {
    Nowhere,
    News,
    Register(Value),
}

struct Walk {
    plan: Plan,
    next: Value,
    /// Minus the input.
    minus: Option<Value>,
    /// Where the accumulator is,
    place: At,
    /// whether it is minus what it stands for,
    negative: bool,
    /// and to which place what is added now will come.
    cursor: (i16, i16),
}

impl Walk {
    fn register(
        &mut self,
        views: Vec<Option<Direction>>,
        values: Vec<Value>,
        halved: bool,
    ) -> Value {
        self.plan.words.push(Word {
            store: Store::Register,
            views,
            values,
            halved,
        });
        self.next += 1;
        self.next - 1
    }

    /// The input with this sign, if it is held.
    fn input(&self, negative: bool) -> Option<Value> {
        if negative { self.minus } else { Some(0) }
    }

    /// The way to a place, as what is seen from there; the cursor moves.
    fn towards(&mut self, to: (i16, i16)) -> Option<Direction> {
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

    /// Takes the input in at each place.
    fn visit(&mut self, plane: &[((i16, i16), bool)]) {
        if let (At::Nowhere, Some((first, negative))) = (self.place, plane.first()) {
            self.cursor = *first;
            self.negative = self.input(*negative).is_none();
        }
        let mut rest = plane;
        while let Some((place, negative)) = rest.first().copied() {
            // In the word's sum everything has the accumulator's sign.
            let value = self.input(negative != self.negative);
            match self.place {
                At::Nowhere | At::Register(_) => {
                    let mut values = Vec::new();
                    if let At::Register(value) = self.place {
                        values.push(value);
                    }
                    let mut to = None;
                    if self.cursor == place {
                        if let Some(value) = value {
                            values.push(value);
                            rest = &rest[1..];
                            if let Some((next, _)) = rest.first() {
                                to = self.towards(*next);
                            }
                        }
                    } else {
                        to = self.towards(place);
                    }
                    self.news(to, values, false);
                }
                At::News => {
                    let from = self.towards(place);
                    let mut values = Vec::new();
                    if let (true, Some(value)) = (self.cursor == place, value) {
                        values.push(value);
                        rest = &rest[1..];
                    }
                    self.read(from, values, false);
                }
            }
        }
    }

    fn news(&mut self, from: Option<Direction>, values: Vec<Value>, halved: bool) {
        self.plan.words.push(Word {
            store: Store::News(from.map(Direction::opposite)),
            views: vec![],
            values,
            halved,
        });
        self.place = At::News;
        self.negative = !self.negative;
    }

    fn read(&mut self, from: Option<Direction>, values: Vec<Value>, halved: bool) {
        let value = self.register(vec![from], values, halved);
        self.place = At::Register(value);
        self.negative = !self.negative;
    }

    /// Home, and into a register.
    fn home(&mut self) {
        while self.cursor != (0, 0) || !matches!(self.place, At::Register(_)) {
            let direction = self.towards((0, 0));
            match self.place {
                At::Register(value) => self.news(direction, vec![value], false),
                At::News | At::Nowhere => self.read(direction, vec![], false),
            }
        }
    }

    fn in_register(&mut self) -> Value {
        loop {
            match self.place {
                At::Register(value) => return value,
                At::News | At::Nowhere => self.read(None, vec![], false),
            }
        }
    }

    fn halve(&mut self) {
        let value = self.in_register();
        let half = self.register(vec![], vec![value], true);
        self.place = At::Register(half);
        self.negative = !self.negative;
    }

    fn double(&mut self) {
        let value = self.in_register();
        let other = self.register(vec![], vec![value], false);
        self.news(None, vec![value], false);
        self.read(None, vec![other], false);
        // Both parts were negated once, their sum again.
    }

    /// The other sign.
    fn still(&mut self) {
        let value = self.in_register();
        let other = self.register(vec![], vec![value], false);
        self.place = At::Register(other);
        self.negative = !self.negative;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::field::tests::fields;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_walk_makes_what_is_asked(goal in fields(5, 300), exponent in 0u32..9, registers in 3usize..6) {
            let unit = 1i64 << exponent;
            let plan = walk(&goal, unit, registers).unwrap();
            // The halves on the way need finer units.
            let fine = 1 << 20;
            let trace = plan.trace(unit * fine).unwrap();
            prop_assert_eq!(&trace.values[plan.goals[0]], &goal.times(fine));
        }
    }
}
