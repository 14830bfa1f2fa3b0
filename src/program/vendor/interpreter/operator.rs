//! Operators of classes, and of the pairs and maps of the language's library.

use std::rc::Rc;

use super::{
    call::{Argument, Named},
    layout::Layout,
    lvalue::Reach,
    machine::{Location, Machine},
    value::Value,
};
use crate::{
    config::Place,
    program::vendor::syntax::tree::{Expr, ExprNode, Function, Kind, Word, last},
};

/// Operators that compare.
pub(in crate::program::vendor) const COMPARED: [&str; 6] = [
    "operator==",
    "operator!=",
    "operator<",
    "operator>",
    "operator<=",
    "operator>=",
];

impl Machine<'_> {
    /// Two values under an operator, of which one is an object.
    pub(in crate::program::vendor) fn binary_operator(
        &mut self,
        operator: &str,
        a: Argument,
        b: Argument,
        place: Place,
    ) -> Value {
        if let (Value::Record(one, _), Value::Record(other, _)) = (&a.value, &b.value)
            && one.is_tuple()
            && other.is_tuple()
        {
            if self.holds_own(&a.value, &COMPARED, place) {
                return Value::Whole(0);
            }
            return match (a.value.order(&b.value), operator) {
                (Some(order), "==") => Value::flag(order.is_eq()),
                (Some(order), "!=") => Value::flag(order.is_ne()),
                (Some(order), "<") => Value::flag(order.is_lt()),
                (Some(order), ">") => Value::flag(order.is_gt()),
                (Some(order), "<=") => Value::flag(order.is_le()),
                (Some(order), ">=") => Value::flag(order.is_ge()),
                _ => Value::Unknown(format!("`{operator}` between pairs").into()),
            };
        }
        let described = (a.value.describe(), b.value.describe());
        let given = vec![a, b];
        if operator == "!=" && !self.has_operator("operator!=", &given) {
            let equal = self.operator_call("operator==", given, place);
            return match equal.map(|it| it.truth()) {
                Some(Ok(equal)) => Value::flag(!equal),
                Some(Err(why)) => Value::Unknown(why),
                None => self.no_operator(operator, &described, place),
            };
        }
        let found = self.operator_call(&format!("operator{operator}"), given, place);
        found.unwrap_or_else(|| self.no_operator(operator, &described, place))
    }

    /// An object before an operator, which may change it, and where what comes out lies.
    pub(super) fn object_under(
        &mut self,
        operator: &str,
        (value, location): (Value, Option<Location>),
        right: &Expr,
        place: Place,
    ) -> (Value, Option<Location>) {
        let right = self.argument(right);
        if let Value::Unknown(_) = right.value {
            return (right.value, None);
        }
        let object = Argument {
            kind: value.kind(),
            value,
            location,
            named: Named::Number,
            lost: None,
        };
        self.calls += 1;
        self.referred = None;
        let made = self.binary_operator(operator, object, right, place);
        self.calls -= 1;
        let referred = self.referred.take();
        let referred = referred.filter(|(calls, _)| *calls == self.calls + 1);
        (made, referred.map(|it| it.1))
    }

    /// Whether a value holds objects whose class has one of these operators of its own, which is not
    /// called where the whole is copied or compared; tells of it.
    pub(super) fn holds_own(&mut self, value: &Value, operators: &[&str], place: Place) -> bool {
        let Some((class, operator)) = self.own_operator(value, operators) else {
            return false;
        };
        self.error(
            place,
            format!("`{operator}` of `{class}` is not called for the objects inside this"),
            "objects inside another object or an array",
            "handle the objects in a loop or one by one",
        );
        true
    }

    /// The class and the operator of its own of an object that is in a value.
    pub(in crate::program::vendor) fn own_operator(
        &self,
        value: &Value,
        operators: &[&str],
    ) -> Option<(Word, Word)> {
        let (Value::List(all) | Value::Record(_, all)) = value else {
            return None;
        };
        if let Value::Record(layout, _) = value {
            let own = layout.line().flat_map(|it| it.functions.iter());
            let free = operators.iter().filter_map(|it| self.functions.get(*it));
            let of_class =
                |it: &&Rc<Function>| it.parameters.first().is_some_and(|it| it.of == layout.name);
            let free = free.flatten().filter(of_class);
            let mut both = own.chain(free);
            if let Some(it) = both.find(|it| operators.contains(&&*it.name)) {
                return Some((layout.name.clone(), it.name.clone()));
            }
        }
        all.iter().find_map(|it| self.own_operator(it, operators))
    }

    fn no_operator(&mut self, operator: &str, (a, b): &(String, String), place: Place) -> Value {
        self.error(
            place,
            format!("`{operator}` between {a} and {b}"),
            "no overload of this operator matches",
            &format!("define `operator{operator}` for it, or use a named function"),
        );
        Value::Whole(0)
    }

    /// An operator before an object.
    pub(super) fn unary_operator(&mut self, operator: &str, of: Argument, place: Place) -> Value {
        let described = of.value.describe();
        let name = format!("operator{operator}");
        if let Some(value) = self.operator_call(&name, vec![of], place) {
            return value;
        }
        self.error(
            place,
            format!("`{operator}` before {described}"),
            "no overload of this operator matches",
            &format!("define `{name}` for it, or use a named function"),
        );
        Value::Whole(0)
    }

    /// `++` and `--` of an object.
    pub(in crate::program::vendor) fn step_operator(
        &mut self,
        reached: Reach,
        by: i64,
        prefix: bool,
        place: Place,
    ) -> Value {
        let mut given = vec![self.argument_at(reached)];
        if !prefix {
            given.push(Value::Whole(0).into());
        }
        let name = if by > 0 { "operator++" } else { "operator--" };
        let described = given[0].value.describe();
        let found = self.operator_call(name, given, place);
        found.unwrap_or_else(|| {
            let operator = &name["operator".len()..];
            self.no_operator(operator, &(described, "nothing".to_owned()), place)
        })
    }

    /// `=`, or `+=` and its kin, of an object: what comes out, and where it lies.
    pub(super) fn assign_operator(
        &mut self,
        operator: Option<&str>,
        (reached, to): (Reach, &Expr),
        value: Argument,
        place: Place,
    ) -> (Value, Option<Location>) {
        let name = format!("operator{}=", operator.unwrap_or_default());
        let (target, location) = match &reached {
            Reach::Location(slot, path) => {
                let location = (*slot, path.clone());
                (Reach::Location(*slot, path.clone()), Some(location))
            }
            Reach::Value(value) => (Reach::Value(value.clone()), None),
            Reach::Lost(..) | Reach::Beyond(_) => {
                return (self.store(&reached, value.value, to), None);
            }
        };
        let target = self.argument_at(target);
        let described = (target.value.describe(), value.value.describe());
        if operator.is_none() {
            let Value::Record(layout, _) = &target.value else {
                return (Value::Whole(0), None);
            };
            if !layout
                .line()
                .any(|it| it.functions.iter().any(|it| *it.name == *name))
            {
                return (self.store(&reached, value.value, to), location);
            }
        }
        self.calls += 1;
        self.referred = None;
        let found = self.operator_call(&name, vec![target, value], place);
        self.calls -= 1;
        let referred = self.referred.take();
        let referred = referred.filter(|(calls, _)| *calls == self.calls + 1);
        let value =
            found.unwrap_or_else(|| self.no_operator(&name["operator".len()..], &described, place));
        (value, referred.map(|it| it.1))
    }

    /// An element of an object, by its own operator or that of a map.
    pub(super) fn indexed(
        &mut self,
        layout: &Rc<Layout>,
        base: Reach,
        at: &Expr,
        place: Place,
    ) -> Reach {
        let index = self.argument(at);
        if let Some(entry) = &layout.entry {
            return self.entry_of(base, &entry.clone(), index.value, place);
        }
        let object = self.argument_at(base);
        let described = object.value.describe();
        self.calls += 1;
        self.referred = None;
        let value = self.operator_call("operator[]", vec![object, index], place);
        self.calls -= 1;
        match (value, self.referred.take()) {
            (Some(_), Some((calls, (slot, path)))) if calls == self.calls + 1 => {
                Reach::Location(slot, path)
            }
            (Some(value), _) => Reach::Value(value),
            (None, _) => {
                self.error(
                    place,
                    format!("`[]` of {described}"),
                    "its class has no `operator[]`",
                    "define it, or take an element of an array in it",
                );
                Reach::Value(Value::Whole(0))
            }
        }
    }

    /// Whether an operator fits these.
    fn has_operator(&self, name: &str, given: &[Argument]) -> bool {
        let own = match &given[0].value {
            Value::Record(layout, _) => {
                !self.own_functions(layout, name, given.len() - 1).is_empty()
            }
            _ => false,
        };
        own || self.free_operators(name, given).next().is_some()
    }

    fn free_operators<'o>(
        &'o self,
        name: &str,
        given: &'o [Argument],
    ) -> impl Iterator<Item = &'o Rc<Function>> {
        let all = self.functions.get(name).into_iter().flatten();
        all.filter(|it| {
            let mut pairs = given.iter().zip(it.parameters.iter());
            !it.qualified
                && it.parameters.len() == given.len()
                && pairs.all(|(it, to)| self.cost(it, to).is_some())
        })
    }

    /// Calls an operator of the first one's class, or one that stands for itself; nothing where none
    /// fits.
    fn operator_call(
        &mut self,
        name: &str,
        mut given: Vec<Argument>,
        place: Place,
    ) -> Option<Value> {
        if let Value::Record(layout, _) = &given[0].value {
            let layout = Rc::clone(layout);
            let own = self.own_functions(&layout, name, given.len() - 1);
            let fits = own.iter().any(|it| {
                let mut pairs = given[1..].iter().zip(it.parameters.iter());
                pairs.all(|(it, to)| self.cost(it, to).is_some())
            });
            if fits {
                let object = given.remove(0);
                let location = match object.location {
                    Some(location) => location,
                    None => (self.hold(object.value, Kind::Any), Vec::new()),
                };
                let function = self.overload(name, &own, &given, place)?;
                self.work(place);
                return Some(self.enter_own(&layout, &function, &location, given, place));
            }
        }
        let free: Vec<_> = self.free_operators(name, &given).cloned().collect();
        if free.is_empty() {
            return None;
        }
        let Some(function) = self.overload(name, &free, &given, place) else {
            return Some(Value::Whole(0));
        };
        let lost = { given.iter().zip(function.parameters.iter()) }
            .any(|(it, to)| to.reference && it.location.is_none());
        if lost {
            self.error(
                place,
                format!("`{name}` would change a temporary here"),
                "it takes a reference",
                "give it a variable, in a separate statement",
            );
            return Some(Value::Whole(0));
        }
        self.work(place);
        Some(self.enter_with(&function, given, None, place))
    }

    /// What was reached, as an argument.
    fn argument_at(&mut self, reached: Reach) -> Argument {
        match reached {
            Reach::Location(slot, path) => Argument {
                value: self.at(slot, &path),
                kind: self.kind_at(slot, &path),
                location: Some((slot, path)),
                named: Named::Number,
                lost: None,
            },
            Reach::Value(value) => value.into(),
            Reach::Lost(_, _, why) => Value::Unknown(why).into(),
            Reach::Beyond(_) => Value::Unknown("what lies beyond an array".into()).into(),
        }
    }

    /// `std::tie(a, b) = value`
    pub(super) fn tie(&mut self, members: &[Expr], value: &Expr, place: Place) -> Value {
        let value = self.value(value);
        let all = match &value {
            Value::Record(layout, all) if layout.is_tuple() && all.len() == members.len() => all,
            Value::Unknown(why) => {
                let all = vec![Value::Unknown(why.clone()); members.len()];
                return self.tie_all(members, all);
            }
            other => {
                let message = format!(
                    "`tie` of {} and {}",
                    crate::unit::counted(members.len(), "variable"),
                    other.describe()
                );
                let help = "give it a pair or a tuple with the same number of values";
                self.error(place, message, "this assignment", help);
                return Value::Whole(0);
            }
        };
        self.tie_all(members, all.clone())
    }

    fn tie_all(&mut self, members: &[Expr], all: Vec<Value>) -> Value {
        for (to, value) in members.iter().zip(all) {
            if matches!(&to.node, ExprNode::Name(name) if last(name) == "ignore") {
                continue;
            }
            let reached = self.reach(to);
            self.store(&reached, value, to);
        }
        Value::Whole(0)
    }

    /// `std::make_pair(a, b)`, `std::make_tuple(a, b, c)`
    pub(super) fn tuple(&mut self, name: &str, given: &[Expr]) -> Value {
        let all: Vec<Argument> = given.iter().map(|it| self.argument(it)).collect();
        let pair = name == "make_pair";
        let names = all.iter().enumerate().map(|(at, it)| {
            let name = match (pair, at) {
                (true, 0) => "first".into(),
                (true, _) => "second".into(),
                (false, at) => at.to_string().into(),
            };
            (name, it.kind)
        });
        let mut layout = Layout::of_values(if pair { "pair" } else { "tuple" }, names.collect());
        for (member, it) in layout.members.iter_mut().zip(given) {
            member.text = self.gives_string(it) == Some(true);
        }
        let values = all.into_iter().map(|it| it.value);
        Value::Record(layout.into(), values.collect())
    }

    /// `std::get<1>(value)`
    pub(super) fn got(&mut self, index: &Value, of: &Expr, place: Place) -> Value {
        let reached = self.reach(of);
        let reached = self.through(reached);
        let reached = match index.whole() {
            Some(at) => self.member(reached, &at.to_string()),
            None => Reach::Value(Value::Unknown("a member of a tuple".into())),
        };
        let value = self.load(&reached, of);
        if let Reach::Location(slot, path) = reached {
            self.referred = Some((self.calls, (slot, path)));
        }
        if let Value::Unknown(why) = &value {
            let why = why.clone();
            self.unknown(
                place,
                format!("what `get` returns depends on {why}"),
                &why,
                None,
            );
        }
        value
    }

    /// Where the object lies whose function runs.
    pub(super) fn this(&self) -> Option<Location> {
        match self.find("this").map(|slot| &self.slots[slot]) {
            Some(Value::Pointer(slot, path, _)) => Some((*slot, path.clone())),
            _ => None,
        }
    }
}
