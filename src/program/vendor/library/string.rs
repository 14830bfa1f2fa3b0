//! Texts of the language's library: what they are made of, and their functions. A text is a copy of
//! the characters that it is given; its iterators are what of it stands behind them.

use std::rc::Rc;

use super::c_string::character;
use crate::{
    config::Place,
    limit::VENDOR_VALUES,
    program::vendor::{
        interpreter::{
            layout::Layout,
            lvalue::Reach,
            machine::Machine,
            reason::Reason,
            shape,
            value::{Slot, Value},
        },
        syntax::tree::{Expr, ExprNode, Kind, Word, last},
    },
};

impl Machine<'_> {
    /// Whether a class is that of the texts of the language's library.
    pub(in crate::program::vendor) fn is_string(&self, class: &str) -> bool {
        last(class) == "string" && !self.layouts.contains_key("string")
    }

    /// Whether a text of the language's library lies there, or an array of those.
    pub(in crate::program::vendor) fn string_at(&self, slot: Slot, path: &[usize]) -> bool {
        let class = self.classes.get(&slot);
        let mut text = class.is_some_and(|it| self.is_string(it));
        let mut value = self.slots.get(slot);
        for index in path {
            value = match value {
                Some(Value::List(all)) => all.get(*index),
                Some(Value::Record(layout, all)) => {
                    text = layout.members.get(*index).is_some_and(|it| it.text);
                    all.get(*index)
                }
                Some(Value::Text(_)) => return false,
                other => other,
            };
        }
        text
    }

    /// Whether an expression is a text of the language's library; nothing where its text does not
    /// say it.
    pub(in crate::program::vendor) fn gives_string(&self, it: &Expr) -> Option<bool> {
        let mut it = it;
        while let ExprNode::Binary("+", left, right) = &it.node {
            if self.gives_string(right) == Some(true) {
                return Some(true);
            }
            it = left;
        }
        match &it.node {
            ExprNode::Text(_) => Some(false),
            ExprNode::Call(callee, _) => match &callee.node {
                ExprNode::Name(name) => {
                    let plain = last(name);
                    let mut own = self.functions.get(plain).into_iter().flatten().peekable();
                    if own.peek().is_none() {
                        return match plain {
                            "to_string" => Some(true),
                            _ => Some(self.is_string(plain)).filter(|it| *it),
                        };
                    }
                    own.all(|it| self.is_string(&it.gives)).then_some(true)
                }
                ExprNode::Member(_, member) => match &**member {
                    "c_str" | "data" => Some(false),
                    "substr" => Some(true),
                    _ => None,
                },
                _ => None,
            },
            ExprNode::Choose(_, yes, no) => {
                let both = [self.gives_string(yes), self.gives_string(no)];
                if both.contains(&Some(true)) {
                    Some(true)
                } else {
                    both[0].and(both[1])
                }
            }
            ExprNode::Assign(_, of, _) | ExprNode::Convert(Kind::Any, of) => self.gives_string(of),
            ExprNode::Name(name) => {
                let found = self.named_location(name);
                Some(found.is_some_and(|(slot, path)| self.string_at(slot, &path)))
            }
            // Of a map it is not known.
            _ => {
                let found = self.lies(it);
                found.map(|(slot, path)| self.string_at(slot, &path))
            }
        }
    }

    /// What a text of the language's library becomes that is made of this value.
    pub(in crate::program::vendor) fn string_of(&self, value: Value) -> Value {
        let value = shape::text(value);
        match &value {
            Value::Pointer(_, _, name) => match self.as_text(&value) {
                text @ Value::Text(_) => text,
                _ => Value::Unknown(format!("the characters in `{name}`").into()),
            },
            _ => character(&value),
        }
    }

    /// A value, with texts of the language's library as copies; `text` says that it is one, or an
    /// array of them.
    pub(in crate::program::vendor) fn with_texts(&self, value: Value, text: bool) -> Value {
        let parts = |all: &[Value]| {
            let first = all.first();
            text || matches!(first, Some(Value::List(_) | Value::Record(..)))
        };
        match value {
            Value::List(all) if parts(&all) => {
                let all = all.into_iter().map(|it| self.with_texts(it, text));
                Value::List(all.collect())
            }
            Value::Record(layout, all) if layout.entry.is_some() => {
                let all = all.into_iter().map(|it| self.with_texts(it, false));
                let all = all.collect();
                Value::Record(layout, all)
            }
            Value::Record(layout, all)
                if { layout.members.iter() }.any(|it| it.text || it.layout.is_some()) =>
            {
                let texts = layout.members.iter().map(|it| it.text);
                let texts = texts.chain(std::iter::repeat(false));
                let all = { all.into_iter().zip(texts) }
                    .map(|(it, text)| self.with_texts(it, text))
                    .collect();
                Value::Record(layout, all)
            }
            value @ (Value::Pointer(..) | Value::Whole(_)) if text => self.string_of(value),
            value => value,
        }
    }

    /// Elements of a map in braces whose keys are texts, with those as copies.
    pub(in crate::program::vendor) fn with_keys(
        &self,
        value: Value,
        map: Option<&Layout>,
    ) -> Value {
        let entry = map.and_then(|it| it.entry.as_ref());
        let first = entry.and_then(|it| it.members.first());
        let mut all = match value {
            Value::List(all) if first.is_some_and(|it| it.text) => all,
            value => return value,
        };
        for it in &mut all {
            if let Value::List(pair) = it
                && let Some(key) = pair.first_mut()
            {
                *key = self.string_of(key.clone());
            }
        }
        Value::List(all)
    }

    /// An object of a class, from the values of its members in their order.
    pub(in crate::program::vendor) fn record(
        &self,
        layout: &Rc<Layout>,
        given: Vec<Value>,
    ) -> Value {
        let given = match self.with_keys(Value::List(given), Some(layout)) {
            Value::List(given) => given,
            other => vec![other],
        };
        let made = shape::record(layout, given);
        let made = made.unwrap_or_else(|why| Value::Unknown(why.into()));
        self.with_texts(made, false)
    }

    /// `std::string("text")`, `std::string("text", length)`, `std::string(length, character)` and
    /// their kin.
    pub(in crate::program::vendor) fn text(&mut self, given: &[Expr]) -> Value {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        if let Some(unknown @ Value::Unknown(_)) = { values.iter() }.find(|it| is_unknown(it)) {
            return unknown.clone();
        }
        if let [one] = &values[..] {
            return match self.string_of(one.clone()) {
                made @ (Value::Text(_) | Value::Unknown(_)) => made,
                _ => Value::Unknown("a text".into()),
            };
        }
        if let [from @ Value::Pointer(..), to @ Value::Pointer(..)] = &values[..] {
            let copied = self.copied_range(from, to).map(shape::text);
            return copied.unwrap_or_else(|| Value::Unknown("a text".into()));
        }
        let part_of = given.first().and_then(|it| self.gives_string(it)) == Some(true);
        let values: Vec<Value> = values.iter().map(|it| self.as_text(it)).collect();
        let made = match &values[..] {
            [] => Some(String::new()),
            // From one iterator to another.
            [Value::Text(from), Value::Text(to)] => from.strip_suffix(&**to).map(str::to_owned),
            [Value::Text(of), from] if part_of => part(of, Some(from), None),
            // Behind its end other characters of the array would come.
            [Value::Text(of), length] if length.whole().is_some_and(|it| it <= of.len() as i64) => {
                part(of, None, Some(length))
            }
            [Value::Text(of), from, length] => part(of, Some(from), Some(length)),
            [length, code] => repeated(length, code),
            _ => None,
        };
        made.map_or_else(
            || Value::Unknown("a text".into()),
            |it| Value::Text(it.into()),
        )
    }

    /// A function of a text of the language's library, which lies in `name`.
    pub(super) fn text_method(
        &mut self,
        (reached, name): (&Reach, &str),
        member: &str,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let given: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let given: Vec<Value> = given.iter().map(|it| self.as_text(it)).collect();
        let held = match self.reached(reached) {
            Some(Value::Text(text)) => text.clone(),
            _ => return Value::Unknown(format!("`{name}.{member}`").into()),
        };
        if let Some(found) = asked(&held, member, &given) {
            return found;
        }
        let unknown = given.iter().any(|it| is_unknown(it) || is_pointer(it));
        let written = match changed(&held, member, &given) {
            Some(text) => Value::Text(text.into()),
            None if unknown && LOOKS.contains(&member) => {
                return Value::Unknown(format!("`{name}.{member}`").into());
            }
            None if unknown => Value::Unknown(format!("`{name}.{member}`").into()),
            None => {
                self.error(
                    place,
                    format!("`{name}.{member}` of the string \"{held}\" is not supported"),
                    "this call, with these arguments",
                    "build the string with `+` and `substr`, within its length",
                );
                return Value::Whole(0);
            }
        };
        // Behind an iterator comes what is left there now.
        let at = match (&given[..], member) {
            ([place @ Value::Text(_), ..], "insert" | "erase") => at(&held, place),
            _ => None,
        };
        let left = match (&written, at) {
            (Value::Text(text), Some(at)) => text.get(at..).map(|it| Value::Text(it.into())),
            _ => None,
        };
        let gives = left.as_ref().unwrap_or(&written).clone();
        if let Reach::Location(slot, path) = reached {
            self.put(*slot, path, written);
            let own = (self.calls, (*slot, path.clone()));
            self.referred = left.is_none().then_some(own);
        }
        gives
    }

    /// `text[index] = character`, and `+=` and its kin; nothing where something else is assigned to.
    pub(in crate::program::vendor) fn character_set(
        &mut self,
        operator: Option<&str>,
        to: &Expr,
        value: &Value,
        place: Place,
    ) -> Option<Value> {
        let ExprNode::Index(of, index) = &to.node else {
            return None;
        };
        let (slot, path) = self.lies(of)?;
        if !self.string_at(slot, &path) || !self.has_place(of) {
            return None;
        }
        let Reach::Location(slot, path) = self.reach(of) else {
            return None;
        };
        let Some(Value::Text(text)) = self.peek(slot, &path).cloned() else {
            return None;
        };
        let index = self.value(index);
        let why: Option<Reason> = match (&index, value) {
            (Value::Unknown(why), _) | (_, Value::Unknown(why)) => Some(why.clone()),
            _ => None,
        };
        if let Some(why) = why {
            self.put(slot, &path, Value::Unknown(why.clone()));
            return Some(Value::Unknown(why));
        }
        let mut bytes = text.as_bytes().to_vec();
        let held = { index.whole() }.and_then(|it| bytes.get_mut(usize::try_from(it).ok()?));
        let Some(held) = held else {
            self.error(
                place,
                format!("index out of range in the string \"{text}\""),
                "this index",
                "indices go from 0 to the length minus one",
            );
            return Some(Value::Whole(0));
        };
        let before = Value::Whole(i64::from(*held as i8));
        let after = match operator {
            None => Ok(value.clone()),
            Some(operator) => Value::binary(operator, &before, value),
        };
        let after = self.or_fault(after, place).converted(Kind::CHARACTER);
        *held = after.whole()? as u8;
        match String::from_utf8(bytes) {
            Ok(text) => self.put(slot, &path, Value::Text(text.into())),
            Err(_) => self.put(
                slot,
                &path,
                Value::Unknown("a text with other characters".into()),
            ),
        }
        Some(after)
    }

    /// An algorithm over all characters of a text of the language's library, by way of an array of
    /// them; nothing where it is given no places in one.
    pub(super) fn over_text(&mut self, name: &str, given: &[Expr], place: Place) -> Option<Value> {
        let (slot, path) = given.iter().find_map(|it| self.text_under(it))?;
        let same = |it: &Machine<'_>, of: &Expr| it.text_under(of) == Some((slot, path.clone()));
        let Some(Value::Text(text)) = self.peek(slot, &path).cloned() else {
            return None;
        };
        let simple = match given {
            [from, to, ..] => begins(from) && ends(to) && same(self, from) && same(self, to),
            _ => false,
        };
        let rest = given.get(2..).unwrap_or_default();
        let other = |it: &Expr| self.text_under(it).is_some() && !(begins(it) && same(self, it));
        if !simple || rest.iter().any(other) {
            self.text_places(name, place);
            return Some(Value::Whole(0));
        }
        let codes = text.bytes().map(|it| Value::Whole(i64::from(it as i8)));
        let held = self.hold(Value::List(codes.collect()), Kind::CHARACTER);
        // A name that nobody can write.
        let own: Word = "[text".into();
        let scope = [(own.clone(), held)].into_iter().collect();
        let named = |place: Place| Expr {
            node: ExprNode::Name(own.clone()),
            place,
        };
        let all = given.iter().map(|it| match (begins(it), ends(it)) {
            (true, _) if same(self, it) => named(it.place),
            (_, true) if same(self, it) => {
                let length = ExprNode::Whole(text.len() as i64);
                let length = Expr {
                    node: length,
                    place: it.place,
                };
                let node = ExprNode::Binary("+", Box::new(named(it.place)), Box::new(length));
                Expr {
                    node,
                    place: it.place,
                }
            }
            _ => it.clone(),
        });
        let all: Vec<Expr> = all.collect();
        self.scopes.push(scope);
        let found = self.algorithm(name, &all, place);
        self.scopes.pop();
        let bytes = match &self.slots[held] {
            Value::List(all) => { all.iter() }
                .map(|it| Some(it.whole()? as u8))
                .collect::<Option<Vec<u8>>>(),
            _ => None,
        };
        let made = bytes.and_then(|it| String::from_utf8(it).ok());
        let made = made.map_or_else(
            || Value::Unknown(format!("what `{name}` makes of a string").into()),
            |it| Value::Text(it.into()),
        );
        self.put(slot, &path, made.clone());
        Some(match (found, made) {
            (Value::Pointer(of, way, _), Value::Text(text)) if of == held => {
                let from = way.last().copied().unwrap_or(0);
                text.get(from..).map_or_else(
                    || Value::Unknown(format!("what `{name}` gives").into()),
                    |it| Value::Text(it.into()),
                )
            }
            (Value::Pointer(of, ..), _) if of == held => {
                Value::Unknown(format!("what `{name}` gives").into())
            }
            (found, _) => found,
        })
    }

    /// The text of the language's library that an iterator is asked of.
    pub(in crate::program::vendor) fn text_under(&self, it: &Expr) -> Option<(Slot, Vec<usize>)> {
        let ExprNode::Call(callee, given) = &it.node else {
            return None;
        };
        let of = match (&callee.node, &given[..]) {
            (ExprNode::Member(of, member), []) if PLACES.contains(&&**member) => of,
            (ExprNode::Name(name), [of]) if matches!(last(name), "begin" | "end") => of,
            _ => return None,
        };
        let (slot, path) = self.lies(of)?;
        let text = matches!(self.peek(slot, &path), Some(Value::Text(_)));
        text.then_some((slot, path))
    }

    /// Tells of a function that is given places in a text, and is not supported.
    pub(in crate::program::vendor) fn text_places(&mut self, name: &str, place: Place) {
        self.error(
            place,
            format!("`{name}` over part of a string is not supported"),
            "this call",
            "loop over the characters, or give it a whole string",
        );
    }
}

/// Functions that give places in a text.
const PLACES: [&str; 8] = [
    "begin", "end", "cbegin", "cend", "rbegin", "rend", "crbegin", "crend",
];

/// Functions that leave a text as it is.
const LOOKS: [&str; 12] = [
    "at",
    "compare",
    "find",
    "rfind",
    "find_first_of",
    "find_last_of",
    "substr",
    "front",
    "back",
    "starts_with",
    "ends_with",
    "copy",
];

fn begins(it: &Expr) -> bool {
    matches!(named(it), Some("begin" | "cbegin"))
}

fn ends(it: &Expr) -> bool {
    matches!(named(it), Some("end" | "cend"))
}

/// The function that a call names.
fn named(it: &Expr) -> Option<&str> {
    match &it.node {
        ExprNode::Call(callee, _) => match &callee.node {
            ExprNode::Member(_, name) | ExprNode::Name(name) => Some(last(name)),
            _ => None,
        },
        _ => None,
    }
}

fn is_unknown(it: &Value) -> bool {
    matches!(it, Value::Unknown(_))
}

fn is_pointer(it: &Value) -> bool {
    matches!(it, Value::Pointer(..))
}

/// A place in a text of so many bytes: a number, or an iterator.
fn at(text: &str, place: &Value) -> Option<usize> {
    let found = match place {
        Value::Text(rest) if text.ends_with(&**rest) => text.len() - rest.len(),
        other => usize::try_from(other.whole()?).ok()?,
    };
    text.is_char_boundary(found).then_some(found)
}

/// The part of a text from a place on, of a length at most.
fn part(text: &str, from: Option<&Value>, length: Option<&Value>) -> Option<String> {
    let from = from.map_or(Some(0), |it| at(text, it))?;
    let end = match length {
        // `std::string::npos`
        Some(length) => match length.whole()? {
            -1 => text.len(),
            length => from.saturating_add(usize::try_from(length).ok()?),
        },
        None => text.len(),
    };
    text.get(from..end.min(text.len())).map(str::to_owned)
}

/// A character, so many times.
fn repeated(length: &Value, code: &Value) -> Option<String> {
    let length = usize::try_from(length.whole()?).ok()?;
    let Value::Text(one) = character(code) else {
        return None;
    };
    (length <= VENDOR_VALUES).then(|| one.repeat(length))
}

/// What a function gives that leaves the text as it is.
fn asked(text: &Word, member: &str, given: &[Value]) -> Option<Value> {
    let code = |at: usize| Some(Value::Whole(i64::from(*text.as_bytes().get(at)? as i8)));
    let found = |at: Option<usize>| Some(Value::size_t(at.map_or(-1, |it| it as i64)));
    let wanted = |it: &Value| match character(it) {
        Value::Text(wanted) => Some(wanted),
        _ => None,
    };
    match (member, given) {
        ("c_str" | "data" | "begin" | "cbegin" | "substr", []) => Some(Value::Text(text.clone())),
        ("end" | "cend", []) => Some(Value::Text("".into())),
        ("size" | "length", []) => Some(Value::size_t(text.len() as i64)),
        ("empty", []) => Some(Value::flag(text.is_empty())),
        ("reserve" | "shrink_to_fit", _) => Some(Value::Whole(0)),
        ("front", []) => code(0),
        ("back", []) => code(text.len().checked_sub(1)?),
        ("at", [index]) => code(usize::try_from(index.whole()?).ok()?),
        ("compare", [Value::Text(other)]) => {
            let order = text.as_bytes().cmp(other.as_bytes());
            Some(Value::Whole(order as i64))
        }
        ("find", [it]) => found(text.find(&*wanted(it)?)),
        ("find", [it, from]) if matches!(from, Value::Whole(_) | Value::Wide(..)) => {
            let (wanted, from) = (wanted(it)?, usize::try_from(from.whole()?).ok()?);
            let rest = text.get(from..);
            found(rest.and_then(|it| it.find(&*wanted)).map(|it| it + from))
        }
        ("rfind", [it]) => found(text.rfind(&*wanted(it)?)),
        ("find_first_of", [it]) => {
            let wanted = wanted(it)?;
            found(text.find(|it| wanted.contains(it)))
        }
        ("find_last_of", [it]) => {
            let wanted = wanted(it)?;
            found(text.rfind(|it| wanted.contains(it)))
        }
        ("starts_with", [it]) => Some(Value::flag(text.starts_with(&*wanted(it)?))),
        ("ends_with", [it]) => Some(Value::flag(text.ends_with(&*wanted(it)?))),
        ("substr", [from]) => Some(Value::Text(part(text, Some(from), None)?.into())),
        ("substr", [from, length]) => {
            Some(Value::Text(part(text, Some(from), Some(length))?.into()))
        }
        _ => None,
    }
}

/// What a function makes of a text; nothing where it is not supported.
fn changed(text: &str, member: &str, given: &[Value]) -> Option<String> {
    let between = |from: usize, end: usize, more: &str| {
        let made = [text.get(..from)?, more, text.get(end..)?].concat();
        (made.len() <= VENDOR_VALUES).then_some(made)
    };
    let count = |it: &Value| usize::try_from(it.whole()?).ok();
    let behind = |from: usize, length: &Value| {
        let length = match length.whole()? {
            -1 => text.len(),
            length => usize::try_from(length).ok()?,
        };
        Some(from.saturating_add(length).min(text.len()))
    };
    match (member, given) {
        ("clear" | "erase", []) => Some(String::new()),
        ("append", [Value::Text(more)]) => between(text.len(), text.len(), more),
        ("append", [length, code]) => between(text.len(), text.len(), &repeated(length, code)?),
        ("push_back", [code]) => {
            between(text.len(), text.len(), &repeated(&Value::Whole(1), code)?)
        }
        ("pop_back", []) => {
            let (last, _) = text.char_indices().next_back()?;
            between(last, text.len(), "")
        }
        ("assign", [Value::Text(other)]) => Some(other.to_string()),
        ("assign", [length, code]) => repeated(length, code),
        ("insert", [place, Value::Text(more)]) => {
            let at = at(text, place)?;
            between(at, at, more)
        }
        // Behind an iterator a character.
        ("insert", [place @ Value::Text(_), code]) => {
            let at = at(text, place)?;
            between(at, at, &repeated(&Value::Whole(1), code)?)
        }
        ("insert", [place, length, code]) => {
            let at = at(text, place)?;
            between(at, at, &repeated(length, code)?)
        }
        ("erase", [place @ Value::Text(_)]) => {
            let at = at(text, place)?;
            let next = text.get(at..)?.chars().next()?.len_utf8();
            between(at, at + next, "")
        }
        ("erase", [place]) => between(at(text, place)?, text.len(), ""),
        ("erase", [from @ Value::Text(_), to @ Value::Text(_)]) => {
            let (from, to) = (at(text, from)?, at(text, to)?);
            (from <= to).then(|| between(from, to, ""))?
        }
        ("erase", [place, length]) => {
            let at = at(text, place)?;
            between(at, behind(at, length)?, "")
        }
        ("replace", [place, length, Value::Text(more)]) if !matches!(place, Value::Text(_)) => {
            let at = at(text, place)?;
            between(at, behind(at, length)?, more)
        }
        ("resize", [length, rest @ ..]) => {
            let length = count(length).filter(|it| *it <= VENDOR_VALUES)?;
            if length <= text.len() {
                return text.get(..length).map(str::to_owned);
            }
            let more = Value::Whole((length - text.len()) as i64);
            let code = rest.first().unwrap_or(&Value::Whole(0));
            Some([text, &repeated(&more, code)?].concat())
        }
        _ => None,
    }
}
