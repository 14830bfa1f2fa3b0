//! Calls: of functions of the file, of the library, of the chip.

use std::{collections::BTreeMap, rc::Rc, sync::Arc};

use super::{
    evaluate::base_name,
    host::{self, Role},
    look,
    machine::{Flow, Machine, foreign, term},
    tree::{Expr, ExprNode, Function, last, qualifier},
    value::{Value, unassigned},
};
use crate::{
    config::{Fault, Place},
    isa::text::Term,
};

/// Calls inside each other.
const DEPTH: usize = 64;

impl Machine<'_> {
    pub(super) fn call(&mut self, callee: &Expr, given: &[Expr], place: Place) -> Value {
        self.work(place);
        if let (
            [
                Expr {
                    node: ExprNode::Lambda(function),
                    ..
                },
            ],
            true,
        ) = (given, self.takes_kernel(callee))
        {
            // A kernel that is stated here: it runs when it is launched.
            let value = Value::Lambda(Rc::clone(function));
            self.assign(callee, value.clone());
            return value;
        }
        let name = match &callee.node {
            ExprNode::Name(name) => name.clone(),
            ExprNode::Lambda(function) => {
                let function = Rc::clone(function);
                return self.enter(&function, given, place, false);
            }
            // A function of an object: of a clock, a generator, a list.
            ExprNode::Member(of, member) => return self.method(of, member, given, place),
            _ => {
                let value = self.value(callee);
                return self.called(callee, value, given, place);
            }
        };
        if self.find(&name).is_some() {
            let value = self.value(callee);
            return self.called(callee, value, given, place);
        }
        self.call_named(&name, given, place)
    }

    /// Whether a lambda that this is called with is a kernel that it holds from then on.
    fn takes_kernel(&mut self, callee: &Expr) -> bool {
        let Some((slot, path)) = self.target(callee, false) else {
            return false;
        };
        match self.at(slot, &path) {
            Value::Lambda(function) => function.parameters.is_empty(),
            Value::Symbol(name) => !self.functions.contains_key(last(&name)),
            _ => true,
        }
    }

    /// A call of a function of the file, of the library or of the chip.
    fn call_named(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        if let Some(function) = self.overload(name, given.len(), place) {
            return self.enter(&function, given, place, true);
        }
        let name = last(name);
        match host::role(name, given.len()) {
            Role::Kernel => self.kernel_mark(name, place),
            Role::Sync => {
                self.in_kernel(name, place);
                self.sync();
                Value::Whole(1)
            }
            Role::Number => self.number(name, given, place),
            Role::Library => self.library(name, given, place),
            Role::Show => self.show(name, given, place),
            Role::Read | Role::Chip => self.chip(name, given, place),
        }
    }

    fn called(&mut self, callee: &Expr, value: Value, given: &[Expr], place: Place) -> Value {
        match value {
            Value::Lambda(function) if self.is_kernel(&function) => self.launch(&function),
            Value::Lambda(function) => self.enter(&function, given, place, false),
            // A function by another name.
            Value::Symbol(name) => self.call_named(&name, given, place),
            Value::Unknown(why) if why != unassigned(&base_name(callee)) => {
                let message = format!("what this call runs, {why} decides");
                self.unknown(place, message, Some(callee));
                Value::Unknown(why)
            }
            // An object of a library: a generator of numbers.
            _ => {
                self.outside(&base_name(callee), given, place);
                Value::Unknown("what a call gives back".into())
            }
        }
    }

    /// Arguments of something that is not stated here: it may be given numbers, no registers.
    fn outside(&mut self, name: &str, given: &[Expr], place: Place) -> Vec<Value> {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let register = values.iter().find_map(|it| match it {
            Value::Symbol(register) => self.device.value_of(register).map(|_| register.clone()),
            _ => None,
        });
        if let Some(register) = register {
            self.error(
                place,
                format!("what `{name}` does with `{register}` is not known"),
                "this call",
                "state it as a function of this file that takes registers, and call that",
            );
        }
        values
    }

    /// A member of a class of the file is called: classes are not run, so that it must leave the
    /// array alone.
    fn leaves_array(&mut self, name: &str, member: &str, place: Place) -> bool {
        let all = look::members(self, member);
        let acts = |it: &Rc<Function>| it.body.iter().any(|it| look::changes(self, it));
        let Some(acting) = all.into_iter().find(acts) else {
            return true;
        };
        let line = self.line(acting.place);
        self.error(
            place,
            format!(
                "`{name}.{member}` runs words of the array, and members of classes are not run"
            ),
            "this call",
            &format!("make `{member}`, in {line}, a function outside of the class, and call that"),
        );
        false
    }

    /// Whether a function is the body of a kernel: it asks words, and begins no kernel itself.
    fn is_kernel(&self, function: &Function) -> bool {
        self.kernel.is_none()
            && function.parameters.is_empty()
            && function.body.iter().any(|it| look::changes(self, it))
            && !function
                .body
                .iter()
                .any(|it| look::begins_kernel(self, it) || look::asks_host(self, it))
    }

    /// The function of this name that takes so many arguments: of the namespace that is written
    /// before it, else of the one that is worked in, else the only one.
    fn overload(&mut self, name: &str, given: usize, place: Place) -> Option<Rc<Function>> {
        let fitting = self.fitting(last(name), given);
        let stated = qualifier(name);
        let (first, rest) = match (fitting.split_first(), stated) {
            (None, _) => return None,
            _ if foreign(name) => return None,
            (Some(found), _) => found,
        };
        let of = |space: &str| fitting.iter().find(|it| *it.space == *space).cloned();
        let mut spaces: Vec<String> = Vec::new();
        if let Some(stated) = stated {
            let inner = self.spaces().map(|space| format!("{space}::{stated}"));
            spaces.extend(inner.filter(|_| !stated.is_empty()));
            spaces.push(stated.trim_start_matches("::").to_owned());
        } else {
            spaces.extend(self.spaces().map(str::to_owned));
            spaces.push(String::new());
        }
        if let Some(found) = spaces.iter().find_map(|space| of(space)) {
            return Some(found);
        }
        if stated == Some("") {
            return None;
        }
        if rest.iter().any(|it| it.space != first.space) {
            let first = Rc::clone(first);
            self.several(last(name), place);
            return Some(first);
        }
        Some(Rc::clone(first))
    }

    /// The functions of this name that take so many arguments, the last one first.
    fn fitting(&self, name: &str, given: usize) -> Vec<Rc<Function>> {
        let all = self.functions.get(name).into_iter().flatten();
        let fits = |it: &&Rc<Function>| {
            let parameters = 0..it.parameters.len();
            let least = parameters
                .filter(|i| self.default(it, *i).is_none())
                .count();
            (least..=it.parameters.len()).contains(&given)
        };
        all.rev().filter(fits).cloned().collect()
    }

    /// The default of a parameter, stated with the function or where it is announced.
    fn default(&self, function: &Function, index: usize) -> Option<Expr> {
        let own = function.parameters.get(index)?.default.clone();
        own.or_else(|| {
            let announced = self.prototypes.get(&function.name)?.iter();
            let mut alike = announced.filter(|it| {
                let kinds =
                    |it: &Function| it.parameters.iter().map(|p| p.kind).collect::<Vec<_>>();
                it.space == function.space && kinds(it) == kinds(function)
            });
            alike.find_map(|it| it.parameters[index].default.clone())
        })
    }

    /// Runs a function with these arguments. A lambda sees the names around it.
    pub(super) fn enter(
        &mut self,
        function: &Rc<Function>,
        given: &[Expr],
        place: Place,
        own: bool,
    ) -> Value {
        if self.depth == DEPTH {
            self.error(
                place,
                format!("more than {DEPTH} calls inside each other"),
                "this call",
                "does the function call itself? write a loop",
            );
            return Value::Whole(0);
        }
        let mut scope = BTreeMap::new();
        for (i, parameter) in function.parameters.iter().enumerate() {
            let slot = match (given.get(i), self.default(function, i)) {
                (Some(it), _) => {
                    let place = if parameter.reference {
                        self.target(it, false)
                    } else {
                        None
                    };
                    match place {
                        Some((slot, path)) if path.is_empty() => slot,
                        _ => {
                            let value = self.value(it).converted(parameter.kind);
                            self.slots.push(value);
                            self.slots.len() - 1
                        }
                    }
                }
                (None, Some(default)) => {
                    let value = self.value(&default);
                    self.slots.push(value);
                    self.slots.len() - 1
                }
                (None, None) => continue,
            };
            scope.insert(parameter.name.clone(), slot);
        }
        let (base, maybe) = (self.base, self.maybe.clone());
        let space = self.space.clone();
        if own {
            self.base = self.scopes.len();
            self.space = function.space.clone();
        }
        self.scopes.push(scope);
        self.depth += 1;
        let flow = self.statements(&function.body);
        self.depth -= 1;
        self.scopes.pop();
        self.base = base;
        self.space = space;
        // Whether it returned early is its own affair, but for what it gives back.
        let unsure = std::mem::replace(&mut self.maybe, maybe.clone());
        match (flow, unsure) {
            (_, Some(why)) if maybe.is_none() => Value::Unknown(why),
            (Flow::Return(value), _) => value,
            _ => Value::Whole(0),
        }
    }

    fn kernel_mark(&mut self, name: &str, place: Place) -> Value {
        match name {
            "scamp5_kernel_begin" | "scamp5_kernel_begin_print" => self.begin_kernel(place, true),
            "scamp5_dynamic_kernel_begin" => self.begin_kernel(place, false),
            _ => self.end_kernel(place),
        }
        Value::Whole(0)
    }

    /// What the micro-controller does cannot stand inside a kernel.
    fn in_kernel(&mut self, name: &str, place: Place) {
        if self.kernel.is_some() {
            self.fault(
                Fault::warning(
                    place,
                    format!("`{name}` inside a kernel"),
                    "the host does this, not the array",
                )
                .help("put it behind `scamp5_kernel_end();`"),
            );
        }
    }

    fn number(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        if let Some(Value::Unknown(why)) = values.iter().find(|it| matches!(it, Value::Unknown(_)))
        {
            return Value::Unknown(Arc::clone(why));
        }
        let numbers: Vec<f64> = values.iter().filter_map(Value::number).collect();
        let whole = values.iter().all(|it| matches!(it, Value::Whole(_)));
        let result = match (name, &numbers[..]) {
            ("abs" | "fabs", [x]) => x.abs(),
            ("sqrt", [x]) => x.sqrt(),
            ("floor", [x]) => x.floor(),
            ("ceil", [x]) => x.ceil(),
            ("round", [x]) => x.round(),
            ("min" | "fmin", [x, y]) => x.min(*y),
            ("max" | "fmax", [x, y]) => x.max(*y),
            _ => {
                self.error(
                    place,
                    format!("`{name}` of something that is no known number"),
                    "this call",
                    "give it numbers; other functions of the mathematical library are not known here: write the value",
                );
                return Value::Whole(0);
            }
        };
        if whole && matches!(name, "abs" | "min" | "max") {
            Value::Whole(result as i64)
        } else {
            Value::Real(result)
        }
    }

    /// The GUI and the box. Sliders and switches are settings, with their defaults.
    fn library(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        let naming = self.naming.take();
        let slider = match name {
            "vs_gui_add_slider" | "vs_gui_add_slider_latched" => Some((3, 4)),
            "vs_gui_add_switch" => Some((1, 2)),
            _ => None,
        };
        if let Some((at, target)) = slider {
            let default = given.get(at).map(|it| self.value(it));
            let pointed = given.get(target).map(|it| (base_name(it), self.value(it)));
            let name = match (&pointed, naming) {
                (Some((name, _)), _) => name.clone(),
                (None, Some(name)) => name.to_string(),
                (None, None) => String::new(),
            };
            let set = self.set(&name);
            if let (3, Some(set)) = (at, &set) {
                self.slider_range(&name, set, given, place);
            }
            let value = set.or(default).unwrap_or(Value::Whole(0));
            if let (false, Some(number)) = (name.is_empty(), value.number()) {
                self.constants.insert(name, number);
            }
            if let Some((_, Value::Pointer(slot, path, _))) = pointed {
                self.put(slot, &path, value.clone());
            }
            return value;
        }
        for it in given {
            // Callbacks run when somebody moves a slider.
            if !matches!(it.node, ExprNode::Lambda(_)) {
                let value = self.value(it);
                if let (Value::Pointer(slot, path, _), true) = (&value, written(name)) {
                    let why = format!("what `{name}` gives");
                    self.forget(*slot, path, &why.into());
                }
            }
        }
        match name {
            "vs_gui_add_display" => {
                let title = given.first().map(|it| self.value(it));
                match title {
                    Some(Value::Text(text)) => Value::Text(text),
                    _ => Value::Text("".into()),
                }
            }
            // A handle of a slider is its value here.
            "vs_gui_read_slider" => match given.first().map(|it| self.value(it)) {
                Some(value @ (Value::Whole(_) | Value::Real(_))) => value,
                Some(Value::Symbol(gain)) if &*gain == "VS_GUI_FRAME_GAIN" => {
                    let value = self.set("frame_gain").unwrap_or(Value::Whole(1));
                    self.constants
                        .insert("frame_gain".to_owned(), value.number().unwrap_or(1.0));
                    value
                }
                _ => Value::Unknown("a slider of the GUI".into()),
            },
            "vs_gui_is_on" => Value::Whole(1),
            _ => Value::Unknown(format!("`{name}`").into()),
        }
    }

    /// A slider that is set beyond its ends, which the GUI would not do.
    fn slider_range(&mut self, name: &str, set: &Value, given: &[Expr], place: Place) {
        let mut ends = given
            .iter()
            .skip(1)
            .take(2)
            .map(|it| self.value(it).number());
        let (Some(Some(low)), Some(Some(high))) = (ends.next(), ends.next()) else {
            return;
        };
        let Some(value) = set.number().filter(|it| !(low..=high).contains(it)) else {
            return;
        };
        self.fault(
            Fault::warning(
                place,
                format!("`{name}` is set to {value}, and its slider goes from {low} to {high}"),
                "this slider",
            )
            .help(format!("give `{name}` a value from {low} to {high}")),
        );
    }

    fn method(&mut self, of: &Expr, member: &str, given: &[Expr], place: Place) -> Value {
        let name = base_name(of);
        let slot = self.find(&name);
        let list = slot.and_then(|slot| match &self.slots[slot] {
            Value::List(all) => Some((slot, all.len())),
            _ => None,
        });
        if list.is_none() {
            if self.leaves_array(&name, member, place) {
                self.outside(&format!("{name}.{member}"), given, place);
            }
            return Value::Unknown(format!("`{name}.{member}`").into());
        }
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        match (member, list) {
            ("size", Some((_, length))) => Value::Whole(length as i64),
            ("data" | "begin", Some((slot, _))) => Value::Pointer(slot, Vec::new(), name.into()),
            ("push_back", Some((slot, _))) => {
                if let (Value::List(all), Some(value)) =
                    (&mut self.slots[slot], values.into_iter().next())
                {
                    all.push(value);
                }
                Value::Whole(0)
            }
            ("fill", Some((slot, _))) => {
                if let (Value::List(all), Some(value)) = (&mut self.slots[slot], values.first()) {
                    all.fill(value.clone());
                }
                Value::Whole(0)
            }
            _ => Value::Unknown(format!("`{name}.{member}`").into()),
        }
    }

    /// A register is shown: as a picture of what it holds now.
    fn show(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let place = self.files.own(place);
        if let Some(Value::Text(title)) = values.get(1) {
            let (line, _) = crate::config::line_column(self.text, place.start);
            self.titles
                .entry(line)
                .or_default()
                .insert(title.to_string());
        }
        let Some(register) = values.first() else {
            return Value::Whole(0);
        };
        match term(register) {
            Some(term) => {
                self.in_kernel(name, place);
                // What is shown changes nothing: it may run or not.
                let maybe = self.maybe.take();
                self.ask("scamp5_output_image", vec![term], place);
                self.maybe = maybe;
            }
            None => self.no_argument(name, register, place, given.first()),
        }
        Value::Whole(0)
    }

    fn no_argument(&mut self, name: &str, value: &Value, place: Place, of: Option<&Expr>) {
        match value {
            Value::Unknown(why) => {
                let message = format!("`{name}` takes a value of which {why} decides");
                self.unknown(place, message, of);
            }
            other => {
                let message = format!("`{name}` does not take {}", other.describe());
                self.error(
                    place,
                    message,
                    "this call",
                    "it takes registers, directions and numbers",
                );
            }
        }
    }

    /// A word, a macro or an operation of the host.
    fn chip(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        let mut values = Vec::new();
        for it in given {
            let place = it.place;
            values.push((self.value(it), place, base_name(it)));
        }
        // A kernel object that is launched.
        if name == "scamp5_launch_kernel" {
            if let Some((Value::Lambda(function), ..)) = values.first() {
                let function = Rc::clone(function);
                return self.launch(&function);
            }
            self.error(
                place,
                "this kernel is stated nowhere".to_owned(),
                "what it does is not known",
                "state it before: `kernel([] { … });`",
            );
            return Value::Whole(0);
        }
        if let Some(groups) = Self::groups(&values) {
            self.ask_groups(name, groups, place);
            return Value::Whole(0);
        }
        let Some((name, values)) = super::chip::rewritten(self, name, values, place) else {
            return Value::Whole(0);
        };
        if name == "DNEWS"
            && let Some(directions) = super::chip::joined(&values)
        {
            super::chip::neighbours(self, &values, &directions, place);
            return Value::Whole(0);
        }
        if self.is_host(&name) {
            self.in_kernel(&name, place);
        }
        let mut terms = Vec::new();
        for (i, (value, _, buffer)) in values.iter().enumerate() {
            let term = match value {
                Value::Pointer(slot, path, _) => {
                    let why = format!("what `{name}` reads in {}", self.line(place));
                    let (slot, path) = (*slot, path.clone());
                    self.forget(slot, &path, &why.into());
                    Some(Term::Name(super::chip::buffer_name(buffer)))
                }
                Value::Text(_) => Some(Term::Name(super::chip::buffer_name(buffer))),
                other => term(other),
            };
            if let Some(term) = term {
                terms.push(term);
            } else {
                let value = value.clone();
                self.no_argument(&name, &value, place, given.get(i));
                return Value::Whole(0);
            }
        }
        self.ask(&name, terms, place);
        Value::Unknown(format!("what `{name}` reads in {}", self.line(place)).into())
    }

    /// `bus({A, B}, {C})`: arguments in braces.
    fn groups(values: &[(Value, Place, String)]) -> Option<Vec<Vec<Term>>> {
        if values.is_empty() {
            return None;
        }
        let lists = values.iter().map(|(value, ..)| match value {
            Value::List(all) => all.iter().map(term).collect(),
            _ => None,
        });
        lists.collect()
    }

    fn launch(&mut self, function: &Rc<Function>) -> Value {
        self.begin_kernel(function.place, false);
        let value = self.enter(function, &[], function.place, false);
        self.end_kernel(function.place);
        value
    }
}

/// Whether a function of the library writes what it is given the place of.
fn written(name: &str) -> bool {
    !name.starts_with("vs_post") && !name.starts_with("scamp5_display") && name != "printf"
}
