//! Functions of vectors, arrays and text.

use std::rc::Rc;

use crate::{
    config::Place,
    limit::VENDOR_VALUES,
    program::vendor::{
        interpreter::{
            lvalue::{Reach, base_name},
            machine::{Location, Machine},
            reason::Reason,
            shape,
            value::Value,
        },
        syntax::tree::{Expr, Kind},
    },
};

impl Machine<'_> {
    /// A call of `object.member`.
    pub(in crate::program::vendor) fn method(
        &mut self,
        callee: &Expr,
        (of, member): (&Expr, &str),
        given: &[Expr],
        place: Place,
    ) -> Value {
        let name = base_name(of);
        let reached = self.reach(of);
        let reached = self.through(reached);
        let reached = self.first_object(reached, member);
        // An array that a function gives back.
        let reached = match reached {
            Reach::Value(all @ Value::List(_)) => {
                Reach::Location(self.hold(all, Kind::Any), Vec::new())
            }
            reached => reached,
        };
        if let Some(Value::Record(layout, _)) = self.reached(&reached) {
            let layout = Rc::clone(layout);
            if let (Some(entry), Reach::Location(slot, path)) = (&layout.entry, &reached) {
                let location = (*slot, path.clone());
                let found = self.map_method((&location, entry), member, given, place);
                return found.unwrap_or_else(|| self.changed(&reached, &name, member));
            }
            if let Some(found) = self.member_call(&layout, &reached, member, given, place) {
                return found;
            }
            if let Some(found) = self.part_made(&layout, &reached, member, given, place) {
                return found;
            }
        }
        let held = self.reached(&reached);
        match (held, &reached) {
            (Some(Value::List(_)), Reach::Location(slot, path)) => {
                if let ("swap", [other]) = (member, given) {
                    return self.swapped(of, other);
                }
                let location = (*slot, path.clone());
                let (member, given) = match self.emplaced(&location, member, given, place) {
                    Some((member, value)) => (member, vec![value]),
                    None => (member, given.iter().map(|it| self.value(it)).collect()),
                };
                let found = self.list_method(location.clone(), member, &given);
                let found = found.unwrap_or_else(|| self.changed(&reached, &name, member));
                self.referred = self
                    .given_back(location, member, &given)
                    .map(|it| (self.calls, it));
                found
            }
            (Some(Value::Text(_)), Reach::Location(..)) if member == "swap" && given.len() == 1 => {
                self.swapped(of, &given[0])
            }
            (Some(Value::Text(_)), _) => self.text_method((&reached, &name), member, given, place),
            (Some(Value::Record(layout, _)), _)
                if layout.members.iter().any(|it| &*it.name == member) =>
            {
                let reached = self.member(reached, member);
                self.call_reached(callee, &reached, given, place)
            }
            (Some(Value::Lambda(function)), Reach::Location(slot, path))
                if function.words.is_some() =>
            {
                let (function, location) = (Rc::clone(function), (*slot, path.clone()));
                self.kernel_method(&function, location, member, place)
            }
            (_, Reach::Location(slot, _))
                if self.companion.is_some() && matches!(member, "reset" | "get_usec") =>
            {
                let slot = *slot;
                self.stopwatch(slot, member).unwrap_or(Value::Whole(0))
            }
            _ => self.unfollowed(callee, (&reached, &name, member), given, place),
        }
    }

    /// The first object of an array, where a function of it is called by a pointer to the array.
    fn first_object(&self, reached: Reach, member: &str) -> Reach {
        let first = match self.reached(&reached) {
            Some(Value::List(all)) => all.first(),
            _ => None,
        };
        let has = matches!(first, Some(Value::Record(layout, _)) if layout.names(member));
        match reached {
            Reach::Location(slot, path)
                if has && !(path.is_empty() && self.copied.contains(&slot)) =>
            {
                Reach::Location(slot, [&path[..], &[0]].concat())
            }
            reached => reached,
        }
    }

    /// A function that is not known may have changed what it belongs to, its length too.
    fn changed(&mut self, reached: &Reach, name: &str, member: &str) -> Value {
        let why: Reason = format!("`{name}.{member}`").into();
        if let Reach::Location(slot, path) = reached {
            self.put(*slot, path, Value::Unknown(why.clone()));
        }
        Value::Unknown(why)
    }

    /// The element that a function of an array gives back itself.
    fn given_back(
        &self,
        (slot, mut path): Location,
        member: &str,
        given: &[Value],
    ) -> Option<Location> {
        let Some(Value::List(all)) = self.peek(slot, &path) else {
            return None;
        };
        let length = all.len();
        let at = match (member, given) {
            ("front", []) => 0,
            ("back", []) => length.checked_sub(1)?,
            ("at", [index]) => usize::try_from(index.whole()?).ok()?,
            _ => return None,
        };
        path.push(at);
        (at < length).then_some((slot, path))
    }

    pub(in crate::program::vendor) fn list_method(
        &mut self,
        location: Location,
        member: &str,
        given: &[Value],
    ) -> Option<Value> {
        self.asked_of_array(&location, member, given)
            .or_else(|| self.of_array(location, member, given))
    }

    /// The object that `emplace_back` makes of what it is given, and the function that adds it.
    fn emplaced(
        &mut self,
        (slot, path): &Location,
        member: &str,
        given: &[Expr],
        place: Place,
    ) -> Option<(&'static str, Value)> {
        let member = match member {
            "emplace_back" => "push_back",
            "emplace_front" => "push_front",
            _ => return None,
        };
        if given.len() != 1 && self.string_at(*slot, path) {
            return Some((member, self.text(given)));
        }
        let class = self.class_at(*slot, path)?;
        let value = if class.constructs() {
            self.constructed(&class, given, place)
        } else {
            let given = given.iter().map(|it| self.value(it)).collect();
            self.record(&class, given)
        };
        Some((member, value))
    }

    /// A function that leaves an array of the language's library as it is.
    fn asked_of_array(
        &self,
        (slot, path): &Location,
        member: &str,
        given: &[Value],
    ) -> Option<Value> {
        let Some(Value::List(all)) = self.peek(*slot, path) else {
            return None;
        };
        let to = |at: usize| Value::Pointer(*slot, [&path[..], &[at]].concat(), "data".into());
        match (member, given) {
            ("size" | "length", _) => Some(Value::size_t(all.len() as i64)),
            ("empty", []) => Some(Value::flag(all.is_empty())),
            ("data" | "begin" | "cbegin", []) => Some(to(0)),
            ("end" | "cend", []) => Some(to(all.len())),
            ("rbegin" | "crbegin", []) => Some(Value::Back(
                *slot,
                [&path[..], &[all.len()]].concat(),
                "data".into(),
            )),
            ("rend" | "crend", []) => Some(Value::Back(
                *slot,
                [&path[..], &[0]].concat(),
                "data".into(),
            )),
            ("front", []) => all.first().cloned(),
            ("back", []) => all.last().cloned(),
            ("at", [index]) => all.get(usize::try_from(index.whole()?).ok()?).cloned(),
            ("reserve" | "shrink_to_fit", _) => Some(Value::Whole(0)),
            _ => None,
        }
    }

    /// A function that changes an array of the language's library; where it is not known, the
    /// array is no more.
    fn of_array(&mut self, (slot, path): Location, member: &str, given: &[Value]) -> Option<Value> {
        let kind = self.kind_at(slot, &path);
        let class = self.class_at(slot, &path);
        let texts = self.string_at(slot, &path);
        let of_class = |(at, it): (usize, &Value)| {
            // Numbers are lengths, and pointers to anything but characters places.
            let characters = match it {
                Value::Pointer(slot, path, _) => {
                    let (slot, path) = self.pointed(*slot, path.clone());
                    matches!(self.kind_at(slot, &path), Kind::Bits(8, _))
                }
                _ => true,
            };
            let text = texts && characters && (it.number().is_none() || at > 0);
            self.with_texts(shape::element(it.clone(), class.as_ref()), text)
        };
        // Of objects a length comes first, of `resize` and `assign`.
        let given: Vec<Value> = given.iter().enumerate().map(of_class).collect();
        let given = &given[..];
        let Value::List(all) = self.target(slot, &path)? else {
            return None;
        };
        let length = all.len();
        let of_kind = |value: &Value| shape::deep(value.clone(), kind);
        let place = |value: &Value| match value {
            Value::Pointer(of, way, _) if *of == slot => way.last().copied(),
            _ => None,
        };
        let count = |length: &Value, value: &Value| {
            let length = usize::try_from(length.whole()?).ok()?;
            (length.checked_mul(value.size())? <= VENDOR_VALUES).then_some(length)
        };
        let zero = match &class {
            Some(class) => shape::fresh(class, &Value::Whole(0)),
            None if texts => Value::Text("".into()),
            None => Value::Whole(0),
        };
        // What a new element of an array of arrays is, is not known here.
        let plain = match &class {
            Some(class) => !class.constructs(),
            None => texts || all.first().is_none_or(|it| it.number().is_some()),
        };
        let mut found = Value::Whole(0);
        match (member, given) {
            ("push_back" | "emplace_back" | "push_front" | "emplace_front" | "insert", _)
                if length >= VENDOR_VALUES =>
            {
                return None;
            }
            ("push_back" | "emplace_back", [value]) => all.push(of_kind(value)),
            ("push_front" | "emplace_front", [value]) => all.insert(0, of_kind(value)),
            ("pop_back", []) => drop(all.pop()),
            ("pop_front", []) => drop(all.drain(..length.min(1))),
            ("clear", []) => all.clear(),
            ("fill", [value]) if length * value.size() <= VENDOR_VALUES => all.fill(of_kind(value)),
            ("resize", [length]) if plain => all.resize(count(length, &zero)?, of_kind(&zero)),
            ("resize", [length, value]) => all.resize(count(length, value)?, of_kind(value)),
            ("assign", [length, value]) if count(length, value).is_some() => {
                *all = vec![of_kind(value); count(length, value)?];
            }
            ("insert", [at, Value::List(more)]) if plain => {
                let at = place(at).filter(|it| *it <= length)?;
                if length + more.len() > VENDOR_VALUES {
                    return None;
                }
                found = Value::Pointer(slot, [&path[..], &[at]].concat(), "data".into());
                all.splice(at..at, more.iter().map(of_kind));
            }
            ("insert", [at, value]) if place(at)? <= length => {
                found = at.clone();
                all.insert(place(at)?, of_kind(value));
            }
            ("insert", [at, from, to]) if place(at)? <= length => {
                let (Value::Pointer(of, ..), Value::Pointer(..)) = (from, to) else {
                    return None;
                };
                if *of == slot {
                    return None;
                }
                let Value::List(more) = self.copied_range(from, to)? else {
                    return None;
                };
                return self.of_array((slot, path), member, &[at.clone(), Value::List(more)]);
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
        let one = matches!(member, "push_back" | "emplace_back" | "pop_back");
        let (moved, before) = if one { (given, 0) } else { (&all[..], length) };
        let values = before + moved.iter().map(Value::size).sum::<usize>();
        let weight = before + moved.iter().map(Value::weight).sum::<usize>();
        self.passes(weight);
        self.grows(values);
        Some(found)
    }

    /// `std::begin(array)`, `std::end(array)`, `std::size(array)`
    pub(in crate::program::vendor) fn of_whole(&mut self, of: &Expr, name: &str) -> Option<Value> {
        let Reach::Location(slot, path) = self.reach(of) else {
            return None;
        };
        match self.peek(slot, &path) {
            Some(Value::List(_)) => self.list_method((slot, path), name, &[]),
            _ => None,
        }
    }
}
