//! Algorithms that look at elements one after the other: for what a function says of them, or for
//! what they are.

use std::rc::Rc;

use super::algorithm::Range;
use crate::{
    config::Place,
    program::vendor::{
        interpreter::{
            machine::{Location, Machine},
            value::Value,
        },
        syntax::tree::{Function, last},
    },
};

/// Those that are worked out here whatever they are given.
pub(super) const ELEMENTWISE: [&str; 16] = [
    "remove",
    "remove_if",
    "unique",
    "replace",
    "generate",
    "lower_bound",
    "upper_bound",
    "binary_search",
    "count_if",
    "find_if",
    "find_if_not",
    "any_of",
    "all_of",
    "none_of",
    "inner_product",
    "equal",
];

/// Whether a function chooses among elements, or sums them.
pub(super) fn by_function(name: &str, values: &[Value]) -> bool {
    if !matches!(name, "min_element" | "max_element" | "accumulate") {
        return false;
    }
    let called = |it: &Value| matches!(it, Value::Lambda(_) | Value::Symbol(_));
    matches!(values, [Value::Pointer(..), Value::Pointer(..), rest @ ..]
        if matches!(rest, [by] | [_, by] if called(by)))
}

impl Machine<'_> {
    /// What an algorithm gives; nothing where it is another, or not all is known.
    pub(super) fn elementwise(
        &mut self,
        name: &str,
        values: &[Value],
        place: Place,
    ) -> Option<Value> {
        let ([from, to], rest) = values.split_first_chunk()?;
        let range = self.range(from, to)?;
        let function = values.last().and_then(|it| self.callable(it));
        self.passes(range.length);
        match (name, rest, function) {
            ("remove" | "remove_if" | "unique", _, function) => {
                self.closed_up(name, (&range, rest), function.as_ref(), place)
            }
            ("replace", [old, new], _) => {
                let all = self.values_of(&range);
                let old = old.number()?;
                let all = { all.into_iter() }
                    .map(|it| Some(if it.number()? == old { new.clone() } else { it }))
                    .collect::<Option<_>>()?;
                self.write(&range, all);
                Some(Value::Whole(0))
            }
            ("lower_bound" | "upper_bound" | "binary_search", [wanted], _) => {
                self.bound(name, &range, wanted)
            }
            ("count_if", [_], Some(function)) => {
                let hits = self.hits(&range, &function, place)?;
                Some(Value::Whole(hits.iter().filter(|it| **it).count() as i64))
            }
            ("find_if" | "find_if_not", [_], Some(function)) => {
                let found = self.first(&range, (&function, name == "find_if"), place)?;
                Some(range.pointer(found))
            }
            ("any_of" | "all_of" | "none_of", [_], Some(function)) => {
                let found = self.first(&range, (&function, name != "all_of"), place)?;
                Some(Value::flag((found < range.length) == (name == "any_of")))
            }
            ("min_element" | "max_element", [_], Some(function)) => {
                let mut best = 0;
                for i in 1..range.length {
                    let (before, behind) = if name == "min_element" {
                        (i, best)
                    } else {
                        (best, i)
                    };
                    let pair = [range.at(before), range.at(behind)];
                    if self.holds(&function, &pair, place)? {
                        best = i;
                    }
                }
                Some(range.pointer(best))
            }
            ("accumulate", [first, _], Some(function)) => {
                let (mut sum, kind) = (first.clone(), first.kind());
                for value in self.values_of(&range) {
                    let given = vec![sum.into(), value.into()];
                    sum = self
                        .enter_with(&function, given, None, place)
                        .converted(kind);
                }
                Some(sum)
            }
            ("inner_product", [other, first], None) => {
                let other = self.counted(other, range.length)?;
                let (mut sum, kind) = (first.clone(), first.kind());
                let pairs = self
                    .values_of(&range)
                    .into_iter()
                    .zip(self.values_of(&other));
                for (a, b) in pairs {
                    let product = Value::binary("*", &a, &b).ok()?;
                    sum = Value::binary("+", &sum, &product).ok()?.converted(kind);
                }
                sum.number().map(|_| sum)
            }
            ("equal", [other], None) => {
                let other = self.counted(other, range.length)?;
                let pairs = self
                    .values_of(&range)
                    .into_iter()
                    .zip(self.values_of(&other));
                let same = pairs.map(|(a, b)| Some(a.number()? == b.number()?));
                let same = same.collect::<Option<Vec<bool>>>()?;
                Some(Value::flag(!same.contains(&false)))
            }
            ("generate", [_], Some(function)) => {
                for i in 0..range.length {
                    let value = self.enter_with(&function, Vec::new(), None, place);
                    self.write_at(range.at(i), value);
                }
                Some(Value::Whole(0))
            }
            _ => None,
        }
    }

    /// The elements that stay move to the front; gives the end of them.
    fn closed_up(
        &mut self,
        name: &str,
        (range, rest): (&Range, &[Value]),
        function: Option<&Rc<Function>>,
        place: Place,
    ) -> Option<Value> {
        let all = self.values_of(range);
        let numbers = || all.iter().map(Value::number).collect::<Option<Vec<f64>>>();
        let goes: Vec<bool> = match (name, rest, function) {
            ("remove", [wanted], _) => {
                let wanted = wanted.number()?;
                numbers()?.iter().map(|it| *it == wanted).collect()
            }
            ("remove_if", [_], Some(function)) => self.hits(range, function, place)?,
            ("unique", [], _) => {
                let all = numbers()?;
                let again = |i: usize| i > 0 && all[i] == all[i - 1];
                (0..all.len()).map(again).collect()
            }
            _ => return None,
        };
        if { all.iter() }.any(|it| self.own_operator(it, &["operator="]).is_some()) {
            return None;
        }
        let pairs = all.into_iter().zip(goes);
        let kept: Vec<Value> = pairs.filter(|it| !it.1).map(|it| it.0).collect();
        let end = range.pointer(kept.len());
        self.write(range, kept);
        Some(end)
    }

    /// Where a number belongs among ordered ones.
    fn bound(&self, name: &str, range: &Range, wanted: &Value) -> Option<Value> {
        let all = self.values_of(range);
        let all: Vec<f64> = all.iter().map(Value::number).collect::<Option<_>>()?;
        let wanted = wanted.number()?;
        if name == "binary_search" {
            return Some(Value::flag(all.contains(&wanted)));
        }
        let before = |it: &f64| *it < wanted || name == "upper_bound" && *it == wanted;
        let at = all.iter().position(|it| !before(it));
        Some(range.pointer(at.unwrap_or(range.length)))
    }

    /// What a function says of each element; nothing where that is not known.
    fn hits(&mut self, range: &Range, function: &Rc<Function>, place: Place) -> Option<Vec<bool>> {
        let each = (0..range.length).map(|i| self.holds(function, &[range.at(i)], place));
        each.collect()
    }

    /// The first element of which a function says this, or the end: it is not called for those
    /// behind.
    fn first(
        &mut self,
        range: &Range,
        (function, wanted): (&Rc<Function>, bool),
        place: Place,
    ) -> Option<usize> {
        for i in 0..range.length {
            if self.holds(function, &[range.at(i)], place)? == wanted {
                return Some(i);
            }
        }
        Some(range.length)
    }

    fn holds(&mut self, function: &Rc<Function>, given: &[Location], place: Place) -> Option<bool> {
        if self.done() {
            return None;
        }
        let given = { given.iter() }
            .map(|it| self.argument_of(it.clone()))
            .collect();
        self.work(place);
        self.enter_with(function, given, None, place).truth().ok()
    }

    /// A function that is given to an algorithm.
    pub(super) fn callable(&self, it: &Value) -> Option<Rc<Function>> {
        match it {
            Value::Lambda(function) => Some(Rc::clone(function)),
            Value::Symbol(name) => match &self.functions.get(last(name))?[..] {
                [only] => Some(Rc::clone(only)),
                _ => None,
            },
            _ => None,
        }
    }

    /// `std::distance`, `std::next`, `std::prev`
    pub(super) fn iterated(&mut self, name: &str, values: &[Value], place: Place) -> Option<Value> {
        let one = Value::Whole(1);
        let (operator, a, b) = match (name, values) {
            ("distance", [from, to]) => ("-", to, from),
            ("next", [it]) => ("+", it, &one),
            ("next", [it, by]) => ("+", it, by),
            ("prev", [it]) => ("-", it, &one),
            ("prev", [it, by]) => ("-", it, by),
            _ => return None,
        };
        matches!(a, Value::Pointer(..))
            .then(|| self.operated(operator, (a.clone(), place), (b.clone(), place), place))
    }

    /// An array of what lies between two pointers.
    pub(super) fn copied_range(&self, from: &Value, to: &Value) -> Option<Value> {
        let range = self.range(from, to)?;
        Some(Value::List(self.values_of(&range)))
    }
}
