//! Values of expressions.

use std::{rc::Rc, sync::Arc};

use super::{
    look,
    machine::{Flow, Machine, foreign},
    tree::{Expr, ExprNode, last},
    value::{Slot, Value},
};
use crate::config::{Place, suggestion};

impl Machine<'_> {
    /// The value of an expression, with all that it does.
    pub(super) fn value(&mut self, it: &Expr) -> Value {
        match &it.node {
            ExprNode::Whole(value) => Value::Whole(*value),
            ExprNode::Real(value) => Value::Real(*value),
            ExprNode::Text(text) => Value::Text(text.clone()),
            ExprNode::Name(name) => self.named_value(name, it.place),
            ExprNode::Call(callee, given) => self.call(callee, given, it.place),
            ExprNode::Member(of, name) => self.member(of, name),
            ExprNode::Index(..) => match self.target(it, true) {
                Some((slot, path)) => self.at(slot, &path),
                None => Value::Unknown("an element that only the run knows".into()),
            },
            ExprNode::Unary(mark, of) => self.unary(mark, of, it.place),
            ExprNode::Step(of, by, prefix) => {
                let before = self.value(of);
                let after = Value::binary("+", &before, &Value::Whole(*by));
                let after = self.or_fault(after, it.place);
                self.assign(of, after.clone());
                if *prefix { after } else { before }
            }
            ExprNode::Binary(..) => self.chain(it),
            ExprNode::Assign(mark, to, value) => {
                let mut value = self.value(value);
                if let Some(mark) = mark {
                    let before = self.value(to);
                    let after = Value::binary(mark, &before, &value);
                    value = self.or_fault(after, it.place);
                }
                self.assign(to, value.clone());
                value
            }
            ExprNode::Choose(condition, yes, no) => match self.value(condition).truth() {
                Ok(true) => self.value(yes),
                Ok(false) => self.value(no),
                Err(why) => {
                    let (yes, no) = (look::statement(yes), look::statement(no));
                    self.either(condition, &[&yes, &no], &why);
                    Value::Unknown(why)
                }
            },
            ExprNode::Braces(all) => Value::List(all.iter().map(|it| self.value(it)).collect()),
            ExprNode::Lambda(function) => Value::Lambda(Rc::clone(function)),
            ExprNode::Block(body) => match self.block(body) {
                Flow::Return(value) => value,
                _ => Value::Whole(0),
            },
            ExprNode::Convert(kind, of) => self.value(of).converted(*kind),
        }
    }

    /// A name that more than one namespace has.
    pub(super) fn several(&mut self, name: &str, place: Place) {
        self.error(
            place,
            format!("`{name}` is stated in several namespaces"),
            "which of them is not known",
            &format!(
                "write the namespace before it: `space::{name}`, or `::{name}` for that of the file"
            ),
        );
    }

    fn named_value(&mut self, name: &super::tree::Word, place: Place) -> Value {
        let Some(slot) = self.find(name) else {
            let plain = last(name);
            if self.ambiguous.contains(plain) {
                self.several(plain, place);
                return Value::Whole(0);
            }
            // A function keeps its namespace.
            let own = self.functions.contains_key(plain) && !foreign(name);
            return Value::Symbol(if own { name.clone() } else { plain.into() });
        };
        match &self.slots[slot] {
            Value::List(_) => Value::Pointer(slot, Vec::new(), name.clone()),
            Value::Unknown(_) => match self.set(last(name)) {
                Some(value) => value,
                None => self.slots[slot].clone(),
            },
            other => other.clone(),
        }
    }

    pub(super) fn or_fault(&mut self, value: Result<Value, String>, place: Place) -> Value {
        value.unwrap_or_else(|message| {
            self.error(
                place,
                message,
                "here",
                "arithmetic is for numbers; registers are added by `add(y, x0, x1);`",
            );
            Value::Whole(0)
        })
    }

    /// A chain of operators, from its left end: without a call for each.
    fn chain(&mut self, it: &Expr) -> Value {
        let (mut first, mut links) = (it, Vec::new());
        while let ExprNode::Binary(mark, left, right) = &first.node {
            links.push((*mark, &**left, &**right, first.place));
            first = left;
        }
        let mut value = self.value(first);
        while let Some((mark, left, right, place)) = links.pop() {
            value = self.binary(mark, value, left, right, place);
        }
        value
    }

    fn binary(&mut self, mark: &str, a: Value, left: &Expr, right: &Expr, place: Place) -> Value {
        // What the left side decides.
        match (mark, a.truth()) {
            ("&&", Ok(false)) => return Value::flag(false),
            ("||", Ok(true)) if a.number().is_some() => return Value::flag(true),
            _ => {}
        }
        if let (Value::Unknown(why), "&&" | "||") = (&a, mark) {
            let part = look::statement(right);
            if look::changes(self, &part) {
                self.either(left, &[&part], why);
                return a;
            }
        }
        let b = self.value(right);
        if let (Value::Unknown(why), "&&" | "||") = (&a, mark) {
            look::forget(self, &look::statement(right), why);
        }
        match (mark, &a, &b) {
            (",", ..) => return b,
            // What the right side decides alone.
            ("&&", Value::Unknown(_), b) if b.truth() == Ok(false) => return Value::flag(false),
            ("||", Value::Unknown(_), b) if b.number().is_some() && b.truth() == Ok(true) => {
                return Value::flag(true);
            }
            _ => {}
        }
        let (a, b) = (self.canonical(a), self.canonical(b));
        let named = matches!(mark, "==" | "!=" | "&&" | "||")
            || (matches!(mark, "|" | "+") && a.number().is_none() && b.number().is_none());
        for value in [&a, &b] {
            if let (Value::Symbol(name), false) = (value, named) {
                self.unstated(&name.clone(), place);
                return Value::Whole(0);
            }
        }
        let value = Value::binary(mark, &a, &b);
        self.or_fault(value, place)
    }

    /// A register under its own name, so that aliases are equal to it.
    fn canonical(&self, value: Value) -> Value {
        use crate::isa::{Bit, Source, Value as Known};
        let Value::Symbol(name) = &value else {
            return value;
        };
        let (base, member) = name.split_once('.').unwrap_or((name, ""));
        let own = match self.device.value_of(base) {
            Some(Known::Source(Source::Register(register))) => self.device.analog_name(register),
            Some(Known::Bit(Bit::Register(register))) => self.device.digital_name(register),
            _ => return value,
        };
        let own = if member.is_empty() {
            own
        } else {
            format!("{own}.{member}")
        };
        Value::Symbol(own.into())
    }

    pub(super) fn unstated(&mut self, name: &str, place: Place) {
        let scopes = self.scopes.iter().flat_map(|scope| scope.keys());
        let near = suggestion(name, scopes.map(|name| &**name));
        let help = near.unwrap_or_else(|| {
            format!(
                "state it: `const int {name} = …;`, or put the file that states it beside this one"
            )
        });
        self.error(
            place,
            format!("`{name}` is not stated"),
            "a number is needed here",
            &help,
        );
    }

    fn unary(&mut self, mark: &str, of: &Expr, place: Place) -> Value {
        if mark == "&" {
            return match self.target(of, false) {
                Some((slot, path)) => {
                    let name = base_name(of);
                    Value::Pointer(slot, path, name.into())
                }
                None => self.value(of),
            };
        }
        let value = self.value(of);
        match (mark, value) {
            ("*", Value::Pointer(slot, path, _)) => self.at(slot, &path),
            ("*" | "+", other) => other,
            (_, Value::Unknown(why)) => Value::Unknown(why),
            ("!", other) => Value::flag(!other.truth().unwrap_or(true)),
            ("-", Value::Whole(value)) => Value::Whole(-value),
            ("-", Value::Real(value)) => Value::Real(-value),
            ("~", Value::Whole(value)) => Value::Whole(!value),
            (_, Value::Symbol(name)) => {
                self.unstated(&name, place);
                Value::Whole(0)
            }
            (_, other) => {
                let message = format!("`{mark}` before {}", other.describe());
                self.or_fault(Err(message), place)
            }
        }
    }

    fn member(&mut self, of: &Expr, name: &str) -> Value {
        match self.value(of) {
            // The words of a register, which are only ever compared.
            Value::Symbol(register) => Value::Symbol(format!("{register}.{name}").into()),
            value @ (Value::List(_) | Value::Pointer(..)) => value,
            _ => Value::Unknown(format!("`{name}` of an object").into()),
        }
    }

    /// The variable, and the element of it, that an expression stands for.
    pub(super) fn target(&mut self, it: &Expr, reading: bool) -> Option<(Slot, Vec<usize>)> {
        match &it.node {
            ExprNode::Name(name) => {
                let slot = self.find(name)?;
                match &self.slots[slot] {
                    Value::Pointer(slot, path, _) if reading => Some((*slot, path.clone())),
                    _ => Some((slot, Vec::new())),
                }
            }
            ExprNode::Unary("*", of) => match self.value(of) {
                Value::Pointer(slot, path, _) => Some((slot, path)),
                _ => None,
            },
            ExprNode::Index(of, at) => {
                let (slot, mut path) = self.target(of, true)?;
                let index = self.value(at);
                let index = usize::try_from(index.whole()?).ok()?;
                // A pointer into an array counts from where it points.
                let inside = path.last().copied();
                let nested = matches!(self.at(slot, &path), Value::List(_));
                match inside {
                    Some(last) if !nested => {
                        path.pop();
                        path.push(last + index);
                    }
                    _ => path.push(index),
                }
                Some((slot, path))
            }
            ExprNode::Member(of, _) | ExprNode::Convert(_, of) => self.target(of, reading),
            _ => None,
        }
    }

    /// Stores a value.
    pub(super) fn assign(&mut self, to: &Expr, value: Value) {
        if let ExprNode::Name(name) = &to.node {
            match self.find(name) {
                Some(slot) if self.fixed.contains(&slot) => {}
                Some(slot) => {
                    // A variable keeps its type.
                    let value = match (&self.slots[slot], value) {
                        (Value::Whole(_), Value::Real(value)) => Value::Whole(value as i64),
                        (_, value) => value,
                    };
                    self.slots[slot] = value;
                }
                None => {
                    let name = last(name);
                    if self.device.value_of(name).is_some() {
                        self.error(
                            to.place,
                            format!("`{name}` is a register: C++ does not assign to it"),
                            "here",
                            &format!("write `mov({name}, x);`, or `scamp5_in({name}, value);`"),
                        );
                    }
                }
            }
            return;
        }
        match self.target(to, true) {
            Some((slot, path)) => self.put(slot, &path, value),
            None => {
                // An element that is not known: any of them.
                if let ExprNode::Index(of, _) = &to.node
                    && let Some((slot, path)) = self.target(of, true)
                {
                    let why: Arc<str> = "which element was written".into();
                    self.forget(slot, &path, &why);
                }
            }
        }
    }
}

/// The name that an expression begins with.
pub(super) fn base_name(it: &Expr) -> String {
    match &it.node {
        ExprNode::Name(name) => last(name).to_owned(),
        ExprNode::Member(of, _)
        | ExprNode::Index(of, _)
        | ExprNode::Unary(_, of)
        | ExprNode::Convert(_, of) => base_name(of),
        ExprNode::Binary(_, left, _) => base_name(left),
        ExprNode::Call(callee, _) => base_name(callee),
        _ => "buffer".to_owned(),
    }
}
