//! Values as what holds them has them: arrays of their lengths, objects of their class, numbers of
//! their type.

use std::{collections::VecDeque, rc::Rc};

use super::{
    layout::{Layout, Member},
    value::Value,
};
use crate::program::vendor::{library::map_entry, syntax::tree::Kind};

/// What every element of an array is.
#[derive(Clone, Copy)]
pub(super) struct Leaf<'a> {
    pub kind: Kind,
    pub layout: Option<&'a Rc<Layout>>,
    /// Whether the array is one of the language's library.
    pub library: bool,
    /// Whether it is a text of the language's library.
    pub text: bool,
}

impl Leaf<'_> {
    /// What an element begins with that nothing is said of.
    fn empty(&self) -> Value {
        if self.text {
            Value::Text("".into())
        } else {
            Value::Whole(0)
        }
    }

    /// Whether an array of these lengths holds the characters of one text.
    fn spells(&self, lengths: &[Option<usize>]) -> bool {
        lengths.len() == 1 && matches!(self.kind, Kind::Bits(8, _)) && self.layout.is_none()
    }
}

/// A value in an array of these lengths. `Err` says what does not fit.
pub(super) fn shaped(
    value: Value,
    lengths: &[Option<usize>],
    leaf: Leaf<'_>,
) -> Result<Value, String> {
    if lengths.is_empty() {
        return single(value, leaf);
    }
    match value {
        Value::List(all) => {
            // `std::array` has braces of its own.
            let doubled = |all: &[Value]| {
                let [Value::List(inner)] = all else {
                    return false;
                };
                let lists = inner.iter().all(|it| matches!(it, Value::List(_)));
                let plain = lengths.len() == 1 && leaf.layout.is_none();
                plain || leaf.library && lists && !inner.is_empty()
            };
            let mut all = all;
            if doubled(&all)
                && let Some(Value::List(inner)) = all.pop()
            {
                all = inner;
            }
            let mut rest = all.into();
            let made = array(&mut rest, lengths, leaf)?;
            if rest.is_empty() {
                Ok(made)
            } else {
                Err(format!(
                    "{} too many for this array",
                    crate::unit::counted(rest.len(), "value")
                ))
            }
        }
        Value::Text(text) if leaf.spells(lengths) => row(&text, lengths[0], leaf.kind),
        other => Ok(other),
    }
}

/// The characters of a text in an array: behind them a 0, and more of those up to its length.
fn row(text: &str, length: Option<usize>, kind: Kind) -> Result<Value, String> {
    let codes = text.bytes().chain([0]);
    let mut codes: Vec<Value> = codes.map(|it| Value::Whole(it.into())).collect();
    if let Some(length) = length {
        if codes.len() > length {
            let wants = crate::unit::counted(codes.len(), "character");
            return Err(format!(
                "{wants} with the terminating 0, but there is room for {length}"
            ));
        }
        codes.resize(length, Value::Whole(0));
    }
    Ok(deep(Value::List(codes), kind))
}

/// What a text of the language's library is made of, in braces: another one, or its characters.
pub(in crate::program::vendor) fn text(value: Value) -> Value {
    let Value::List(mut all) = value else {
        return value;
    };
    if let ([only], Some(last)) = (&all[..], all.last().cloned())
        && only.number().is_none()
    {
        all.clear();
        return text(last);
    }
    let code = |it: &Value| u8::try_from(it.whole()?).ok();
    let bytes: Option<Vec<u8>> = all.iter().map(code).collect();
    let made = bytes.and_then(|it| String::from_utf8(it).ok());
    made.map_or_else(
        || Value::Unknown("a text".into()),
        |it| Value::Text(it.into()),
    )
}

/// Takes what an array holds from a list; inner braces may be left out.
fn array(
    rest: &mut VecDeque<Value>,
    lengths: &[Option<usize>],
    leaf: Leaf<'_>,
) -> Result<Value, String> {
    let Some((length, inner)) = lengths.split_first() else {
        let plain = matches!(rest.front(), Some(Value::List(_) | Value::Record(..)));
        return match (leaf.layout, plain) {
            (Some(layout), false) => members(layout, rest),
            _ => single(rest.pop_front().unwrap_or_else(|| leaf.empty()), leaf),
        };
    };
    if leaf.spells(lengths)
        && let Some(Value::Text(text)) = rest.front()
    {
        let made = row(text, *length, leaf.kind)?;
        rest.pop_front();
        return Ok(made);
    }
    let mut all = Vec::new();
    while length.map_or(!rest.is_empty(), |length| all.len() < length) {
        let braces = !inner.is_empty() && matches!(rest.front(), Some(Value::List(_)));
        let one = match rest.front_mut() {
            Some(list) if braces => {
                let list = std::mem::replace(list, Value::Whole(0));
                rest.pop_front();
                shaped(list, inner, leaf)?
            }
            _ => array(rest, inner, leaf)?,
        };
        all.push(one);
    }
    Ok(Value::List(all))
}

/// A value that is no array.
fn single(value: Value, leaf: Leaf<'_>) -> Result<Value, String> {
    match (value, leaf.layout) {
        (value, Some(layout)) => object(value, layout),
        (value, None) if leaf.text => Ok(text(value)),
        (Value::List(all), None) if leaf.kind != Kind::Any => {
            if all.len() > 1 {
                return Err(format!("{} values for one variable", all.len()));
            }
            let value = all.into_iter().next().unwrap_or(Value::Whole(0));
            single(value, leaf)
        }
        (value, None) => Ok(deep(value, leaf.kind)),
    }
}

/// A value in what holds objects of a class: from braces, or from an object of a class that is made
/// from it.
pub(in crate::program::vendor) fn object(
    value: Value,
    layout: &Rc<Layout>,
) -> Result<Value, String> {
    match value {
        Value::List(all) => record(layout, all),
        Value::Record(ref of, _) if of.name == layout.name => Ok(value),
        Value::Record(of, all) if of.is_designated() => designated(layout, &of, &all),
        Value::Record(of, all) if of.is_tuple() && layout.is_tuple() => record(layout, all),
        Value::Record(of, mut all) if of.line().any(|it| it.name == layout.name) => {
            all.truncate(layout.members.len());
            Ok(Value::Record(Rc::clone(layout), all))
        }
        Value::Record(of, _) => Err(format!(
            "an object of `{}` is not a `{}`",
            of.name, layout.name
        )),
        value => Ok(value),
    }
}

/// A value in an array of objects of this class, where there is one.
pub(in crate::program::vendor) fn element(value: Value, class: Option<&Rc<Layout>>) -> Value {
    match class {
        Some(layout) if matches!(value, Value::List(_) | Value::Record(..)) => {
            object(value, layout).unwrap_or_else(|why| Value::Unknown(why.into()))
        }
        _ => value,
    }
}

/// An object of a class, from the values of some of its members by name.
fn designated(layout: &Rc<Layout>, of: &Layout, given: &[Value]) -> Result<Value, String> {
    let unknown = |name: &str| !layout.members.iter().any(|it| &*it.name == name);
    if let Some(it) = of.members.iter().find(|it| unknown(&it.name)) {
        return Err(format!("`{}` has no member `{}`", layout.name, it.name));
    }
    let members = layout.members.iter().map(|member| {
        let at = of.members.iter().position(|it| it.name == member.name);
        let found = at.and_then(|at| given.get(at)).cloned();
        match (found, &member.default) {
            (Some(value), _) => shaped(value, &member.lengths, member.leaf()),
            (None, Some(default)) => Ok(default.clone()),
            (None, None) => array(&mut VecDeque::new(), &member.lengths, member.leaf()),
        }
    });
    let all = members.collect::<Result<_, _>>()?;
    Ok(Value::Record(Rc::clone(layout), all))
}

/// An object of a class, from the values of its members in their order.
pub(in crate::program::vendor) fn record(
    layout: &Rc<Layout>,
    all: Vec<Value>,
) -> Result<Value, String> {
    if let Some(entry) = &layout.entry {
        return map_entry::made(layout, entry, all);
    }
    if let [only @ Value::Record(of, _)] = &all[..]
        && (of.is_designated() || of.line().any(|it| it.name == layout.name))
    {
        return object(only.clone(), layout);
    }
    let mut rest = all.into();
    let made = members(layout, &mut rest)?;
    if rest.is_empty() {
        Ok(made)
    } else {
        let name = &layout.name;
        Err(format!(
            "{} too many for `{name}`",
            crate::unit::counted(rest.len(), "value")
        ))
    }
}

fn members(layout: &Rc<Layout>, rest: &mut VecDeque<Value>) -> Result<Value, String> {
    let mut all = Vec::new();
    for member in &layout.members {
        let leaf = member.leaf();
        let braces = matches!(rest.front(), Some(Value::List(_)));
        all.push(match (rest.is_empty(), &member.default) {
            (true, Some(default)) => default.clone(),
            (false, _) if braces => {
                let list = rest.pop_front().unwrap_or(Value::Whole(0));
                shaped(list, &member.lengths, leaf)?
            }
            _ => array(rest, &member.lengths, leaf)?,
        });
    }
    Ok(Value::Record(Rc::clone(layout), all))
}

/// How many values an object with these members holds.
pub(super) fn values(members: &[Member]) -> usize {
    let members = members.iter().map(|member| {
        let one = member.layout.as_ref().map_or(1, |it| it.values);
        count(one, &member.lengths)
    });
    members.fold(1, usize::saturating_add)
}

impl Member {
    const fn leaf(&self) -> Leaf<'_> {
        Leaf {
            kind: self.kind,
            layout: self.layout.as_ref(),
            library: false,
            text: self.text,
        }
    }
}

/// How many values an array of these lengths holds, of so many each; an empty one is made as well.
pub(super) fn count(one: usize, lengths: &[Option<usize>]) -> usize {
    let known = lengths.iter().flatten();
    known.fold(one, |all, it| all.saturating_mul((*it).max(1)))
}

/// An object to whose members nothing was assigned.
pub(in crate::program::vendor) fn fresh(layout: &Rc<Layout>, empty: &Value) -> Value {
    let all = layout.members.iter().map(|member| {
        let one = match (&member.default, &member.layout) {
            (Some(default), _) => return default.clone(),
            (None, Some(layout)) => fresh(layout, empty),
            (None, None) if member.text => Value::Text("".into()),
            (None, None) => empty.clone(),
        };
        let nested = member.lengths.iter().rev();
        nested.fold(one, |one, length| {
            Value::List(vec![one; length.unwrap_or(0)])
        })
    });
    Value::Record(Rc::clone(layout), all.collect())
}

/// The bytes that a value takes, and the multiple of bytes at which it lies; nothing where its type
/// is not known.
pub(in crate::program::vendor) fn size(value: &Value, kind: Kind) -> Option<(i64, i64)> {
    match value {
        Value::List(all) => {
            let (bytes, step) = size(all.first()?, kind)?;
            Some((bytes * all.len() as i64, step))
        }
        Value::Record(layout, _) if layout.entry.is_some() => None,
        Value::Record(layout, all) => {
            let (mut end, mut steps) = (0_i64, 1);
            for (member, value) in layout.members.iter().zip(all) {
                let (bytes, step) = size(value, member.kind)?;
                end = above(end, step) + bytes;
                steps = steps.max(step);
            }
            Some((above(end, steps), steps))
        }
        Value::Text(text) => Some((text.len() as i64 + 1, 1)),
        // A register, or a direction: an enumeration of the vendor's.
        Value::Symbol(_) => Some((4, 4)),
        Value::Whole(_)
        | Value::Wide(..)
        | Value::Real(_)
        | Value::Single(_)
        | Value::Unknown(_) => {
            let kind = if kind == Kind::Any {
                value.kind()
            } else {
                kind
            };
            kind.bytes().map(|bytes| (bytes, bytes))
        }
        _ => None,
    }
}

/// The first multiple of `step` that is not less.
const fn above(bytes: i64, step: i64) -> i64 {
    (bytes + step - 1) / step * step
}

/// The numbers of a value as a type holds them.
pub(in crate::program::vendor) fn deep(value: Value, kind: Kind) -> Value {
    match value {
        Value::List(all) => Value::List(all.into_iter().map(|it| deep(it, kind)).collect()),
        other => other.converted(kind),
    }
}
