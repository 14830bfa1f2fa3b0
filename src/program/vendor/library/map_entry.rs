//! Elements of maps of the language's library: pairs of a key and a value.

use std::{cmp::Ordering, rc::Rc};

use crate::{
    order::Order,
    program::vendor::interpreter::{layout::Layout, shape, value::Value},
};

/// A map of these elements: the first of each key counts.
pub(in crate::program::vendor) fn made(
    layout: &Rc<Layout>,
    entry: &Rc<Layout>,
    all: Vec<Value>,
) -> Result<Value, String> {
    let mut entries: Vec<Value> = Vec::new();
    for it in all {
        let it = shape::object(it, entry)?;
        let Value::Record(..) = it else {
            return Err(format!(
                "{} is not an element of `{}`",
                it.describe(),
                layout.name
            ));
        };
        let key = key_of(&it).and_then(checked);
        let key = key.ok_or_else(|| format!("a key of `{}` that is not known", layout.name))?;
        if !entries.iter().any(|other| same(other, key)) {
            entries.push(it);
        }
    }
    Ok(Value::Record(Rc::clone(layout), entries))
}

/// The key of an element; nothing where it was erased.
pub(super) fn key_of(entry: &Value) -> Option<&Value> {
    match entry {
        Value::Record(_, all) => all.first(),
        _ => None,
    }
}

/// Keys are numbers and texts.
pub(super) fn checked(key: &Value) -> Option<&Value> {
    (key.number().is_some() || matches!(key, Value::Text(_))).then_some(key)
}

/// Whether an element is that of a key.
pub(super) fn same(entry: &Value, key: &Value) -> bool {
    key_of(entry).is_some_and(|it| it.order(key).is_some_and(Ordering::is_eq))
}

/// The places of the elements, by their keys.
pub(super) fn in_order(all: &[Value]) -> Vec<usize> {
    let there = all.iter().enumerate().filter(|it| key_of(it.1).is_some());
    let mut places: Vec<usize> = there.map(|it| it.0).collect();
    places.order_by(|a, b| {
        let keys = key_of(&all[*a]).zip(key_of(&all[*b]));
        keys.and_then(|(a, b)| a.order(b))
            .unwrap_or(Ordering::Equal)
    });
    places
}
