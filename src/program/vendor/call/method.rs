//! Functions of vectors, arrays and text.

use std::{rc::Rc, sync::Arc};

use super::super::{
    evaluate::{Reach, base_name},
    machine::{Machine, Spot},
    shape,
    tree::{Expr, Width},
    value::Value,
};
use crate::config::Place;

/// Elements of an array that grows.
const LONGEST: usize = 1 << 20;

impl Machine<'_> {
    /// A call of `object.member`.
    pub(super) fn method(
        &mut self,
        callee: &Expr,
        (of, member): (&Expr, &str),
        given: &[Expr],
        place: Place,
    ) -> Value {
        let name = base_name(of);
        let reached = self.reach(of);
        let reached = self.through(reached);
        if let Some(Value::Record(layout, _)) = self.reached(&reached) {
            let layout = Rc::clone(layout);
            if let Some(found) = self.member_call(&layout, &reached, member, given, place) {
                return found;
            }
        }
        let held = self.reached(&reached);
        match (held, &reached) {
            (Some(Value::List(_)), Reach::Spot(slot, path)) => {
                if let ("swap", [other]) = (member, given) {
                    return self.swapped(of, other);
                }
                let spot = (*slot, path.clone());
                self.list_method(spot.clone(), member, given)
                    .unwrap_or_else(|| {
                        // It may be longer or shorter now.
                        let why: Arc<str> = format!("`{name}.{member}`").into();
                        self.put(spot.0, &spot.1, Value::Unknown(Arc::clone(&why)));
                        Value::Unknown(why)
                    })
            }
            (Some(Value::Record(layout, _)), _)
                if layout.members.iter().any(|it| &*it.name == member) =>
            {
                let reached = self.member(reached, member);
                self.call_reached(callee, &reached, given, place)
            }
            (_, Reach::Spot(slot, _))
                if self.companion.is_some() && matches!(member, "reset" | "get_usec") =>
            {
                let slot = *slot;
                self.stopwatch(slot, member).unwrap_or(Value::Whole(0))
            }
            (held, _) => {
                let record = matches!(held, Some(Value::Record(..)));
                if self.leaves_array(&name, member, place) {
                    self.outside(&format!("{name}.{member}"), given, place);
                }
                // What it does with the members of its object is not known.
                if let (Reach::Spot(slot, path), true) = (&reached, record) {
                    self.forget(*slot, path, &format!("what `{name}.{member}` does").into());
                }
                Value::Unknown(format!("`{name}.{member}`").into())
            }
        }
    }

    fn list_method(&mut self, spot: Spot, member: &str, given: &[Expr]) -> Option<Value> {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let Some(Value::List(all)) = self.peek(spot.0, &spot.1) else {
            return None;
        };
        if matches!(member, "size" | "length") {
            return Some(Value::Wide(all.len() as i64, Width::UnsignedLong));
        }
        let all = all.clone();
        self.of_array(spot, all, member, &values)
    }

    /// A function of an array of the language's library.
    fn of_array(
        &mut self,
        (slot, path): Spot,
        mut all: Vec<Value>,
        member: &str,
        given: &[Value],
    ) -> Option<Value> {
        let kind = self.kind_at(slot, &path);
        let length = all.len();
        let of_kind = |value: &Value| shape::deep(value.clone(), kind);
        let to = |at: usize| Value::Pointer(slot, [&path[..], &[at]].concat(), "data".into());
        let place = |value: &Value| match value {
            Value::Pointer(of, way, _) if *of == slot => way.last().copied(),
            _ => None,
        };
        let count = |value: &Value| {
            usize::try_from(value.whole()?)
                .ok()
                .filter(|it| *it <= LONGEST)
        };
        // What a new element of an array of arrays is, is not known here.
        let plain = all.first().is_none_or(|it| it.number().is_some());
        let mut found = Value::Whole(0);
        match (member, given) {
            ("empty", []) => return Some(Value::flag(all.is_empty())),
            ("data" | "begin" | "cbegin", []) => return Some(to(0)),
            ("end" | "cend", []) => return Some(to(length)),
            ("front", []) => return all.first().cloned(),
            ("back", []) => return all.last().cloned(),
            ("at", [index]) => return all.get(count(index)?).cloned(),
            ("reserve" | "shrink_to_fit", _) => return Some(found),
            ("push_back" | "emplace_back", [value]) => all.push(of_kind(value)),
            ("push_front" | "emplace_front", [value]) => all.insert(0, of_kind(value)),
            ("pop_back", []) => drop(all.pop()),
            ("pop_front", []) => drop(all.drain(..length.min(1))),
            ("clear", []) => all.clear(),
            ("fill", [value]) => all.fill(of_kind(value)),
            ("resize", [length]) if plain => all.resize(count(length)?, of_kind(&Value::Whole(0))),
            ("resize", [length, value]) => all.resize(count(length)?, of_kind(value)),
            ("assign", [length, value]) if count(length).is_some() => {
                all = vec![of_kind(value); count(length)?];
            }
            ("insert", [at, value]) if place(at)? <= length => {
                found = at.clone();
                all.insert(place(at)?, of_kind(value));
            }
            ("erase", [at]) if place(at)? < length => {
                found = at.clone();
                all.remove(place(at)?);
            }
            ("erase", [from, end]) if place(from)? <= place(end)? && place(end)? <= length => {
                found = from.clone();
                all.drain(place(from)?..place(end)?);
            }
            _ => return None,
        }
        self.put(slot, &path, Value::List(all));
        Some(found)
    }

    /// `std::begin(array)`, `std::end(array)`, `std::size(array)`
    pub(super) fn of_whole(&mut self, of: &Expr, name: &str) -> Option<Value> {
        let Reach::Spot(slot, path) = self.reach(of) else {
            return None;
        };
        match self.peek(slot, &path) {
            Some(Value::List(_)) => self.list_method((slot, path), name, &[]),
            _ => None,
        }
    }
}
