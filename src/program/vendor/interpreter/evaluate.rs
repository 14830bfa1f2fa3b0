//! Values of expressions.

use std::rc::Rc;

use super::{
    layout::Layout,
    lvalue::{Reach, base_name},
    machine::{Flow, Location, Machine},
    operator::COMPARED,
    scope::foreign,
    shape,
    value::{Slot, Value, unassigned},
};
use crate::{
    config::{Place, suggestion},
    program::vendor::{
        analysis::effects,
        host::vendors,
        lexer::constant,
        syntax::{
            tree::{Declared, Expr, ExprNode, Function, Kind, Width, Word, last},
            walk::tied,
        },
    },
};

impl Machine<'_> {
    /// The value of an expression, with all that it does.
    pub(in crate::program::vendor) fn value(&mut self, it: &Expr) -> Value {
        let value = self.deeper(it.place, |inner| inner.evaluated(it));
        value.unwrap_or(Value::Whole(0))
    }

    fn evaluated(&mut self, it: &Expr) -> Value {
        match &it.node {
            ExprNode::Whole(value) => Value::Whole(*value),
            ExprNode::Wide(value, width) => Value::Wide(*value, *width),
            ExprNode::Real(value) => Value::Real(*value),
            ExprNode::Text(text) => Value::Text(text.clone()),
            ExprNode::Name(name) => self.named_value(name, it.place),
            ExprNode::Call(callee, given) => self.call(callee, given, it.place),
            ExprNode::Member(..) | ExprNode::Index(..) | ExprNode::Unary("*", _) => {
                let reached = self.reach(it);
                self.load(&reached, it)
            }
            ExprNode::Unary(operator, of) => self.unary(operator, of, it.place),
            ExprNode::Step(of, by, prefix) => {
                let reached = self.reach(of);
                let before = self.load(&reached, of);
                if let Value::Record(..) = before {
                    return self.step_operator(reached, *by, *prefix, it.place);
                }
                let after = self.stepped(&before, &reached, *by, it.place);
                let after = self.store(&reached, after, of);
                if *prefix { after } else { before }
            }
            ExprNode::Binary(..) => self.chain(it).0,
            ExprNode::Assign(operator, to, value) => {
                self.assigned(*operator, to, value, it.place).0
            }
            ExprNode::Choose(condition, yes, no) => match self.condition(condition).truth() {
                Ok(holds) => {
                    let kind = self.kind_of(it);
                    self.value(if holds { yes } else { no }).converted(kind)
                }
                Err(why) => {
                    let parts = (effects::statement(yes), effects::statement(no));
                    self.either(condition, &[&parts.0, &parts.1], &why);
                    self.lose_led(yes, &why);
                    self.lose_led(no, &why);
                    Value::Unknown(why)
                }
            },
            ExprNode::Designated(all) => {
                let names = all.iter().map(|it| it.0.clone()).collect();
                let values = all.iter().map(|(_, it)| self.value(it)).collect();
                Value::Record(Layout::designated(names).into(), values)
            }
            ExprNode::Braces(all) => Value::List(all.iter().map(|it| self.value(it)).collect()),
            ExprNode::Lambda(function) => Value::Lambda(self.closure(function)),
            ExprNode::Block(body) => match self.block(body) {
                Flow::Return(value) => value,
                _ => Value::Whole(0),
            },
            ExprNode::Convert(kind, of) => {
                let kind = self.resolved(*kind);
                match self.value(of) {
                    list @ Value::List(_) => shape::deep(list, kind),
                    value => value.converted(kind),
                }
            }
            ExprNode::Recast(kind, of) => self.recast(*kind, of),
            ExprNode::SizeOf(of) => self.size_of(of),
            ExprNode::New(declared) => self.allocated(declared),
            ExprNode::Template(given, call) => {
                self.angles = Some(given.clone());
                let value = self.value(call);
                self.angles = None;
                value
            }
        }
    }

    /// The bytes of a variable.
    fn size_of(&mut self, of: &Expr) -> Value {
        if let ExprNode::Convert(kind, _) = &of.node
            && let Some(bytes) = self.resolved(*kind).bytes()
        {
            return Value::size_t(bytes);
        }
        let unknown = || Value::Unknown(format!("`sizeof` of `{}`", base_name(of)).into());
        if let ExprNode::Convert(Kind::Parameter(_), _) = &of.node {
            // A type that was not taken from an argument.
            return unknown();
        }
        // Nothing of it runs.
        let named = matches!(
            of.node,
            ExprNode::Name(_)
                | ExprNode::Member(..)
                | ExprNode::Index(..)
                | ExprNode::Unary("*", _)
        );
        if let (false, Some(bytes)) = (named, self.kind_of(of).bytes()) {
            return Value::size_t(bytes);
        }
        // What lies in no variable is as wide as it is written: a character of a text.
        let written = self.kind_of(of);
        let (value, kind) = match self.reach(of) {
            Reach::Location(slot, path) if self.copied.contains(&slot) && path.is_empty() => {
                return unknown();
            }
            Reach::Location(slot, path) => {
                let kind = match (self.kind_at(slot, &path), self.classes.get(&slot)) {
                    (Kind::Any, Some(of)) => self.enumerations.get(of).copied(),
                    (kind, _) => Some(kind),
                };
                (self.at(slot, &path), kind.unwrap_or(Kind::Any))
            }
            Reach::Value(Value::Symbol(class)) if self.layouts.contains_key(&class) => {
                let layout = &self.layouts[&class];
                (shape::fresh(layout, &Value::Whole(0)), Kind::Any)
            }
            Reach::Value(value) => (value, written),
            _ => (self.value(of), written),
        };
        shape::size(&value, kind).map_or_else(unknown, |(bytes, _)| Value::size_t(bytes))
    }

    /// `new`: memory that has no name.
    fn allocated(&mut self, it: &Declared) -> Value {
        self.refuse_reference(it);
        let value = it.value.as_ref().map(|value| self.value(value));
        let empty = if it.lengths.is_empty() {
            Value::Whole(0)
        } else {
            Value::List(Vec::new())
        };
        let layout = self
            .layouts
            .get(&it.of)
            .filter(|_| !it.pointer && it.lengths.is_empty());
        let empty = match layout {
            Some(layout) => shape::fresh(layout, &Value::Unknown(unassigned("an object"))),
            None => empty,
        };
        let value = self.shaped(it, value.unwrap_or(empty));
        let kind = self.resolved(it.kind);
        let slot = self.hold(value, kind);
        Value::Pointer(slot, Vec::new(), "buffer".into())
    }

    /// A name that more than one namespace has.
    pub(super) fn several(&mut self, name: &str, place: Place) {
        self.error(
            place,
            format!("`{name}` is declared in several namespaces"),
            "it is not known which one is meant",
            &format!(
                "write the namespace before it: `space::{name}`, or `::{name}` for the global one"
            ),
        );
    }

    pub(super) fn named_value(&mut self, name: &Word, place: Place) -> Value {
        let Some((slot, path)) = self.named_location(name) else {
            let plain = last(name);
            if self.ambiguous.contains(plain) {
                self.several(plain, place);
                return Value::Whole(0);
            }
            // A function keeps its namespace.
            let own = self.functions.contains_key(plain) && !foreign(name);
            if plain == "VS_LC" && !own {
                return self.loop_counter();
            }
            if let (Some(value), false) = (crate::program::vendor::host::constant(plain), own) {
                return value;
            }
            return Value::Symbol(if own { name.clone() } else { plain.into() });
        };
        match self.decayed(slot, &path, last(name)) {
            Value::Unknown(why) => self.set(last(name)).unwrap_or(Value::Unknown(why)),
            other => other,
        }
    }

    /// Where the value of a name lies.
    pub(in crate::program::vendor) fn named_location(&self, name: &str) -> Option<Location> {
        let slot = self.find(name)?;
        match &self.slots[slot] {
            Value::Reference(slot, path) => Some((*slot, path.clone())),
            _ => Some((slot, Vec::new())),
        }
    }

    /// The value that lies somewhere; an array becomes a pointer to its first element.
    pub(in crate::program::vendor) fn decayed(
        &self,
        slot: Slot,
        path: &[usize],
        name: &str,
    ) -> Value {
        match self.peek(slot, path) {
            Some(Value::List(_)) if !self.is_library(slot, path) => {
                let mut path = path.to_vec();
                if !path.is_empty() {
                    path.push(0);
                }
                Value::Pointer(slot, path, name.into())
            }
            _ => self.at(slot, path),
        }
    }

    pub(in crate::program::vendor) fn or_fault(
        &mut self,
        value: Result<Value, String>,
        place: Place,
    ) -> Value {
        value.unwrap_or_else(|message| {
            let help = if message.contains("past the end of the string") {
                "a string ends with its terminating 0: go no further than `strlen` returns"
            } else {
                "arithmetic is for numbers; registers are added by `add(y, x0, x1);`"
            };
            self.error(place, message, "here", help);
            Value::Whole(0)
        })
    }

    /// A chain of operators, from its left end: without a call for each.
    pub(super) fn chain(&mut self, it: &Expr) -> (Value, Option<Location>) {
        let (mut first, mut links) = (it, Vec::new());
        while let ExprNode::Binary(operator, left, right) = &first.node {
            links.push((*operator, &**left, &**right, first.place));
            first = left;
        }
        let reached = self.reach(first);
        let mut value = self.load(&reached, first);
        let mut location = match reached {
            Reach::Location(slot, path) => Some((slot, path)),
            _ => None,
        };
        while let Some((operator, left, right, place)) = links.pop() {
            if matches!(value, Value::Record(..)) && !matches!(operator, "," | "&&" | "||") {
                (value, location) = self.object_under(operator, (value, location), right, place);
                continue;
            }
            location = None;
            value = self.binary(operator, value, left, right, place);
        }
        (value, location)
    }

    /// An assignment: the value, and where it lies then.
    pub(super) fn assigned(
        &mut self,
        operator: Option<&str>,
        to: &Expr,
        value: &Expr,
        place: Place,
    ) -> (Value, Option<Location>) {
        if operator.is_none()
            && let Some(members) = tied(to)
        {
            return (self.tie(members, value, place), None);
        }
        let argument = self.argument(value);
        if let Some(value) = self.character_set(operator, to, &argument.value, place) {
            return (value, None);
        }
        // Where it lies is found once: that may have effects of its own.
        let reached = self.reach(to);
        if let Some(Value::Record(..)) = self.reached(&reached) {
            return self.assign_operator(operator, (reached, to), argument, place);
        }
        let mut value = argument.value;
        if let Some(operator) = operator {
            let before = self.load(&reached, to);
            let text = operator == "+" && matches!(before, Value::Text(_));
            let character = argument.kind == Kind::CHARACTER;
            match self.gives_string(to) {
                Some(true) if text => value = self.string_of(value),
                None if text && character => value = self.string_of(value),
                _ => {}
            }
            let after = self.arithmetic(operator, &before, &value);
            value = self.or_fault(after, place);
        }
        let value = self.store(&reached, value, to);
        let location = match reached {
            Reach::Location(slot, path) => Some((slot, path)),
            _ => None,
        };
        (value, location)
    }

    fn binary(
        &mut self,
        operator: &str,
        a: Value,
        left: &Expr,
        right: &Expr,
        place: Place,
    ) -> Value {
        // What the left side decides.
        match (operator, a.truth()) {
            ("&&", Ok(false)) => return Value::flag(false),
            ("||", Ok(true)) if a.number().is_some() => return Value::flag(true),
            _ => {}
        }
        if let (Value::Unknown(why), "&&" | "||") = (&a, operator) {
            let part = effects::statement(right);
            if effects::changes(self, &part) || effects::reads(self, &part) {
                self.either(left, &[&part], why);
                return a;
            }
        }
        let b = self.value(right);
        let (a, b) = self.joined(operator, (a, left), (b, right));
        if let (Value::Unknown(why), "&&" | "||") = (&a, operator) {
            effects::forget(self, &effects::statement(right), why);
        }
        match (operator, &a, &b) {
            (",", ..) => return b,
            // What the right side decides alone.
            ("&&", Value::Unknown(_), b) if b.truth() == Ok(false) => return Value::flag(false),
            ("||", Value::Unknown(_), b) if b.number().is_some() && b.truth() == Ok(true) => {
                return Value::flag(true);
            }
            _ => {}
        }
        self.operated(operator, (a, left.place), (b, right.place), place)
    }

    /// Two values under an operator.
    pub(in crate::program::vendor) fn operated(
        &mut self,
        operator: &str,
        (a, left): (Value, Place),
        (b, right): (Value, Place),
        place: Place,
    ) -> Value {
        if let (Value::Record(..), _) | (_, Value::Record(..)) = (&a, &b)
            && !matches!((&a, &b), (Value::Unknown(_), _) | (_, Value::Unknown(_)))
        {
            return self.binary_operator(operator, a.into(), b.into(), place);
        }
        if let (Value::List(_), Value::List(_)) = (&a, &b)
            && self.holds_own(&a, &COMPARED, place)
        {
            return Value::Whole(0);
        }
        let single =
            matches!(operator, "&&" | "||") || a.number().is_some() != b.number().is_some();
        if single && (self.no_number(&a, left) || self.no_number(&b, right)) {
            return Value::Whole(0);
        }
        let (a, b) = (self.canonical(a), self.canonical(b));
        // Directions and displays are joined by their names.
        let joined = matches!(operator, "|" | "+") && a.number().is_none() && b.number().is_none();
        let named = joined || matches!(operator, "==" | "!=" | "&&" | "||");
        for (value, at) in [(&a, left), (&b, right)] {
            match value {
                Value::Symbol(name) if !named => {
                    self.undeclared(&name.clone(), place);
                    return Value::Whole(0);
                }
                Value::Symbol(name) if !joined && !self.known(name) => {
                    return self.unheard(&name.clone(), at);
                }
                _ => {}
            }
        }
        let value = match (&a, &b) {
            (Value::Pointer(one, from, _), Value::Pointer(other, to, _)) if one == other => {
                self.between(operator, (*one, from, to))
            }
            (Value::Back(one, from, _), Value::Back(other, to, _)) if one == other => {
                self.between(operator, (*one, to, from))
            }
            _ => self.arithmetic(operator, &a, &b),
        };
        self.or_fault(value, place)
    }

    /// Arithmetic; a pointer that moves by what only the run knows may lead to any element.
    fn arithmetic(&mut self, operator: &str, a: &Value, b: &Value) -> Result<Value, String> {
        if let (Value::Pointer(slot, ..) | Value::Back(slot, ..), Value::Unknown(why))
        | (Value::Unknown(why), Value::Pointer(slot, ..)) = (a, b)
            && matches!(operator, "+" | "-")
        {
            self.lose(*slot, why);
        }
        Value::binary(operator, a, b)
    }

    /// Whether a name is one of the chip's, or of a function or class of the file.
    pub(in crate::program::vendor) fn known(&self, name: &str) -> bool {
        let base = name.split('.').next().unwrap_or(name);
        self.device.value_of(base).is_some()
            || !self.device.callables(base).is_empty()
            || self.functions.contains_key(base)
            || self.layouts.contains_key(base)
    }

    /// A name that nothing declares, where its value decides: a constant of the vendor's has one that
    /// is not known, others are faults.
    pub(in crate::program::vendor) fn unheard(&mut self, name: &str, place: Place) -> Value {
        if vendors(name) {
            return Value::Unknown(format!("`{name}`").into());
        }
        self.undeclared(name, place);
        Value::Whole(0)
    }

    /// Pointers into one variable under an operator: by how many elements they lie apart.
    fn between(
        &self,
        operator: &str,
        (slot, from, to): (Slot, &[usize], &[usize]),
    ) -> Result<Value, String> {
        // An array is a pointer to its first element.
        let [from, to] = [from, to].map(|path| self.pointed(slot, path.to_vec()).1);
        let same_array = from.len() == to.len()
            && from.split_last().map(|it| it.1) == to.split_last().map(|it| it.1);
        let [from, to] = if same_array {
            [from, to].map(|path| path.last().copied().unwrap_or(0) as i64)
        } else {
            [from, to].map(|path| self.offset(slot, &path))
        };
        match operator {
            "-" => Ok(Value::Wide(from - to, Width::Long)),
            "<" | ">" | "<=" | ">=" | "==" | "!=" => constant::apply(operator, from, to)
                .map(Value::Whole)
                .ok_or_else(|| format!("`{operator}` between pointers")),
            _ => Err(format!("`{operator}` between pointers")),
        }
    }

    /// How many numbers lie before an element of a variable, row after row and member after member.
    fn offset(&self, slot: Slot, path: &[usize]) -> i64 {
        let (mut value, mut before) = (self.slots.get(slot), 0);
        for index in path {
            match value {
                Some(Value::List(all)) => {
                    let each = all.first().map_or(1, Value::leaves);
                    self.passes(each);
                    before += index * each;
                    value = all.get(*index).or_else(|| all.first());
                }
                Some(Value::Record(_, all)) => {
                    let members = all.iter().take(*index).map(Value::leaves).sum::<usize>();
                    self.passes(members);
                    before += members;
                    value = all.get(*index);
                }
                _ => before += index,
            }
        }
        before as i64
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

    /// Tells of a register that stands where the micro-controller needs a number.
    pub(super) fn no_number(&mut self, value: &Value, place: Place) -> bool {
        use crate::isa::{Bit, Value as Known};
        let Value::Symbol(name) = value else {
            return false;
        };
        let help = match self.device.value_of(name) {
            Some(Known::Source(_)) => format!(
                "test each pixel with `where({name}); … all();`, or read one number: `scamp5_global_sum_fast({name})`"
            ),
            Some(Known::Bit(Bit::Register(_))) => format!(
                "test each pixel with `WHERE({name}); … ALL();`, or read one number: `scamp5_global_or({name})`"
            ),
            Some(Known::Bit(_)) => format!(
                "`where` and `WHERE` select pixels for what follows; read one number with `MOV(R5, {name}); … scamp5_global_or(R5)`"
            ),
            _ => return false,
        };
        let message = format!("`{name}` has one value per pixel");
        self.error(place, message, "one number is needed here", &help);
        true
    }

    pub(in crate::program::vendor) fn undeclared(&mut self, name: &str, place: Place) {
        let scopes = self.scopes.iter().flat_map(|scope| scope.keys());
        let near = suggestion(name, scopes.map(|name| &**name));
        let help = near.unwrap_or_else(|| {
            format!(
                "declare it: `const int {name} = …;`, or put the file that declares it beside this one"
            )
        });
        self.error(
            place,
            format!("`{name}` is not declared"),
            "a number is needed here",
            &help,
        );
    }

    fn unary(&mut self, operator: &str, of: &Expr, place: Place) -> Value {
        if operator == "&" {
            return match self.reach(of) {
                Reach::Location(slot, path) => {
                    let name = base_name(of);
                    Value::Pointer(slot, path, name.into())
                }
                reached => self.load(&reached, of),
            };
        }
        let argument = self.argument(of);
        if let Value::Record(..) = argument.value {
            return self.unary_operator(operator, argument, place);
        }
        match (operator, argument.value) {
            (_, Value::Unknown(why)) => Value::Unknown(why),
            ("!", other) if self.no_number(&other, of.place) => Value::Whole(0),
            ("!", Value::Symbol(name)) if !self.known(&name) => self.unheard(&name, of.place),
            ("!", other) => Value::flag(!other.truth().unwrap_or(true)),
            ("+", other) if other.number().is_none() => other,
            (operator, value) if value.signed(operator).is_some() => {
                value.signed(operator).unwrap_or(Value::Whole(0))
            }
            (_, Value::Symbol(name)) => {
                self.undeclared(&name, place);
                Value::Whole(0)
            }
            (_, other) => {
                let message = format!("`{operator}` before {}", other.describe());
                self.or_fault(Err(message), place)
            }
        }
    }

    /// A lambda with what it takes along: copies, or the variables themselves.
    pub(super) fn closure(&mut self, function: &Rc<Function>) -> Rc<Function> {
        let mut made = (**function).clone();
        made.space = self.space.clone();
        let captures = &function.captures;
        for capture in &captures.named {
            if let Some(value) = &capture.value {
                let slot = match self.reach(value) {
                    Reach::Location(slot, path) if capture.reference && path.is_empty() => slot,
                    Reach::Location(slot, path) if capture.reference => {
                        self.hold(Value::Reference(slot, path), Kind::Any)
                    }
                    reached => {
                        let argument = self.load(&reached, value);
                        self.hold(argument, Kind::Any)
                    }
                };
                made.held.push((capture.name.clone(), slot));
            }
        }
        let this = self.this();
        if captures.object
            && let Some((slot, path)) = &this
            && let value @ Value::Record(..) = self.at(*slot, path)
            && let Value::Record(layout, _) = &value
        {
            let layout = Rc::clone(layout);
            let copy = (self.hold(value, Kind::Any), Vec::new());
            made.held.extend(self.members_of(&layout, &copy));
        }
        let names = effects::names(self, function);
        for name in names.into_iter().chain(["this".into()]) {
            let own = self.scopes.get(self.base.max(1)..).unwrap_or_default();
            let found = own.iter().rev().find_map(|scope| scope.get(&name)).copied();
            let named = captures.named.iter().find(|it| it.name == name);
            let Some(slot) = found.filter(|_| named.is_none_or(|it| it.value.is_none())) else {
                continue;
            };
            // What belongs to the object is taken along with the object.
            let own = matches!((&self.slots[slot], &this), (Value::Reference(of, path), Some((whole, part)))
                if of == whole && path.starts_with(part));
            if captures.object && (own || &*name == "this") {
                continue;
            }
            let copied = !own && named.map_or(captures.copies, |it| !it.reference);
            let slot = if copied { self.copy(slot) } else { slot };
            made.held.push((name, slot));
        }
        Rc::new(made)
    }

    /// A copy of a value: a lambda that changes what it has copied has that for itself.
    pub(super) fn separate(&mut self, value: Value) -> Value {
        let Value::Lambda(function) = &value else {
            return value;
        };
        if !function.captures.mutable {
            return value;
        }
        let mut made = (**function).clone();
        for (name, slot) in &mut made.held {
            let leads = matches!(self.slots[*slot], Value::Reference(..));
            if !leads && made.captures.copies(name) {
                *slot = self.copy(*slot);
            }
        }
        Value::Lambda(made.into())
    }

    /// A variable with the value of another.
    fn copy(&mut self, slot: Slot) -> Slot {
        let (from, path) = match &self.slots[slot] {
            Value::Reference(slot, path) => (*slot, path.clone()),
            _ => (slot, Vec::new()),
        };
        let (value, kind) = (self.at(from, &path), self.kind_at(from, &path));
        let whole = self.copied.contains(&from);
        let text = self.string_at(from, &path);
        let copy = self.hold(value, kind);
        if text {
            self.classes.insert(copy, "string".into());
        }
        if whole {
            self.copied.insert(copy);
        }
        copy
    }
}
