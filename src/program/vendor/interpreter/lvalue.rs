//! Where expressions lead: variables, elements and members, and what is loaded from and stored
//! there.

use std::rc::Rc;

use super::{
    layout::Layout,
    machine::{Location, Machine},
    reason::Reason,
    shape,
    value::{Slot, Value, moved},
};
use crate::{
    config::Fault,
    program::vendor::{
        analysis::effects,
        host::vendors,
        syntax::tree::{Expr, ExprNode, Kind, last},
    },
};

impl Machine<'_> {
    /// Where the value of an expression lies, with all that finding it does.
    pub(in crate::program::vendor) fn reach(&mut self, it: &Expr) -> Reach {
        let reached = self.deeper(it.place, |inner| inner.found(it));
        reached.unwrap_or(Reach::Value(Value::Whole(0)))
    }

    fn found(&mut self, it: &Expr) -> Reach {
        match &it.node {
            ExprNode::Name(name) => match self.named_location(name) {
                Some((slot, path)) => Reach::Location(slot, path),
                None => Reach::Value(self.named_value(name, it.place)),
            },
            ExprNode::Unary("*", of) => match self.value(of) {
                Value::Pointer(slot, path, _) => {
                    let (slot, path) = self.pointed(slot, path);
                    Reach::Location(slot, path)
                }
                Value::Back(slot, path, _) => match moved(&path, -1) {
                    Some(path) => Reach::Location(slot, path),
                    None => Reach::Beyond(-1),
                },
                other @ Value::Record(..) => {
                    let value = self.unary_operator("*", other.into(), it.place);
                    Reach::Value(value)
                }
                Value::Text(text) => character(&text, 0),
                other => Reach::Value(other),
            },
            ExprNode::Index(of, at) => {
                let base = self.reach(of);
                if let Some(Value::Record(layout, _)) = self.reached(&base) {
                    let layout = Rc::clone(layout);
                    return self.indexed(&layout, base, at, it.place);
                }
                let index = self.value(at);
                self.element(base, &index)
            }
            ExprNode::Member(of, name) => {
                let base = self.reach(of);
                self.member(base, name)
            }
            ExprNode::Convert(Kind::Any, of) => self.reach(of),
            ExprNode::Template(given, call) => {
                self.angles = Some(given.clone());
                let reached = self.reach(call);
                self.angles = None;
                reached
            }
            ExprNode::Call(callee, given) => {
                let value = self.call(callee, given, it.place);
                match self.referred.take() {
                    Some((calls, (slot, path))) if calls == self.calls + 1 => {
                        Reach::Location(slot, path)
                    }
                    _ => Reach::Value(value),
                }
            }
            ExprNode::Step(of, by, true) => {
                let reached = self.reach(of);
                let before = self.load(&reached, of);
                let after = self.stepped(&before, &reached, *by, it.place);
                if !matches!(before, Value::Record(..)) {
                    self.store(&reached, after, of);
                }
                reached
            }
            ExprNode::Choose(condition, yes, no) if self.chooses_place(yes, no) => {
                match self.condition(condition).truth() {
                    Ok(holds) => self.reach(if holds { yes } else { no }),
                    Err(_) => Reach::Value(self.value(it)),
                }
            }
            ExprNode::Assign(operator, to, value) => {
                let (value, location) = self.assigned(*operator, to, value, it.place);
                placed(value, location)
            }
            ExprNode::Binary(..) => {
                let (value, location) = self.chain(it);
                placed(value, location)
            }
            _ => Reach::Value(self.value(it)),
        }
    }

    /// Whether both of `c ? yes : no` lie somewhere, and have one type: then so does what is chosen.
    fn chooses_place(&self, yes: &Expr, no: &Expr) -> bool {
        self.kind_of(yes) == self.kind_of(no) && self.has_place(yes) && self.has_place(no)
    }

    /// Whether the value of an expression lies somewhere, as far as the text says it.
    pub(in crate::program::vendor) fn has_place(&self, it: &Expr) -> bool {
        match &it.node {
            ExprNode::Name(_)
            | ExprNode::Member(..)
            | ExprNode::Index(..)
            | ExprNode::Unary("*", _)
            | ExprNode::Assign(..)
            | ExprNode::Step(_, _, true) => true,
            ExprNode::Choose(_, yes, no) => self.chooses_place(yes, no),
            ExprNode::Convert(Kind::Any, of) => self.has_place(of),
            ExprNode::Call(callee, _) => match &callee.node {
                ExprNode::Name(name) => {
                    let all = self.functions.get(last(name)).into_iter().flatten();
                    let mut all = all.chain(self.members.get(last(name)).into_iter().flatten());
                    all.any(|it| it.refers)
                }
                ExprNode::Member(_, name) => {
                    matches!(&**name, "front" | "back" | "at")
                        || effects::members(self, name).iter().any(|it| it.refers)
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Where a pointer leads.
    pub(in crate::program::vendor) fn pointed(&self, slot: Slot, mut path: Vec<usize>) -> Location {
        let array = matches!(self.slots[slot], Value::List(_));
        if path.is_empty() && array && !self.copied.contains(&slot) {
            path.push(0);
        }
        (slot, self.carried(slot, path))
    }

    /// A place beyond the end of a row, as one in the rows behind it: that is how they lie in
    /// memory.
    fn carried(&self, slot: Slot, mut path: Vec<usize>) -> Vec<usize> {
        for level in (1..path.len()).rev() {
            let (above, below) = path.split_at(level);
            let (Some(Value::List(row)), Some(Value::List(_))) =
                (self.peek(slot, above), self.peek(slot, &above[..level - 1]))
            else {
                break;
            };
            if row.is_empty() || below[0] < row.len() {
                break;
            }
            let length = row.len();
            path[level - 1] += path[level] / length;
            path[level] %= length;
        }
        path
    }

    /// Whether a pointer to an element lies there: its elements are those behind it.
    fn is_inner(&self, base: &Reach) -> bool {
        matches!(self.reached(base), Some(Value::Pointer(_, path, _)) if !path.is_empty())
    }

    /// The value that was reached, where it is known which.
    pub(in crate::program::vendor) fn reached<'v>(&'v self, reach: &'v Reach) -> Option<&'v Value> {
        match reach {
            Reach::Location(slot, path) => self.peek(*slot, path),
            Reach::Value(value) => Some(value),
            Reach::Lost(..) | Reach::Beyond(_) => None,
        }
    }

    fn element(&mut self, base: Reach, index: &Value) -> Reach {
        let inner = self.is_inner(&base);
        let base = self.through(base);
        if let Some(why) = self.not_followed(&base) {
            return Reach::Value(Value::Unknown(why));
        }
        let Some(at) = index.whole() else {
            let why = match index {
                Value::Unknown(why) => why.clone(),
                other => format!("the element {}", other.describe()).into(),
            };
            return match base {
                Reach::Location(slot, path) => Reach::Lost(slot, path, why),
                _ => Reach::Value(Value::Unknown(why)),
            };
        };
        match base {
            Reach::Location(slot, path) if inner => match moved(&path, at) {
                Some(path) => Reach::Location(slot, self.carried(slot, path)),
                None => Reach::Beyond(at),
            },
            Reach::Location(slot, mut path) => {
                let held = self.peek(slot, &path);
                if let Some(Value::Text(text)) = held {
                    return character(text, at);
                }
                let nested = matches!(held, Some(Value::List(_)));
                if !nested && path.is_empty() && at == 0 {
                    return Reach::Location(slot, path);
                }
                let known = usize::try_from(at);
                if let (true, Ok(at)) = (nested, known) {
                    path.push(at);
                    return Reach::Location(slot, path);
                }
                match moved(&path, at) {
                    Some(path) if !nested => Reach::Location(slot, path),
                    _ => Reach::Beyond(at),
                }
            }
            Reach::Value(Value::List(all)) => {
                let found = usize::try_from(at).ok().and_then(|at| all.get(at).cloned());
                found.map_or(Reach::Beyond(at), Reach::Value)
            }
            Reach::Value(Value::Text(text)) => character(&text, at),
            Reach::Value(Value::Unknown(why)) => Reach::Value(Value::Unknown(why)),
            Reach::Value(_) => {
                Reach::Value(Value::Unknown("an element known only at run time".into()))
            }
            lost => lost,
        }
    }

    /// Where a pointer that lies somewhere leads; anything else stays where it is.
    pub(in crate::program::vendor) fn through(&self, base: Reach) -> Reach {
        match self.reached(&base) {
            Some(Value::Pointer(slot, path, _)) => Reach::Location(*slot, path.clone()),
            Some(Value::Back(slot, path, _)) => match moved(path, -1) {
                Some(path) => Reach::Location(*slot, path),
                None => Reach::Beyond(-1),
            },
            _ => base,
        }
    }

    pub(in crate::program::vendor) fn member(&mut self, base: Reach, name: &str) -> Reach {
        // No class has something under a name of its base.
        let name = last(name);
        let mut base = self.through(base);
        if matches!(base, Reach::Lost(..) | Reach::Beyond(_)) {
            return base;
        }
        // A pointer to an array of objects leads to the first.
        if let (Reach::Location(_, path), Some(Value::List(all))) = (&base, self.reached(&base))
            && path.is_empty()
            && matches!(all.first(), Some(Value::Record(..)))
            && let Reach::Location(slot, _) = base
        {
            base = Reach::Location(slot, vec![0]);
        }
        let at = match self.reached(&base) {
            // The words of a register, which are only ever compared.
            Some(Value::Symbol(register))
                if matches!(base, Reach::Value(_)) || self.register_kind(register).is_some() =>
            {
                return Reach::Value(Value::Symbol(format!("{register}.{name}").into()));
            }
            Some(Value::Record(layout, all)) => {
                let named = layout.members.iter().position(|it| &*it.name == name);
                named.or_else(|| name.parse().ok().filter(|at| *at < all.len()))
            }
            Some(Value::List(_)) => match numbered(name) {
                // An array of an object that is not known, such as that of a frame. Of an empty one
                // nothing is.
                None if !matches!(self.reached(&base), Some(Value::List(all)) if all.is_empty()) => {
                    return base;
                }
                at => at,
            },
            _ => None,
        };
        match (at, base) {
            (Some(at), Reach::Location(slot, mut path)) => {
                path.push(at);
                Reach::Location(slot, path)
            }
            (Some(at), Reach::Value(Value::List(mut all) | Value::Record(_, mut all)))
                if at < all.len() =>
            {
                Reach::Value(all.swap_remove(at))
            }
            (_, base) => Reach::Value(Value::Unknown(self.no_member(&base, name))),
        }
    }

    /// Why nothing is known of a member.
    fn no_member(&self, base: &Reach, name: &str) -> Reason {
        if let Some(why) = self.not_followed(base) {
            return why;
        }
        if let Some(Value::Unknown(why @ Reason::Never(_))) = self.reached(base) {
            return why.clone();
        }
        match self.reached(base) {
            Some(Value::Record(layout, _))
                if !layout.names(name) && !self.is_shared(layout, name) =>
            {
                Reason::never(&format!(
                    "`{name}`, which is not a member of `{}`",
                    layout.name
                ))
            }
            _ => format!("`{name}` of an object").into(),
        }
    }

    /// Whether all objects of a class share it, as constants and functions that are `static`.
    fn is_shared(&self, layout: &Layout, name: &str) -> bool {
        self.find(&format!("{}::{name}", layout.name)).is_some()
            || self.functions.contains_key(name)
    }

    /// Why nothing is known of a variable, where its class is not supported.
    pub(super) fn not_followed(&self, base: &Reach) -> Option<Reason> {
        match base {
            Reach::Location(slot, _) => self.not_followed.get(slot).cloned(),
            _ => None,
        }
    }

    /// The value that lies where something was reached.
    pub(in crate::program::vendor) fn load(&mut self, reached: &Reach, it: &Expr) -> Value {
        match reached {
            Reach::Location(..) if self.beyond(reached, it) => Value::Whole(0),
            Reach::Location(slot, path) => {
                let name = base_name(it);
                match self.decayed(*slot, path, &name) {
                    Value::Unknown(why) if matches!(it.node, ExprNode::Name(_)) => {
                        self.set(&name).unwrap_or(Value::Unknown(why))
                    }
                    other => other,
                }
            }
            Reach::Lost(_, _, why) => Value::Unknown(why.clone()),
            Reach::Value(value) => value.clone(),
            Reach::Beyond(_) => {
                self.beyond(reached, it);
                Value::Whole(0)
            }
        }
    }

    /// Tells of an element that an array does not have; whether it is one.
    fn beyond(&mut self, reached: &Reach, it: &Expr) -> bool {
        let (index, length) = match reached {
            Reach::Beyond(index) => (*index, None),
            Reach::Location(slot, path) => {
                let (Some(index), held) = (path.last(), path.len().saturating_sub(1)) else {
                    return false;
                };
                match self.peek(*slot, &path[..held]) {
                    // The length of an empty one is not known.
                    Some(Value::List(all)) if *index >= all.len() && !all.is_empty() => {
                        (*index as i64, Some(all.len()))
                    }
                    None | Some(Value::List(_) | Value::Record(..) | Value::Unknown(_)) => {
                        return false;
                    }
                    _ if *index == 0 => return false,
                    _ => (*index as i64, Some(1)),
                }
            }
            _ => return false,
        };
        let name = base_name(it);
        let has = match length {
            Some(1) => format!("`{name}` has 1 element"),
            Some(length) => format!("`{name}` has {length} elements"),
            None => format!("`{name}` begins with element 0"),
        };
        let message = format!("element {index} is out of bounds: {has}");
        if let (Some(why), None) = (&self.maybe, &self.companion) {
            // The run may have ended before; whatever hangs on it is told of by itself.
            let fault = Fault::warning(
                it.place,
                format!("{message}; whether the run gets here depends on {why}"),
                "this element",
            );
            self.fault(fault.help("`exec --host` runs it, and says where that happens"));
            return true;
        }
        let help = "indices go from 0 to the length minus one";
        self.error(it.place, message, "this element", help);
        true
    }

    /// Stores a value, as a variable of its type holds it, and gives that back.
    pub(in crate::program::vendor) fn store(
        &mut self,
        reached: &Reach,
        value: Value,
        to: &Expr,
    ) -> Value {
        match reached {
            Reach::Location(slot, path) => {
                if self.beyond(reached, to) {
                    return value;
                }
                if matches!(&value, Value::Pointer(of, way, _) if of == slot && way == path) {
                    // A slider that writes the variable that its handle goes to.
                    self.keeps_value(to);
                    return self.at(*slot, path);
                }
                if self.holds_own(&value, &["operator="], to.place) {
                    return value;
                }
                let value = self.separate(value);
                let value = self.fitted(*slot, path, value);
                self.put(*slot, path, value.clone());
                value
            }
            Reach::Lost(slot, path, _) => {
                // An element that is not known: any of them.
                let why: Reason = "which element was written".into();
                self.forget(*slot, path, &why);
                value
            }
            Reach::Beyond(_) => {
                self.beyond(reached, to);
                value
            }
            Reach::Value(Value::Unknown(why))
                if matches!(to.node, ExprNode::Call(..)) || self.chosen(to) =>
            {
                let message = format!("where this is stored depends on {why}");
                self.unknown(to.place, message, why, None);
                value
            }
            // An object, or memory, of which nothing is known.
            Reach::Value(Value::Unknown(_)) => value,
            // A name of several namespaces, as was told.
            Reach::Value(Value::Whole(_)) if matches!(to.node, ExprNode::Name(_)) => value,
            Reach::Value(Value::Symbol(name)) => {
                self.no_variable(&name.clone(), to);
                value
            }
            Reach::Value(_) => {
                self.error(
                    to.place,
                    "this cannot be assigned to".to_owned(),
                    "no variable",
                    "assign to a variable, an element of an array, or a member of an object",
                );
                value
            }
        }
    }

    /// Warns of a variable that takes the handle of the slider which writes it.
    fn keeps_value(&mut self, to: &Expr) {
        let name = base_name(to);
        let message = format!("in C++ `{name}` becomes the number of its slider's handle");
        let label = "until somebody moves the slider; here it keeps its value";
        let help = format!("give the handle its own variable: `auto {name}_slider = …;`");
        self.fault(Fault::warning(to.place, message, label).help(help));
    }

    fn no_variable(&mut self, name: &str, to: &Expr) {
        let base = name.split('.').next().unwrap_or(name);
        if self.device.value_of(base).is_some() {
            self.error(
                to.place,
                format!("`{name}` is a register: C++ does not assign to it"),
                "here",
                &format!("write `mov({name}, x);`, or `scamp5_in({name}, value);`"),
            );
        } else if !vendors(name) {
            self.error(
                to.place,
                format!("`{name}` is not declared"),
                "a variable is needed here",
                &format!("declare it: `int {name} = …;`"),
            );
        }
    }

    /// A value as the variable that it goes to holds it.
    fn fitted(&self, slot: Slot, path: &[usize], value: Value) -> Value {
        let object = |it: &Value| matches!(it, Value::List(_) | Value::Record(..));
        let (before, text) = (self.peek(slot, path), self.string_at(slot, path));
        let mut kind = self.kind_at(slot, path);
        if kind == Kind::Any {
            // `auto`: of the type that it began with.
            kind = before.map_or(Kind::Any, Value::kind);
        }
        match (before, value) {
            // An array of the language's library is copied whole.
            (Some(Value::List(_)), Value::Pointer(from, path, _)) => self.at(from, &path),
            (Some(Value::Record(layout, _)), value) if object(&value) => {
                let made = shape::object(value, layout);
                let made = made.unwrap_or_else(|why| Value::Unknown(Reason::never(&why)));
                self.with_texts(made, false)
            }
            (Some(Value::List(_)), value) if text => self.with_texts(value, true),
            (_, value @ Value::List(_)) if text && self.is_library(slot, path) => {
                self.with_texts(value, true)
            }
            (_, value) if text => self.string_of(value),
            (_, value) => shape::deep(value, kind),
        }
    }
}

/// Where an expression leads.
pub(in crate::program::vendor) enum Reach {
    Location(Slot, Vec<usize>),
    /// Some element of an array: why it is not known which.
    Lost(Slot, Vec<usize>, Reason),
    /// An element that no array has.
    Beyond(i64),
    /// A value that lies nowhere.
    Value(Value),
}

/// A member of a pair, or the name that a structured binding has for one.
fn numbered(name: &str) -> Option<usize> {
    match name {
        "first" => Some(0),
        "second" => Some(1),
        name => name.parse().ok(),
    }
}

/// A character of a text, which ends with a 0.
fn character(text: &str, at: i64) -> Reach {
    let found = usize::try_from(at).ok();
    let found = found.and_then(|at| text.bytes().chain([0]).nth(at));
    found.map_or(Reach::Beyond(at), |code| {
        Reach::Value(Value::Whole(i64::from(code as i8)))
    })
}

/// A value, and where it lies if it lies somewhere.
fn placed(value: Value, location: Option<Location>) -> Reach {
    match location {
        Some((slot, path)) => Reach::Location(slot, path),
        None => Reach::Value(value),
    }
}

/// The name that an expression begins with.
pub(in crate::program::vendor) fn base_name(it: &Expr) -> String {
    match &it.node {
        ExprNode::Name(name) => last(name).to_owned(),
        ExprNode::Member(of, _)
        | ExprNode::Index(of, _)
        | ExprNode::Unary(_, of)
        | ExprNode::Convert(_, of)
        | ExprNode::Recast(_, of) => base_name(of),
        ExprNode::Binary(_, left, _) => base_name(left),
        ExprNode::Call(callee, _) => base_name(callee),
        _ => "buffer".to_owned(),
    }
}
