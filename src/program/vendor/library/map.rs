//! Maps of the language's library: their elements in the order of their making, which is no order
//! of their keys, so that what leads to one leads there for good.

use std::rc::Rc;

use super::map_entry::{checked, in_order, key_of, same};
use crate::{
    config::{Fault, Place},
    limit::VENDOR_VALUES,
    program::vendor::{
        interpreter::{
            layout::Layout,
            lvalue::Reach,
            machine::{Location, Machine},
            reason::Reason,
            shape,
            value::Value,
        },
        syntax::tree::{Expr, Kind},
    },
};

/// Where an iterator behind all elements leads.
const END: usize = usize::MAX / 4;

impl Machine<'_> {
    /// The elements of a map that lies somewhere, with the places of those that were erased.
    fn entries(&self, slot: usize, path: &[usize]) -> Option<(&Rc<Layout>, &[Value])> {
        match self.peek(slot, path) {
            Some(Value::Record(layout, all)) if layout.entry.is_some() => Some((layout, all)),
            _ => None,
        }
    }

    /// Where the element of a key stands; the reason where the key is not known.
    fn place_of(&self, (slot, path): &Location, key: &Value) -> Result<Option<usize>, Reason> {
        if let Value::Unknown(why) = key {
            return Err(why.clone());
        }
        let Some(key) = checked(key) else {
            return Err(Reason::never("a key that is neither a number nor a string"));
        };
        let all = self.entries(*slot, path).map_or(&[][..], |it| it.1);
        self.passes(all.len());
        Ok(all.iter().position(|it| same(it, key)))
    }

    /// A key as the map holds it.
    fn key(&self, entry: &Layout, key: Value) -> Value {
        match entry.members.first() {
            Some(it) if it.text => self.string_of(key),
            Some(it) => key.converted(it.kind),
            None => key,
        }
    }

    /// `map[key]`: the element is made where there is none.
    pub(in crate::program::vendor) fn entry_of(
        &mut self,
        base: Reach,
        entry: &Rc<Layout>,
        key: Value,
        place: Place,
    ) -> Reach {
        let key = self.key(entry, key);
        let Reach::Location(slot, path) = base else {
            return Reach::Value(Value::Unknown("an element of a map".into()));
        };
        let location = (slot, path);
        let at = match self.place_of(&location, &key) {
            Ok(Some(at)) => Some(at),
            Ok(None) => {
                let value = self.empty_value(entry, place);
                self.insert(
                    &location,
                    Value::Record(Rc::clone(entry), vec![key, value]),
                    place,
                )
            }
            Err(why) => {
                self.forget(location.0, &location.1, &why);
                return Reach::Value(Value::Unknown(why));
            }
        };
        let (slot, mut path) = location;
        match at {
            Some(at) => {
                path.extend([at, 1]);
                Reach::Location(slot, path)
            }
            None => Reach::Value(Value::Unknown("an element of a map".into())),
        }
    }

    /// What a new element holds.
    fn empty_value(&mut self, entry: &Rc<Layout>, place: Place) -> Value {
        if let Some(layout) = entry.members[1].layout.clone()
            && layout.constructs()
            && entry.members[1].lengths.is_empty()
        {
            return self.constructed(&layout, &[], place);
        }
        match shape::fresh(entry, &Value::Whole(0)) {
            Value::Record(_, mut all) => {
                let value = all.pop().unwrap_or(Value::Whole(0));
                shape::deep(value, entry.members[1].kind)
            }
            other => other,
        }
    }

    /// Adds an element; where it stands.
    fn insert(&mut self, (slot, path): &Location, it: Value, place: Place) -> Option<usize> {
        let count = self.entries(*slot, path)?.1.len();
        if !self.fits(
            count.saturating_mul(it.size()).min(VENDOR_VALUES + 1),
            place,
        ) {
            return None;
        }
        let values = it.size();
        match self.target(*slot, path)? {
            Value::Record(_, all) => all.push(it),
            _ => return None,
        }
        self.grows(values);
        Some(count)
    }

    /// A function of a map; nothing where it is not supported.
    pub(super) fn map_method(
        &mut self,
        (location, entry): (&Location, &Rc<Layout>),
        member: &str,
        given: &[Expr],
        place: Place,
    ) -> Option<Value> {
        let (slot, path) = location;
        let to = |at: usize| Value::Pointer(*slot, [&path[..], &[at]].concat(), "data".into());
        let size = { self.entries(*slot, path)?.1.iter() }
            .filter(|it| key_of(it).is_some())
            .count();
        let size = Value::size_t(size as i64);
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        match (member, &values[..]) {
            ("size", []) => return Some(size),
            ("empty", []) => return Some(Value::flag(size.whole() == Some(0))),
            ("begin" | "cbegin", []) => {
                self.ordered_by_key(*slot, path, place);
                let first = in_order(self.entries(*slot, path)?.1).first().copied();
                return Some(to(first.unwrap_or(END)));
            }
            ("end" | "cend", []) => return Some(to(END)),
            ("clear", []) => {
                if let Value::Record(_, all) = self.target(*slot, path)? {
                    // Nothing may lead to another element later.
                    all.fill(Value::Unknown("an element that was erased".into()));
                }
                return Some(Value::Whole(0));
            }
            ("insert", [it]) => {
                let it = shape::object(it.clone(), entry).ok()?;
                let it = self.with_texts(it, false);
                return self.inserted((location, false), it, place);
            }
            ("emplace" | "try_emplace" | "insert_or_assign", [key, value]) => {
                let pair = vec![key.clone(), value.clone()];
                let it = shape::record(entry, pair).ok()?;
                let it = self.with_texts(it, false);
                let again = member == "insert_or_assign";
                return self.inserted((location, again), it, place);
            }
            ("erase", [Value::Pointer(of, way, _)]) if *of == *slot => {
                let at = *way.last()?;
                return self.erased(location, at);
            }
            _ => {}
        }
        let ([key], "at" | "count" | "find" | "contains" | "erase") = (&values[..], member) else {
            return None;
        };
        let key = self.key(entry, key.clone());
        let found = match self.place_of(location, &key) {
            Ok(found) => found,
            Err(why) => {
                if member == "erase" {
                    self.forget(*slot, path, &why);
                }
                return Some(Value::Unknown(why));
            }
        };
        match (member, found) {
            ("count", found) => Some(Value::size_t(i64::from(found.is_some()))),
            ("contains", found) => Some(Value::flag(found.is_some())),
            ("find", found) => Some(to(found.unwrap_or(END))),
            ("erase", None) => Some(Value::size_t(0)),
            ("erase", Some(at)) => {
                self.erased(location, at)?;
                Some(Value::size_t(1))
            }
            (_, Some(at)) => {
                let path = [&path[..], &[at, 1]].concat();
                let value = self.decayed(*slot, &path, "an element");
                self.referred = Some((self.calls, (*slot, path)));
                Some(value)
            }
            (_, None) => {
                let key = match &key {
                    Value::Text(text) => format!("\"{text}\""),
                    other => other.describe(),
                };
                self.error(
                    place,
                    format!("`at` of {key}, which is not a key of this map"),
                    "this call",
                    "check with `count` first, or use `map[key]`, which inserts the element",
                );
                Some(Value::Whole(0))
            }
        }
    }

    /// An element is added, where its key has none, or is assigned to `again`; what `insert` gives back.
    fn inserted(
        &mut self,
        (location, again): (&Location, bool),
        it: Value,
        place: Place,
    ) -> Option<Value> {
        let (slot, path) = location;
        let key = key_of(&it)?.clone();
        let found = match self.place_of(location, &key) {
            Ok(found) => found,
            Err(why) => {
                self.forget(*slot, path, &why);
                return Some(Value::Unknown(why));
            }
        };
        let at = match found {
            Some(at) => {
                if let (true, Value::Record(_, mut all)) = (again, it) {
                    let path = [&path[..], &[at, 1]].concat();
                    self.put(*slot, &path, all.pop()?);
                }
                at
            }
            None => self.insert(location, it, place)?,
        };
        let to = Value::Pointer(*slot, [&path[..], &[at]].concat(), "data".into());
        let members = vec![("first".into(), Kind::Any), ("second".into(), Kind::Flag)];
        let layout = Layout::of_values("pair", members);
        let all = vec![to, Value::flag(found.is_none())];
        Some(Value::Record(layout.into(), all))
    }

    /// An element is taken out; an iterator to the one behind it.
    fn erased(&mut self, location: &Location, at: usize) -> Option<Value> {
        let (slot, path) = location;
        let next = self.beside(location, at, 1);
        if let Value::Record(_, all) = self.target(*slot, path)? {
            *all.get_mut(at)? = Value::Unknown("an element that was erased".into());
        }
        let path = [&path[..], &[next?]].concat();
        Some(Value::Pointer(*slot, path, "data".into()))
    }

    /// The element so many further by key.
    fn beside(&self, (slot, path): &Location, at: usize, by: i64) -> Option<usize> {
        let places = in_order(self.entries(*slot, path)?.1);
        self.passes(places.len());
        let now = places.iter().position(|it| *it == at);
        let now = now.or((at == END).then_some(places.len()))?;
        let next = usize::try_from(now as i64 + by).ok()?;
        match places.get(next) {
            Some(at) => Some(*at),
            None => (next == places.len()).then_some(END),
        }
    }

    /// What `++` and `--` make of a number, a pointer or an iterator.
    pub(in crate::program::vendor) fn stepped(
        &mut self,
        before: &Value,
        reached: &Reach,
        by: i64,
        place: Place,
    ) -> Value {
        if matches!(before, Value::Text(text) if text.is_empty() && by == 1) {
            // Behind the 0: it may be held, as after `while (*p++)`.
            return Value::Unknown("a pointer behind the end of its text".into());
        }
        if let Value::Pointer(slot, way, name) = before
            && let Some((at, path)) = way.split_last()
            && self.entries(*slot, path).is_some()
        {
            let location = (*slot, path.to_vec());
            let Some(next) = self.beside(&location, *at, by) else {
                self.error(
                    place,
                    "an iterator is past the end of its map, or its element was erased".to_owned(),
                    "this step",
                    "stop at `end()`, and continue with the iterator that `erase` returns",
                );
                return before.clone();
            };
            let path = [path, &[next]].concat();
            return Value::Pointer(*slot, path, name.clone());
        }
        if let (Value::Record(..), Reach::Location(slot, path)) = (before, reached) {
            let object = Reach::Location(*slot, path.clone());
            return self.step_operator(object, by, true, place);
        }
        let after = Value::binary("+", before, &Value::Whole(by));
        self.or_fault(after, place)
    }

    /// The places of a map's elements, in the order in which a loop goes over them.
    pub(in crate::program::vendor) fn ordered_by_key(
        &mut self,
        slot: usize,
        path: &[usize],
        place: Place,
    ) -> Vec<usize> {
        let Some((layout, all)) = self.entries(slot, path) else {
            return Vec::new();
        };
        let places = in_order(all);
        self.passes(8 * places.len());
        if layout.name.starts_with("unordered") && places.len() > 1 {
            self.fault(
                Fault::warning(
                    place,
                    "the order of an `unordered_map` is unspecified in C++",
                    "here it is the order of the keys",
                )
                .help("use a `map` if the order matters"),
            );
        }
        places
    }
}
