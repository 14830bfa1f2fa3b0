//! Scaling by a constant: a single weight, its integer part by doubling, its fraction by halving.
//!
//! A bus cannot read a register twice, so a value to be doubled is held in two copies. One word
//! makes twice the value of such a pair, and adds the input where a digit asks for it; two words
//! make the next pair.

use crate::compile::intermediate::{
    linear_form::LinearForm,
    plan::{Plan, Store, Value, Word},
    signed_digit::planes,
};

/// A plan for one weight at the pixel itself that is larger than the input; `None` for other
/// goals.
pub(in crate::compile) fn scale(goal: &LinearForm, unit: i64) -> Option<Plan> {
    let at_home = goal.taps().iter().all(|tap| (tap.y, tap.x) == (0, 0));
    let one = unit.trailing_zeros() as usize;
    let planes = planes(goal);
    if !at_home || planes.len() < one + 2 {
        return None;
    }
    // Digits from the lowest: `Some(true)` for -1, `None` for 0.
    let digits: Vec<Option<bool>> = planes
        .iter()
        .map(|plane| plane.first().map(|(_, negative)| *negative))
        .collect();
    let (rest, whole) = digits.split_at(one);
    let mut scale = Scale::default();
    scale.minus = scale.store(false, vec![0], false);
    let rest = scale.fraction(rest);
    let goal = scale.whole(whole, rest);
    scale.plan.goals = vec![goal];
    Some(scale.plan)
}

#[derive(Default)]
struct Scale {
    plan: Plan,
    stores: usize,
    /// The negated input.
    minus: Value,
}

impl Scale {
    fn word(&mut self, store: Store, news: bool, values: Vec<Value>, halved: bool) {
        self.plan.words.push(Word {
            store,
            views: if news { vec![None] } else { vec![] },
            values,
            halved,
        });
    }

    fn store(&mut self, news: bool, values: Vec<Value>, halved: bool) -> Value {
        self.word(Store::Register, news, values, halved);
        self.stores += 1;
        self.stores
    }

    const fn input(&self, negative: bool) -> Value {
        if negative { self.minus } else { 0 }
    }

    /// Adds up the digits below one; the result is negated.
    fn fraction(&mut self, digits: &[Option<bool>]) -> Option<Value> {
        let first = digits.iter().position(Option::is_some)?;
        let later = digits[first + 1..].iter().flatten().count();
        // Every halving and every addition negates.
        let turns = digits.len() - first + later;
        let mut negated = turns.is_multiple_of(2);
        let mut value = self.input(digits[first]? != negated);
        for digit in &digits[first + 1..] {
            value = self.store(false, vec![value], true);
            negated = !negated;
            if let Some(negative) = digit {
                let input = self.input(*negative != negated);
                value = self.store(false, vec![value, input], false);
                negated = !negated;
            }
        }
        Some(self.store(false, vec![value], true))
    }

    /// Adds up the digits from one on, and the fraction `rest`.
    fn whole(&mut self, digits: &[Option<bool>], mut rest: Option<Value>) -> Value {
        let steps = digits.len() - 1;
        let mut negated = !steps.is_multiple_of(2);
        let first = digits[steps].unwrap_or(false) != negated;
        let mut one = self.input(first);
        // The other copy of the pair; it is in NEWS where it is not a value.
        let mut other = Some(self.store(false, vec![self.input(!first)], false));
        for (left, digit) in digits[..steps].iter().enumerate().rev() {
            let mut values = vec![one];
            values.extend(other);
            values.extend(digit.map(|negative| self.input(negative != negated)));
            if left == 0 {
                values.extend(rest.take());
            }
            let news = other.is_none();
            one = self.store(news, values.clone(), false);
            if left > 0 && news {
                other = Some(self.store(news, values, false));
            } else if left > 0 {
                self.word(Store::News(None), false, values, false);
                other = None;
            }
            negated = !negated;
        }
        one
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_all_digits() {
        let fine = 1 << 20;
        for unit in [1, 2, 16, 4096] {
            for weight in (2 * unit..300 * unit).step_by(unit as usize / 8 + 1) {
                for weight in [weight, -weight] {
                    let goal = LinearForm::unit(weight);
                    let plan = scale(&goal, unit).unwrap();
                    let trace = plan.trace(unit * fine).unwrap();
                    assert_eq!(trace.values[plan.goals[0]], goal.times(fine), "{weight}");
                }
            }
        }
    }
}
