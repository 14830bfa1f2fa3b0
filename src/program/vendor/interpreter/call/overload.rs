//! Which of several functions of a name is meant.

use std::rc::Rc;

use crate::{
    config::Place,
    program::vendor::{
        interpreter::{
            lvalue::Reach,
            machine::{Location, Machine},
            scope::foreign,
            value::Value,
        },
        syntax::tree::{Expr, ExprNode, Function, Kind, Parameter, Word, last, qualifier},
    },
};

impl Machine<'_> {
    /// The functions that a call by this name may mean, the last one first: those of the namespace
    /// that is written before it, else of the one that is worked in, else those of the only one.
    pub(super) fn candidates(
        &mut self,
        name: &str,
        given: usize,
        place: Place,
    ) -> Vec<Rc<Function>> {
        let mut fitting = self.fitting(last(name), given);
        if foreign(name) || fitting.is_empty() {
            return Vec::new();
        }
        let found = self.meant(qualifier(name));
        let found = found
            .iter()
            .find(|space| fitting.iter().any(|it| *it.space == ***space));
        if let Some(space) = found {
            fitting.retain(|it| *it.space == **space);
            return fitting;
        }
        if qualifier(name) == Some("") {
            return Vec::new();
        }
        let first = fitting[0].space.clone();
        if fitting.iter().any(|it| it.space != first) {
            self.several(last(name), place);
            fitting.retain(|it| it.space == first);
        }
        fitting
    }

    /// The namespaces that a name with this one before it may be of, the nearest first.
    pub(super) fn meant(&self, qualified: Option<&str>) -> Vec<String> {
        let Some(qualified) = qualified else {
            let spaces = self.spaces().map(str::to_owned);
            return spaces.chain([String::new()]).collect();
        };
        let inner = self.spaces().map(|space| format!("{space}::{qualified}"));
        let inner = inner.filter(|_| !qualified.is_empty());
        let outer = qualified.trim_start_matches("::").to_owned();
        inner.chain([outer]).collect()
    }

    /// The functions of this name that take so many arguments, the last one first.
    fn fitting(&self, name: &str, given: usize) -> Vec<Rc<Function>> {
        let all = self.functions.get(name).into_iter().flatten();
        // Constructors are called by way of their class.
        let makes = |it: &Function| it.qualified && last(&it.space) == name;
        let fits = |it: &&Rc<Function>| {
            if makes(it) {
                return false;
            }
            let parameters = 0..it.parameters.len();
            let least = parameters
                .filter(|i| self.default(it, *i).is_none())
                .count();
            (least..=it.parameters.len()).contains(&given)
        };
        all.rev().filter(fits).cloned().collect()
    }

    /// The function that fits these arguments best.
    pub(in crate::program::vendor) fn overload(
        &mut self,
        name: &str,
        all: &[Rc<Function>],
        given: &[Argument],
        place: Place,
    ) -> Option<Rc<Function>> {
        if let [one] = all {
            return Some(Rc::clone(one));
        }
        let mut found: Vec<(Vec<u8>, &Rc<Function>)> = Vec::new();
        for function in all {
            let costs = given.iter().zip(function.parameters.iter());
            let costs: Option<Vec<u8>> = costs.map(|(it, to)| self.cost(it, to)).collect();
            found.extend(costs.map(|costs| (costs, function)));
        }
        if found.is_empty() {
            self.error(
                place,
                format!("no overload of `{name}` takes these arguments"),
                "this call",
                "its overloads take other registers or other types",
            );
            return None;
        }
        // One is better where no argument fits it worse, and some fits it better.
        let better = |a: &[u8], b: &[u8]| a.iter().zip(b).all(|(a, b)| a <= b);
        let best = found
            .iter()
            .find(|(costs, _)| found.iter().all(|(other, _)| better(costs, other)));
        let Some((costs, _)) = best else {
            self.unclear(name, place);
            return None;
        };
        let mut equal: Vec<_> = found
            .iter()
            .filter(|it| it.0 == *costs)
            .map(|it| it.1)
            .collect();
        // A template gives way.
        if equal.iter().any(|it| it.template.is_empty()) {
            equal.retain(|it| it.template.is_empty());
        }
        // What is constant is not known.
        let form = |it: &Function| -> Vec<_> {
            let all = it.parameters.iter();
            all.map(|p| (p.written.clone(), p.reference)).collect()
        };
        let function = equal[0];
        if equal.iter().any(|it| form(it) != form(function)) {
            self.unclear(name, place);
            return None;
        }
        Some(Rc::clone(function))
    }

    fn unclear(&mut self, name: &str, place: Place) {
        self.error(
            place,
            format!("the call of `{name}` is ambiguous"),
            "several overloads match",
            "cast the arguments to the types of the overload you mean, such as `(int)x`",
        );
    }

    /// How badly an argument fits a parameter; `None` where it does not.
    pub(in crate::program::vendor) fn cost(&self, it: &Argument, to: &Parameter) -> Option<u8> {
        const EXACT: u8 = 0;
        const PROMOTED: u8 = 1;
        const CONVERTED: u8 = 2;
        const ANY: u8 = 3;
        let pointed = matches!(
            it.value,
            Value::Pointer(..) | Value::Back(..) | Value::List(_) | Value::Text(_)
        );
        match (&it.value, to.kind) {
            (Value::Symbol(name), Kind::Analog | Kind::Digital) => {
                let Some(kind) = self.register_kind(name) else {
                    return Some(ANY);
                };
                (kind == to.kind).then_some(EXACT)
            }
            (Value::Symbol(_), Kind::Any) => Some(CONVERTED),
            (Value::Symbol(name), _) => self.device.value_of(name).is_none().then_some(ANY),
            (Value::Record(layout, _), _) => {
                let of = layout.line().position(|it| it.name == to.of);
                let exact = match of {
                    Some(0) => EXACT,
                    Some(_) => PROMOTED,
                    None => ANY,
                };
                (exact != ANY || to.kind == Kind::Any && !self.layouts.contains_key(&to.of))
                    .then_some(exact)
            }
            (Value::Unknown(_), kind) if it.kind == Kind::Any => {
                (!matches!(kind, Kind::Analog | Kind::Digital)).then_some(CONVERTED)
            }
            _ if pointed => match (to.pointer, to.kind) {
                (true, _) => self.leads(&it.value, to),
                (false, Kind::Any | Kind::Parameter(_)) => Some(CONVERTED),
                _ => None,
            },
            (_, Kind::Analog | Kind::Digital) => None,
            _ if to.pointer => None,
            (_, Kind::Parameter(_)) => Some(EXACT + u8::from(it.kind == Kind::Any)),
            (_, Kind::Any) if self.layouts.contains_key(&to.of) => None,
            (_, Kind::Any) => Some(match &it.named {
                Named::Of(of) if *of == to.of => EXACT,
                // It may be this enumeration: a tie with those that take its number.
                Named::Unclear if !to.of.is_empty() => EXACT,
                _ => ANY,
            }),
            (_, Kind::INT) if matches!(it.named, Named::Of(_)) => Some(PROMOTED),
            (_, kind) if kind == it.kind => Some(EXACT),
            (_, kind) => Some(match (it.kind, kind) {
                (Kind::Flag | Kind::Bits(8 | 16, _), Kind::INT)
                | (Kind::Float | Kind::Real, Kind::Float | Kind::Real) => PROMOTED,
                _ => CONVERTED,
            }),
        }
    }

    /// How badly a pointer or an array fits a pointer to something.
    fn leads(&self, it: &Value, to: &Parameter) -> Option<u8> {
        match it {
            Value::Text(_) => match to.pointee {
                Kind::CHARACTER => Some(0),
                Kind::Any => Some(2),
                _ => None,
            },
            Value::Pointer(slot, path, _) => {
                let (slot, path) = self.pointed(*slot, path.clone());
                match self.peek(slot, &path) {
                    Some(Value::Record(layout, _)) if self.layouts.contains_key(&to.of) => {
                        let at = layout.line().position(|it| it.name == to.of)?;
                        Some(u8::from(at > 0))
                    }
                    _ => match (self.kind_at(slot, &path), to.pointee) {
                        // Pointers to numbers of one type are none to those of another.
                        (held, wanted) if held == wanted => Some(0),
                        (Kind::Any, _) | (_, Kind::Parameter(_)) => Some(0),
                        (_, Kind::Any) => Some(2),
                        _ => None,
                    },
                }
            }
            _ => Some(0),
        }
    }

    /// An argument, with where it lies, evaluated once.
    pub(in crate::program::vendor) fn argument(&mut self, it: &Expr) -> Argument {
        let written = self.kind_of(it);
        let reached = self.reach(it);
        let value = self.load(&reached, it);
        let reached_value = !matches!(reached, Reach::Location(..));
        let lost = match &reached {
            Reach::Lost(slot, path, _) => Some(Lost::Element((*slot, path.clone()))),
            _ if self.chosen(it) => Some(Lost::Choice),
            _ => None,
        };
        let (location, kind) = match reached {
            Reach::Location(slot, path) => {
                let kind = self.kind_at(slot, &path);
                (Some((slot, path)), kind)
            }
            _ => (None, written),
        };
        let plain = value.number().is_some() || matches!(value, Value::Unknown(_));
        let listed = matches!(value, Value::List(_));
        let kind = if kind == Kind::Any || reached_value && !plain && !listed {
            value.kind()
        } else {
            kind
        };
        let named = self.type_name(it, location.as_ref());
        Argument {
            value,
            location,
            kind,
            named,
            lost,
        }
    }

    /// Whether a number is of an enumeration.
    pub(in crate::program::vendor) fn type_name(
        &self,
        it: &Expr,
        location: Option<&Location>,
    ) -> Named {
        let unless = |known| if known { Named::Number } else { Named::Unclear };
        let name = match &it.node {
            ExprNode::Call(callee, _) => match &callee.node {
                ExprNode::Name(name) => last(name),
                _ => "",
            },
            _ => "",
        };
        let mut given = { self.functions.get(name).into_iter().flatten() }.map(|it| &it.gives);
        if let Some(of) = given.next()
            && !of.is_empty()
            && given.all(|it| it == of)
        {
            return Named::Of(of.clone());
        }
        match (&it.node, location) {
            (ExprNode::Convert(kind, _), _) => unless(*kind != Kind::Any),
            (ExprNode::Choose(..), None) => Named::Unclear,
            (ExprNode::Call(..), None) => unless(self.kind_of(it) != Kind::Any),
            (_, None) => Named::Number,
            (_, Some((slot, path))) => {
                let inside =
                    |end| matches!(self.peek(*slot, &path[..end]), Some(Value::Record(..)));
                let of = self.classes.get(slot);
                match of.filter(|_| !(0..path.len()).any(inside)) {
                    Some(of) if of.is_empty() => Named::Unclear,
                    Some(of) => Named::Of(of.clone()),
                    None => unless(self.kind_at(*slot, path) != Kind::Any),
                }
            }
        }
    }
}

impl From<Value> for Argument {
    /// A value that lies nowhere.
    fn from(value: Value) -> Self {
        let kind = value.kind();
        Self {
            value,
            location: None,
            kind,
            named: Named::Unclear,
            lost: None,
        }
    }
}

/// What a function is given: its value, where that lies, its type.
pub(in crate::program::vendor) struct Argument {
    pub value: Value,
    pub location: Option<Location>,
    pub kind: Kind,
    pub named: Named,
    pub lost: Option<Lost>,
}

/// Where a value lies of which only the run knows the place.
pub(in crate::program::vendor) enum Lost {
    /// Some element in this.
    Element(Location),
    /// One variable or another.
    Choice,
}

/// What the type of a number is called.
pub(in crate::program::vendor) enum Named {
    /// It is no enumeration.
    Number,
    /// It has a name, such as that of an enumeration.
    Of(Word),
    /// It may be an enumeration.
    Unclear,
}
