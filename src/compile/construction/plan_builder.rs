//! The plan builder of `walk`, `border_safe` and `tour`: running sums, and the multiples of the input that
//! are added to them.

use crate::{
    compile::intermediate::{
        plan::{Plan, SOURCES, Store, Value, Word},
        signed_digit::Digit,
    },
    isa::Direction,
};

/// A running sum in a register, and whether it holds the negated sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sum {
    pub(super) value: Value,
    pub(super) negative: bool,
}

impl Sum {
    /// A sum after a store, which negates: `before` is the sign before it.
    pub(super) const fn stored(value: Value, before: bool) -> Self {
        Self {
            value,
            negative: !before,
        }
    }
}

/// The most exponents of digits that are added at a time.
const MOST_EXPONENTS: usize = 6;

/// A plan under construction: the words so far, and the multiples of the input that are held.
#[derive(Clone, Debug)]
pub(super) struct PlanBuilder {
    pub(super) plan: Plan,
    /// The input and its halves. Every other one holds the negated value, unless `steady`.
    held: Vec<Value>,
    /// Whether held values carry no transfer error, since each was stored twice.
    steady: bool,
    /// The negated input.
    minus: Option<Value>,
    /// Values in registers so far.
    values: usize,
}

impl PlanBuilder {
    /// An empty plan. With `minus`, the negated input is held too; with `steady`, halves are stored
    /// twice so that transfer errors cancel.
    pub(super) fn new(minus: bool, steady: bool) -> Self {
        let mut builder = Self {
            plan: Plan::default(),
            held: vec![0],
            steady,
            minus: None,
            values: 1,
        };
        if minus {
            let mut values = vec![0];
            if steady {
                // One transfer error, which the store of minus the input cancels.
                values.push(builder.register(vec![], vec![], false));
            }
            builder.minus = Some(builder.register(vec![], values, false));
        }
        builder
    }

    /// The plans that `one` makes with each number of exponents held at a time, from each empty plan,
    /// and of both kinds that it has.
    pub(super) fn variants(one: impl Fn(usize, Self, bool) -> Plan) -> Vec<Plan> {
        let mut plans = Vec::new();
        for held in 1..=MOST_EXPONENTS {
            for choice in 0..8 {
                let [minus, other, steady] = [1, 2, 4].map(|bit| choice & bit != 0);
                plans.push(one(held, Self::new(minus, steady), other));
            }
        }
        plans
    }

    /// Adds a word that stores in a register.
    pub(super) fn register(
        &mut self,
        views: Vec<Option<Direction>>,
        values: Vec<Value>,
        halved: bool,
    ) -> Value {
        self.plan.words.push(Word {
            views,
            ..Word::register(values, halved)
        });
        self.values += 1;
        self.values - 1
    }

    /// Adds a word that stores in NEWS; seen from the pixel of the sum, that NEWS cell lies `from`.
    pub(super) fn news(&mut self, from: Option<Direction>, values: Vec<Value>) {
        self.plan.words.push(Word {
            store: Store::News(from.map(Direction::opposite)),
            views: vec![],
            values,
            halved: false,
        });
    }

    /// Holds the input halved up to `halved` times.
    pub(super) fn hold(&mut self, halved: usize) {
        while let (true, Some(last)) = (self.held.len() <= halved, self.held.last().copied()) {
            let mut half = self.register(vec![], vec![last], true);
            if self.steady {
                half = self.register(vec![], vec![half], false);
            }
            self.held.push(half);
        }
    }

    /// Takes those digits out of `pending` that can be added to a sum whose sign is `negative`, at
    /// most `room`.
    pub(super) fn take(&self, pending: &mut Vec<Digit>, negative: bool, room: usize) -> Vec<Value> {
        let mut values = Vec::new();
        pending.retain(|digit| {
            let minus = digit.negative != negative;
            let turned = !self.steady && digit.halved % 2 == 1;
            let held = if minus == turned {
                self.held.get(digit.halved).copied()
            } else {
                self.minus.filter(|_| digit.halved == 0)
            };
            match held {
                Some(value) if values.len() < room => {
                    values.push(value);
                    false
                }
                Some(_) | None => true,
            }
        });
        values
    }

    /// Adds all pending digits at the place where the sum is.
    pub(super) fn add_all(&mut self, mut sum: Sum, pending: &mut Vec<Digit>) -> Sum {
        while !pending.is_empty() {
            let mut values = vec![sum.value];
            values.extend(self.take(pending, sum.negative, SOURCES - 1));
            sum = Sum::stored(self.register(vec![], values, false), sum.negative);
        }
        sum
    }

    /// The same sum with the other sign.
    pub(super) fn negated(&mut self, sum: Sum) -> Sum {
        Sum::stored(self.register(vec![], vec![sum.value], false), sum.negative)
    }

    /// Half of the sum.
    pub(super) fn halved(&mut self, sum: Sum) -> Sum {
        Sum::stored(self.register(vec![], vec![sum.value], true), sum.negative)
    }

    /// The sum times 2^`times`: of two copies one word makes their sum, two words make two copies.
    pub(super) fn doubled(&mut self, sum: Sum, times: usize) -> Sum {
        if times == 0 {
            return sum;
        }
        let mut one = Sum::stored(self.register(vec![], vec![sum.value], false), sum.negative);
        // The other copy; it is in NEWS where it is not a value.
        let mut other: Option<Value> = None;
        self.news(None, vec![sum.value]);
        for left in (0..times).rev() {
            let mut values = vec![one.value];
            values.extend(other);
            let views = if other.is_none() { vec![None] } else { vec![] };
            let copy = self.register(views.clone(), values.clone(), false);
            one = Sum::stored(copy, one.negative);
            if left > 0 && other.is_none() {
                other = Some(self.register(views, values, false));
            } else if left > 0 {
                self.news(None, values);
                other = None;
            }
        }
        one
    }

    /// The finished plan. The goal counts 2^`up` of the sum, or 2^-`down`.
    pub(super) fn finished(mut self, mut sum: Sum, (up, down): (usize, usize)) -> Plan {
        for _ in 0..down {
            sum = self.halved(sum);
        }
        if self.held.len() == 1 && self.minus.is_none() {
            // Doubling step by step takes a word more for each, and a register less.
            for _ in 0..up {
                sum = self.doubled(sum, 1);
            }
        } else {
            sum = self.doubled(sum, up);
        }
        if sum.negative {
            sum = self.negated(sum);
        }
        self.plan.goals = vec![sum.value];
        self.plan
    }

    /// The plan of a kernel of zeros.
    pub(super) fn zero(mut self) -> Plan {
        let zero = self.register(vec![], vec![], false);
        self.plan.goals = vec![zero];
        self.plan
    }
}
