//! Algorithms of the language's library, on arrays whose values are known.

use std::{rc::Rc, sync::Arc};

use super::elementwise::{ELEMENTWISE, by_function};
use crate::{
    config::Place,
    order::Order,
    program::vendor::{
        analysis::effects,
        interpreter::{
            call::{Argument, Named},
            lvalue::Reach,
            machine::{Location, Machine},
            operator::COMPARED,
            reason::Reason,
            shape,
            value::{Slot, Value},
        },
        syntax::tree::{Expr, ExprNode, Function, Kind, last},
    },
};

/// Some elements of an array, one behind the other.
#[derive(Clone, PartialEq)]
pub(super) struct Range {
    slot: Slot,
    array: Vec<usize>,
    first: usize,
    pub(super) length: usize,
}

impl Range {
    pub(super) fn at(&self, index: usize) -> Location {
        let path = [&self.array[..], &[self.first + index]].concat();
        (self.slot, path)
    }

    pub(super) fn pointer(&self, index: usize) -> Value {
        let (slot, path) = self.at(index);
        Value::Pointer(slot, path, "data".into())
    }
}

impl Machine<'_> {
    /// What an algorithm gives. What it could write is forgotten where its values, or what it does
    /// with them, are not known.
    pub(in crate::program::vendor) fn algorithm(
        &mut self,
        name: &str,
        given: &[Expr],
        place: Place,
    ) -> Value {
        if let Some(found) = self.added(name, given, place) {
            return found;
        }
        if let Some(found) = self.over_text(name, given, place) {
            return found;
        }
        let values: Vec<Value> = given.iter().map(|it| self.raw(it)).collect();
        for value in &values {
            self.keeps_register(name, value, place);
        }
        let found = match name {
            "memset" | "memcpy" | "memmove" => self.memory(name, &values),
            "for_each" | "transform" => self.applied(name, &values, place),
            "distance" | "next" | "prev" => self.iterated(name, &values, place),
            _ if by_function(name, &values) || ELEMENTWISE.contains(&name) => {
                self.elementwise(name, &values, place)
            }
            "sort" | "stable_sort" if given.get(2).is_some_and(falls) => {
                self.moved_about("fall", &values[..2])
            }
            "sort" | "stable_sort" if values.len() == 3 || self.has_less(&values) => {
                self.ordered(&values, place)
            }
            "sort" | "stable_sort" if values.len() == 2 && forwards(&values).is_some() => {
                self.moved_about("fall", &forwards(&values).unwrap_or_default())
            }
            _ if looks(name) => {
                // A sum is of the type of what it begins with.
                let kind = given.get(2).map_or(Kind::Any, |it| self.kind_of(it));
                self.looked(name, &values, kind)
            }
            _ => self.moved_about(name, &values),
        };
        found.unwrap_or_else(|| {
            // Iterators of a text do not say which it is.
            if moves(name) && matches!(values.first(), Some(Value::Text(_))) {
                self.text_places(name, place);
            }
            let mut may_write = values;
            may_write.retain(|it| !looks(name) || matches!(it, Value::Lambda(_)));
            self.written_by(name, &may_write);
            Value::Unknown(format!("`{name}`").into())
        })
    }

    /// `copy`, `copy_if` and `transform` to the end of an array: `std::back_inserter(array)`.
    fn added(&mut self, name: &str, given: &[Expr], place: Place) -> Option<Value> {
        let ([from, to, into], by) = (given.first_chunk()?, given.get(3));
        let ExprNode::Call(callee, arrays) = &into.node else {
            return None;
        };
        let (ExprNode::Name(inserter), [array]) = (&callee.node, &arrays[..]) else {
            return None;
        };
        let follows = matches!(
            (name, by.is_some(), given.len()),
            ("copy", false, 3) | ("copy_if" | "transform", true, 4)
        );
        if !follows || last(inserter) != "back_inserter" {
            return None;
        }
        let (from, to) = (self.value(from), self.value(to));
        let by = by.map(|it| self.value(it));
        let Reach::Location(slot, path) = self.reach(array) else {
            return None;
        };
        let mut all = Vec::new();
        if let (Some(range), Some(Value::List(_))) =
            (self.range(&from, &to), self.peek(slot, &path))
        {
            for i in 0..range.length {
                let (at, element) = range.at(i);
                let value = self.at(at, &element);
                let answer = match &by {
                    None => Value::flag(true),
                    Some(Value::Lambda(function)) => {
                        self.called_with(function, (at, element), place)
                    }
                    Some(_) => Value::Unknown(format!("what `{name}` calls").into()),
                };
                match (name, answer.truth()) {
                    ("transform", _) => all.push(answer),
                    (_, Ok(true)) => all.push(value),
                    (_, Ok(false)) => {}
                    (_, Err(_)) => return Some(self.inserts(last(inserter), array)),
                }
            }
            for value in all {
                let location = (slot, path.clone());
                if { self.list_method(location, "push_back", &[value]) }.is_none() {
                    self.inserts(last(inserter), array);
                }
            }
            return Some(Value::Unknown(format!("what `{name}` gives").into()));
        }
        None
    }

    /// What something adds to an array, or puts into it, is not known: nor is its length then.
    pub(in crate::program::vendor) fn inserts(&mut self, name: &str, into: &Expr) -> Value {
        let why: Reason = format!("what goes through `{name}`").into();
        if let Reach::Location(slot, path) = self.reach(into) {
            self.put(slot, &path, Value::Unknown(why.clone()));
        }
        Value::Unknown(why)
    }

    /// Forgets what something that is not known could write: the arrays that it is given a place
    /// of, and what the lambdas assign that it may call.
    pub(in crate::program::vendor) fn written_by(&mut self, name: &str, values: &[Value]) {
        let why = format!("what `{name}` does").into();
        for value in values {
            match value {
                Value::Pointer(slot, path, _) | Value::Back(slot, path, _) => {
                    let array = self.array_of(*slot, path);
                    self.forget(*slot, array.map_or(path, |it| it.0), &why);
                }
                Value::Lambda(function) => {
                    let place = function.place;
                    let called = Expr {
                        node: ExprNode::Lambda(Rc::clone(function)),
                        place,
                    };
                    let node = ExprNode::Call(Box::new(called), Vec::new());
                    effects::forget(self, &effects::statement(&Expr { node, place }), &why);
                }
                _ => {}
            }
        }
    }

    /// The elements from one pointer up to another.
    pub(super) fn range(&self, from: &Value, to: &Value) -> Option<Range> {
        let start = self.start(from)?;
        let end = self.start(to)?;
        let length = end.first.checked_sub(start.first)?;
        let same = start.slot == end.slot && start.array == end.array;
        (same && length <= start.length).then_some(Range { length, ..start })
    }

    /// So many elements from a pointer on.
    pub(super) fn counted(&self, from: &Value, count: usize) -> Option<Range> {
        let start = self.start(from)?;
        (count <= start.length).then_some(Range {
            length: count,
            ..start
        })
    }

    /// The elements from a pointer to the end of its array.
    fn start(&self, from: &Value) -> Option<Range> {
        let Value::Pointer(slot, path, _) = from else {
            return None;
        };
        let (array, first, length) = self.array_of(*slot, path)?;
        Some(Range {
            slot: *slot,
            length: length.checked_sub(first)?,
            array: array.to_vec(),
            first,
        })
    }

    pub(super) fn values_of(&self, range: &Range) -> Vec<Value> {
        let locations = (0..range.length).map(|i| range.at(i));
        locations.map(|(slot, path)| self.at(slot, &path)).collect()
    }

    pub(super) fn write(&mut self, range: &Range, values: Vec<Value>) {
        for (i, value) in values.into_iter().enumerate() {
            self.write_at(range.at(i), value);
        }
    }

    pub(super) fn write_at(&mut self, (slot, path): Location, value: Value) {
        let kind = self.kind_at(slot, &path);
        self.put(slot, &path, shape::deep(value, kind));
    }

    /// What moves or sets elements.
    fn moved_about(&mut self, name: &str, values: &[Value]) -> Option<Value> {
        let count = |value: &Value| usize::try_from(value.whole()?).ok();
        let (range, written) = match (name, values) {
            ("fill", [from, to, value]) => {
                let range = self.range(from, to)?;
                let all = vec![value.clone(); range.length];
                (range, all)
            }
            ("fill_n", [from, length, value]) => {
                let range = self.counted(from, count(length)?)?;
                let all = vec![value.clone(); range.length];
                (range, all)
            }
            ("iota", [from, to, value]) => {
                let range = self.range(from, to)?;
                let next = |i: usize| Value::binary("+", value, &Value::Whole(i as i64)).ok();
                let all = (0..range.length).map(next).collect::<Option<_>>()?;
                (range, all)
            }
            ("copy", [from, to, into]) => {
                let all = self.values_of(&self.range(from, to)?);
                (self.counted(into, all.len())?, all)
            }
            ("copy_n", [from, length, into]) => {
                let all = self.values_of(&self.counted(from, count(length)?)?);
                (self.counted(into, all.len())?, all)
            }
            ("iter_swap", [a, b]) => {
                let (a, b) = (self.counted(a, 1)?, self.counted(b, 1)?);
                let (one, other) = (self.values_of(&a), self.values_of(&b));
                self.write(&a, other);
                (b, one)
            }
            ("rotate", [from, middle, to]) => {
                let range = self.range(from, to)?;
                let before = self.range(from, middle)?.length;
                self.range(middle, to)?;
                let mut all = self.values_of(&range);
                all.rotate_left(before);
                (range, all)
            }
            ("reverse" | "fall" | "sort" | "stable_sort", [from, to]) => {
                let range = self.range(from, to)?;
                let mut all = self.values_of(&range);
                if name != "reverse" {
                    sorted(&mut all)?;
                }
                if matches!(name, "reverse" | "fall") {
                    all.reverse();
                }
                (range, all)
            }
            _ => return None,
        };
        let compares = matches!(name, "fall" | "sort" | "stable_sort");
        let mut own = { written.iter() }.map(|it| {
            self.own_operator(it, &["operator="])
                .or_else(|| self.own_operator(it, &COMPARED).filter(|_| compares))
        });
        if own.any(|it| it.is_some()) {
            return None;
        }
        let end = range.pointer(range.length);
        self.write(&range, written);
        Some(end)
    }

    /// What is found in elements, or made of them.
    fn looked(&self, name: &str, values: &[Value], kind: Kind) -> Option<Value> {
        let range = self.range(values.first()?, values.get(1)?)?;
        let all = self.values_of(&range);
        if let ("count" | "find", Some(wanted @ Value::Text(_))) = (name, values.get(2)) {
            let orders = all.iter().map(|it| it.order(wanted));
            let same: Vec<bool> = orders.map(|it| Some(it?.is_eq())).collect::<Option<_>>()?;
            let first = same.iter().position(|it| *it);
            return Some(match name {
                "find" => range.pointer(first.unwrap_or(range.length)),
                _ => Value::Whole(same.iter().filter(|it| **it).count() as i64),
            });
        }
        let numbers: Vec<f64> = all.iter().map(Value::number).collect::<Option<_>>()?;
        let wanted = values.get(2).map(Value::number);
        match (name, wanted) {
            ("min_element" | "max_element", None) => {
                let mut best = 0;
                for (i, number) in numbers.iter().enumerate() {
                    let better = if name == "min_element" {
                        *number < numbers[best]
                    } else {
                        *number > numbers[best]
                    };
                    if better {
                        best = i;
                    }
                }
                Some(range.pointer(best))
            }
            ("count", Some(Some(wanted))) => {
                let found = numbers.iter().filter(|it| **it == wanted);
                Some(Value::Whole(found.count() as i64))
            }
            ("find", Some(Some(wanted))) => {
                let found = numbers.iter().position(|it| *it == wanted);
                Some(range.pointer(found.unwrap_or(range.length)))
            }
            ("accumulate", Some(Some(_))) if values.len() == 3 => {
                let kind = match kind {
                    Kind::Any => values[2].kind(),
                    kind => kind,
                };
                let mut sum = values[2].clone();
                for value in &all {
                    sum = Value::binary("+", &sum, value).ok()?.converted(kind);
                }
                Some(sum)
            }
            _ => None,
        }
    }

    /// A function is called with every element.
    fn applied(&mut self, name: &str, values: &[Value], place: Place) -> Option<Value> {
        let (range, into, function) = match (name, values) {
            ("for_each", [from, to, Value::Lambda(function)]) => {
                (self.range(from, to)?, None, function)
            }
            ("transform", [from, to, into, Value::Lambda(function)]) => {
                let range = self.range(from, to)?;
                let into = self.counted(into, range.length)?;
                (range, Some(into), function)
            }
            _ => return None,
        };
        for i in 0..range.length {
            if self.done() {
                break;
            }
            let value = self.called_with(function, range.at(i), place);
            if let Some(into) = &into {
                self.write_at(into.at(i), value);
            }
        }
        Some(into.map_or(Value::Whole(0), |it| it.pointer(it.length)))
    }

    /// Whether elements are objects of a class that has a `<` of its own.
    fn has_less(&self, values: &[Value]) -> bool {
        let [from, to] = values else {
            return false;
        };
        let first = self.range(from, to).map(|it| it.at(0));
        let first = first.and_then(|(slot, path)| self.peek(slot, &path));
        let Some(value @ Value::Record(layout, _)) = first else {
            return false;
        };
        let own = self.own_operator(value, &["operator<"]);
        own.is_some_and(|it| it.0 == layout.name)
    }

    /// Elements are sorted by a function that says whether one comes before another, or by the `<` of
    /// their class.
    fn ordered(&mut self, values: &[Value], place: Place) -> Option<Value> {
        let ([from, to], by) = (values.first_chunk()?, values.get(2));
        let function = match by {
            None => None,
            Some(it) => Some(self.callable(it)?),
        };
        let range = self.range(from, to)?;
        let mut sorted: Vec<Value> = Vec::new();
        for value in self.values_of(&range) {
            // Behind all that it does not come before: equal ones stay in their order.
            let (mut low, mut high) = (0, sorted.len());
            while low < high {
                if self.done() {
                    return None;
                }
                let middle = usize::midpoint(low, high);
                let (one, other) = (value.clone().into(), sorted[middle].clone().into());
                let is_before = match &function {
                    Some(it) => self.enter_with(it, vec![one, other], None, place),
                    None => self.binary_operator("<", one, other, place),
                };
                is_before.number()?;
                if is_before.truth().ok()? {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            self.passes(sorted.len() - low);
            sorted.insert(low, value);
        }
        if { sorted.iter() }.any(|it| self.own_operator(it, &["operator="]).is_some()) {
            return None;
        }
        let end = range.pointer(range.length);
        self.write(&range, sorted);
        Some(end)
    }

    fn called_with(&mut self, function: &Rc<Function>, location: Location, place: Place) -> Value {
        self.work(place);
        let argument = self.argument_of(location);
        self.enter_with(function, vec![argument], None, place)
    }

    /// An element, as a function is given it.
    pub(super) fn argument_of(&self, location: Location) -> Argument {
        Argument {
            value: self.at(location.0, &location.1),
            kind: self.kind_at(location.0, &location.1),
            location: Some(location),
            named: Named::Unclear,
            lost: None,
        }
    }
}

/// The elements between two reverse iterators, from the first one on.
fn forwards(values: &[Value]) -> Option<Vec<Value>> {
    let forward = |it: &Value| match it {
        Value::Back(slot, path, name) => {
            Some(Value::Pointer(*slot, path.clone(), Arc::clone(name)))
        }
        _ => None,
    };
    values.iter().rev().map(forward).collect()
}

/// Whether an algorithm leaves the elements as they are.
fn looks(name: &str) -> bool {
    matches!(
        name,
        "min_element"
            | "max_element"
            | "count"
            | "find"
            | "accumulate"
            | "lower_bound"
            | "upper_bound"
            | "binary_search"
            | "count_if"
            | "find_if"
            | "find_if_not"
            | "any_of"
            | "all_of"
            | "none_of"
            | "inner_product"
            | "equal"
            | "distance"
            | "next"
            | "prev"
    )
}

/// Whether an algorithm changes the elements that it is given first.
fn moves(name: &str) -> bool {
    matches!(
        name,
        "sort"
            | "stable_sort"
            | "reverse"
            | "rotate"
            | "fill"
            | "fill_n"
            | "generate"
            | "iota"
            | "iter_swap"
            | "replace"
            | "remove"
            | "remove_if"
            | "unique"
            | "transform"
            | "for_each"
    )
}

/// Whether elements are sorted from the largest: `std::greater<int>()`.
fn falls(by: &Expr) -> bool {
    match &by.node {
        ExprNode::Template(_, of) => falls(of),
        ExprNode::Call(callee, given) => {
            let greater = matches!(&callee.node, ExprNode::Name(name) if last(name) == "greater");
            greater && given.is_empty()
        }
        _ => false,
    }
}

/// Sorts numbers; nothing where some are not known.
fn sorted(all: &mut [Value]) -> Option<()> {
    let ordered = |it: &Value| match it {
        Value::Text(_) => true,
        Value::Record(layout, _) => layout.is_tuple() && it.order(it).is_some(),
        other => other.number().is_some(),
    };
    if !all.iter().all(ordered) {
        return None;
    }
    // In the order of C++: equal ones stay as they are.
    all.order_by(|a, b| a.order(b).unwrap_or(std::cmp::Ordering::Equal));
    Some(())
}
