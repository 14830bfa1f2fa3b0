//! Variables: what they hold, and the way to the elements of it.

use std::rc::Rc;

use super::{
    layout::Layout,
    machine::Machine,
    reason::Reason,
    value::{Slot, Value},
};
use crate::{
    isa::{Bit, Source, Value as Known},
    program::vendor::syntax::tree::{Expr, ExprNode, Kind, Word, last},
};

impl Machine<'_> {
    pub(super) fn make(&mut self, name: &Word, value: Value, kind: Kind) -> Slot {
        let slot = self.hold(value, kind);
        self.bind(name, slot);
        slot
    }

    /// A new variable, without a name.
    pub(in crate::program::vendor) fn hold(&mut self, value: Value, kind: Kind) -> Slot {
        let values = value.size();
        self.passes(value.weight());
        let slot = self.free.pop().unwrap_or(self.slots.len());
        if slot == self.slots.len() {
            self.slots.push(value);
            // Frames are run anew with fewer variables.
            self.kinds.truncate(slot);
            self.kinds.push(kind);
        } else {
            self.slots[slot] = value;
            self.kinds[slot] = kind;
        }
        self.copied.remove(&slot);
        self.fixed.remove(&slot);
        self.not_followed.remove(&slot);
        self.classes.remove(&slot);
        self.grows(values);
        slot
    }

    /// A type, with what a template is given in place of its parameter.
    pub(in crate::program::vendor) fn resolved(&self, kind: Kind) -> Kind {
        match kind {
            Kind::Parameter(at) => self.types.get(at).copied().unwrap_or(Kind::Any),
            kind => kind,
        }
    }

    /// The type of a register of this name.
    pub(super) fn register_kind(&self, name: &str) -> Option<Kind> {
        match self.device.value_of(name)? {
            Known::Source(Source::Register(_)) => Some(Kind::Analog),
            Known::Bit(Bit::Register(_)) => Some(Kind::Digital),
            _ => None,
        }
    }

    /// The type of a variable, or of an element.
    pub(in crate::program::vendor) fn kind_at(&self, slot: Slot, path: &[usize]) -> Kind {
        let mut kind = self.kinds.get(slot).copied().unwrap_or(Kind::Any);
        let mut value = self.slots.get(slot);
        for index in path {
            value = match value {
                Some(Value::List(all)) => all.get(*index),
                Some(Value::Record(layout, all)) => {
                    kind = layout.members.get(*index).map_or(Kind::Any, |it| it.kind);
                    all.get(*index)
                }
                other => other,
            };
        }
        kind
    }

    /// Whether an array is one of the language's library, which is copied with its name.
    pub(in crate::program::vendor) fn is_library(&self, slot: Slot, path: &[usize]) -> bool {
        let mut library = self.copied.contains(&slot);
        let mut value = self.slots.get(slot);
        for index in path {
            value = match value {
                Some(Value::List(all)) => all.get(*index),
                Some(Value::Record(layout, all)) => {
                    library = layout.members.get(*index).is_some_and(|it| it.library);
                    all.get(*index)
                }
                other => other,
            };
        }
        library
    }

    /// The class of the elements of an array, where it is known.
    pub(in crate::program::vendor) fn class_at(
        &self,
        slot: Slot,
        path: &[usize],
    ) -> Option<Rc<Layout>> {
        let mut class = self.classes.get(&slot).and_then(|it| self.layouts.get(it));
        let mut value = self.slots.get(slot);
        for index in path {
            value = match value {
                Some(Value::List(all)) => all.get(*index),
                Some(Value::Record(layout, all)) => {
                    class = layout.members.get(*index).and_then(|it| it.layout.as_ref());
                    all.get(*index)
                }
                other => other,
            };
        }
        // As those that are there.
        let first = match value {
            Some(Value::List(all)) => all.first(),
            _ => None,
        };
        match (class, first) {
            (None, Some(Value::Record(layout, _))) => Some(Rc::clone(layout)),
            (class, _) => class.cloned(),
        }
    }

    pub(in crate::program::vendor) fn at(&self, slot: Slot, path: &[usize]) -> Value {
        let beyond = || Value::Unknown("what lies beyond an array".into());
        let value = self.peek(slot, path).cloned().unwrap_or_else(beyond);
        self.passes(value.weight());
        value
    }

    /// The value that lies somewhere; `None` beyond an array or a variable.
    pub(in crate::program::vendor) fn peek(&self, slot: Slot, path: &[usize]) -> Option<&Value> {
        let mut value = &self.slots[slot];
        for index in path {
            value = match value {
                Value::List(all) | Value::Record(_, all) => all.get(*index)?,
                Value::Unknown(_) => return Some(value),
                // A pointer to one value.
                _ if *index == 0 => value,
                _ => return None,
            };
        }
        Some(value)
    }

    pub(in crate::program::vendor) fn put(&mut self, slot: Slot, path: &[usize], value: Value) {
        let values = value.size();
        self.passes(value.weight());
        if let Some(target) = self.target(slot, path) {
            *target = value;
            self.grows(values);
        }
    }

    /// Where something can be written; `None` beyond an array, or where nothing is known for good.
    pub(in crate::program::vendor) fn target(
        &mut self,
        slot: Slot,
        path: &[usize],
    ) -> Option<&mut Value> {
        if self.fixed.contains(&slot) {
            return None;
        }
        let mut target = &mut self.slots[slot];
        for index in path {
            match target {
                Value::List(all) | Value::Record(_, all) => target = all.get_mut(*index)?,
                Value::Unknown(_) => return None,
                _ => break,
            }
        }
        Some(target)
    }

    /// The array that a pointer leads into, the element that it leads to, and the array's length.
    pub(in crate::program::vendor) fn array_of<'p>(
        &self,
        slot: Slot,
        path: &'p [usize],
    ) -> Option<(&'p [usize], usize, usize)> {
        let (first, array) = path
            .split_last()
            .map_or((0, path), |(at, array)| (*at, array));
        match self.peek(slot, array) {
            Some(Value::List(all)) => Some((array, first, all.len())),
            _ => None,
        }
    }

    /// Forgets what lies where a pointer leads, and in its array behind that.
    pub(in crate::program::vendor) fn forget_from(
        &mut self,
        slot: Slot,
        path: &[usize],
        why: &Reason,
    ) {
        let Some((array, first, length)) = self.array_of(slot, path) else {
            self.forget(slot, path, why);
            return;
        };
        for at in first..length {
            self.forget(slot, &[array, &[at]].concat(), why);
        }
    }

    /// A pointer may lead there of which only the run knows where it leads: nothing is known of the
    /// variable for good.
    pub(in crate::program::vendor) fn lose(&mut self, slot: Slot, why: &Reason) {
        if self.copied.contains(&slot) {
            self.put(slot, &[], Value::Unknown(why.clone()));
        } else {
            self.forget(slot, &[], why);
        }
        self.fixed.insert(slot);
    }

    /// Nothing is known of what a pointer leads to, which may be one of several.
    pub(in crate::program::vendor) fn lose_led(&mut self, it: &Expr, why: &Reason) {
        for slot in self.leads_to(it) {
            self.lose(slot, why);
        }
    }

    /// The variables that a pointer leads to, as far as its text says.
    pub(in crate::program::vendor) fn leads_to(&self, it: &Expr) -> Vec<Slot> {
        match &it.node {
            ExprNode::Unary("&", of) => self.lies(of).into_iter().map(|it| it.0).collect(),
            ExprNode::Binary("+" | "-", a, b) | ExprNode::Choose(_, a, b) => {
                [self.leads_to(a), self.leads_to(b)].concat()
            }
            ExprNode::Convert(_, of) | ExprNode::Recast(_, of) => self.leads_to(of),
            _ => self.led_by(it).into_iter().collect(),
        }
    }

    fn led_by(&self, it: &Expr) -> Option<Slot> {
        let (slot, path) = self.lies(it)?;
        match self.peek(slot, &path)? {
            Value::Pointer(slot, ..) | Value::Back(slot, ..) => Some(*slot),
            Value::List(_) if !self.is_library(slot, &path) => Some(slot),
            _ => None,
        }
    }

    /// Whether it is one variable or another: a choice, or what a function gives back.
    pub(super) fn chosen(&self, it: &Expr) -> bool {
        match &it.node {
            ExprNode::Choose(..) => true,
            ExprNode::Member(of, _) | ExprNode::Index(of, _) => self.chosen(of),
            ExprNode::Call(callee, _) => match &callee.node {
                ExprNode::Name(name) => {
                    { self.functions.get(last(name)).into_iter().flatten() }.any(|it| it.refers)
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Makes a value, and all that is in it, one that only the run knows.
    pub(in crate::program::vendor) fn forget(&mut self, slot: Slot, path: &[usize], why: &Reason) {
        let value = self.at(slot, path);
        let value = blurred(value, why);
        self.put(slot, path, value);
    }
}

fn blurred(value: Value, why: &Reason) -> Value {
    match value {
        Value::List(all) => Value::List(all.into_iter().map(|it| blurred(it, why)).collect()),
        // Which elements a map has is not known either.
        Value::Record(ref layout, _) if layout.entry.is_some() => Value::Unknown(why.clone()),
        Value::Record(layout, all) => {
            Value::Record(layout, all.into_iter().map(|it| blurred(it, why)).collect())
        }
        _ => Value::Unknown(why.clone()),
    }
}
