//! Calls: of functions of the file, of the library, of the chip.

use std::{collections::BTreeMap, rc::Rc, sync::Arc};

use super::{
    beside::Companion,
    evaluate::{Reach, base_name},
    host::{self, ALGORITHMS, Role},
    look,
    machine::{Flow, Machine, Spot, foreign, term},
    tree::{
        Expr, ExprNode, Function, Kind, Parameter, TemplateArgument, Width, Word, last, qualifier,
    },
    value::{Slot, Value, unassigned},
};
use crate::{
    config::{Fault, Place},
    isa::text::Term,
};

/// Calls inside each other.
const DEPTH: usize = 64;

/// Elements of an array that grows.
const LONGEST: usize = 1 << 20;

impl Machine<'_> {
    pub(super) fn call(&mut self, callee: &Expr, given: &[Expr], place: Place) -> Value {
        self.work(place);
        let angles = self.angles.take();
        match &callee.node {
            ExprNode::Name(name) => match self.named_spot(name) {
                Some((slot, path)) => {
                    self.call_reached(callee, &Reach::Spot(slot, path), given, place)
                }
                None => self.call_named(name, given, angles, place),
            },
            ExprNode::Lambda(function) => {
                let function = self.closure(function);
                self.enter(&function, given, place)
            }
            // A function of an object: of a clock, a generator, a list.
            ExprNode::Member(of, member) => self.method(callee, (of, member), given, place),
            _ => {
                let reached = self.reach(callee);
                self.call_reached(callee, &reached, given, place)
            }
        }
    }

    /// A call of what lies somewhere: it is a function, or a kernel that is stated here.
    fn call_reached(
        &mut self,
        callee: &Expr,
        reached: &Reach,
        given: &[Expr],
        place: Place,
    ) -> Value {
        if let (Reach::Spot(slot, path), [only]) = (reached, given)
            && let ExprNode::Lambda(function) = &only.node
            && self.takes_kernel(*slot, path)
        {
            // It runs when it is launched.
            let value = Value::Lambda(self.closure(function));
            self.put(*slot, path, value.clone());
            return value;
        }
        let value = self.load(reached, callee);
        self.called(callee, value, given, place)
    }

    /// Whether a lambda that this is called with is a kernel that it holds from then on.
    fn takes_kernel(&self, slot: Slot, path: &[usize]) -> bool {
        match self.peek(slot, path) {
            Some(Value::Lambda(function)) => function.parameters.is_empty(),
            Some(Value::Symbol(name)) => !self.functions.contains_key(last(name)),
            Some(_) => true,
            None => false,
        }
    }

    /// A call of a function of the file, of the library or of the chip.
    fn call_named(
        &mut self,
        name: &str,
        given: &[Expr],
        angles: Option<Vec<TemplateArgument>>,
        place: Place,
    ) -> Value {
        let all = self.candidates(name, given.len(), place);
        if !all.is_empty() {
            let given: Vec<_> = given.iter().map(|it| self.argument(it)).collect();
            let Some(function) = self.overload(last(name), &all, &given, place) else {
                return Value::Whole(0);
            };
            return self.enter_with(&function, given, angles, place);
        }
        if host::simulates(name) {
            return self.simulated(last(name), given, place);
        }
        let standard = foreign(name) && qualifier(name).is_some_and(|it| it.ends_with("std"));
        let name = last(name);
        match (name, given) {
            (super::parse::FILLED, _) => return self.filled(given, place),
            ("static_assert", _) => return self.asserted(given, place),
            ("swap", [a, b]) => return self.swapped(a, b),
            ("begin" | "end" | "size", [of]) => {
                if let Some(found) = self.of_whole(of, name) {
                    return found;
                }
            }
            _ if ALGORITHMS.contains(&name) => return self.algorithm(name, given, place),
            _ => {}
        }
        match host::role(name, given.len()) {
            Role::Chip if standard => {
                self.outside(name, given, place);
                Value::Unknown(format!("`{name}`").into())
            }
            Role::Kernel => self.kernel_mark(name, given, place),
            Role::Sync => {
                self.in_kernel(name, place);
                self.sync(place);
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
            Value::Lambda(function) => self.enter(&function, given, place),
            // A function by another name.
            Value::Symbol(name) => self.call_named(&name, given, None, place),
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
        let values: Vec<Value> = given.iter().map(|it| self.raw(it)).collect();
        for value in &values {
            self.keeps_register(name, value, place);
        }
        self.written_by(name, &values);
        values
    }

    /// Tells of a register that goes where it is not known what is done with it.
    pub(super) fn keeps_register(&mut self, name: &str, value: &Value, place: Place) {
        let Value::Symbol(register) = value else {
            return;
        };
        if self.device.value_of(register).is_some() {
            self.error(
                place,
                format!("what `{name}` does with `{register}` is not known"),
                "this call",
                "state it as a function of this file that takes registers, and call that",
            );
        }
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

    /// The functions that a call by this name may mean, the last one first: those of the namespace
    /// that is written before it, else of the one that is worked in, else those of the only one.
    fn candidates(&mut self, name: &str, given: usize, place: Place) -> Vec<Rc<Function>> {
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
    fn meant(&self, stated: Option<&str>) -> Vec<String> {
        let Some(stated) = stated else {
            let spaces = self.spaces().map(str::to_owned);
            return spaces.chain([String::new()]).collect();
        };
        let inner = self.spaces().map(|space| format!("{space}::{stated}"));
        let inner = inner.filter(|_| !stated.is_empty());
        let outer = stated.trim_start_matches("::").to_owned();
        inner.chain([outer]).collect()
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

    /// The function that fits these arguments best.
    fn overload(
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
            let costs = given.iter().zip(&function.parameters);
            let costs: Option<Vec<u8>> = costs.map(|(it, to)| self.cost(it, to)).collect();
            found.extend(costs.map(|costs| (costs, function)));
        }
        if found.is_empty() {
            self.error(
                place,
                format!("no `{name}` takes these arguments"),
                "this call",
                "the functions of this name take other registers, or other types",
            );
            return None;
        }
        // One is better where no argument fits it worse, and some fits it better.
        let better = |a: &[u8], b: &[u8]| a.iter().zip(b).all(|(a, b)| a <= b);
        let best = found
            .iter()
            .find(|(costs, _)| found.iter().all(|(other, _)| better(costs, other)));
        let Some((costs, function)) = best else {
            self.unclear(name, place);
            return None;
        };
        let same = found.iter().filter(|(other, it)| {
            let kinds =
                |it: &Function| -> Vec<Kind> { it.parameters.iter().map(|p| p.kind).collect() };
            other == costs && !Rc::ptr_eq(it, function) && kinds(it) != kinds(function)
        });
        if same.count() > 0 {
            self.unclear(name, place);
            return None;
        }
        Some(Rc::clone(function))
    }

    fn unclear(&mut self, name: &str, place: Place) {
        self.error(
            place,
            format!("which `{name}` is meant is ambiguous"),
            "several functions of this name fit",
            "convert the arguments to the types of the one that is meant, such as `(int)x`",
        );
    }

    /// How badly an argument fits a parameter; `None` where it does not.
    fn cost(&self, it: &Argument, to: &Parameter) -> Option<u8> {
        const EXACT: u8 = 0;
        const PROMOTED: u8 = 1;
        const CONVERTED: u8 = 2;
        const ANY: u8 = 3;
        let pointed = matches!(
            it.value,
            Value::Pointer(..) | Value::List(_) | Value::Text(_)
        );
        match (&it.value, to.kind) {
            (Value::Symbol(name), Kind::Analog | Kind::Digital) => {
                use crate::isa::{Bit, Source, Value as Known};
                let analog = match self.device.value_of(name) {
                    Some(Known::Source(Source::Register(_))) => true,
                    Some(Known::Bit(Bit::Register(_))) => false,
                    _ => return Some(ANY),
                };
                (analog == (to.kind == Kind::Analog)).then_some(EXACT)
            }
            (Value::Symbol(_), Kind::Any) => Some(CONVERTED),
            (Value::Symbol(name), _) => self.device.value_of(name).is_none().then_some(ANY),
            (Value::Record(layout, _), _) => {
                let exact = if layout.name == to.of { EXACT } else { ANY };
                (exact == EXACT || to.kind == Kind::Any && !self.layouts.contains_key(&to.of))
                    .then_some(exact)
            }
            (Value::Unknown(_), kind) if it.kind == Kind::Any => {
                (!matches!(kind, Kind::Analog | Kind::Digital)).then_some(CONVERTED)
            }
            _ if pointed => match (to.pointer, to.kind) {
                (true, _) => Some(EXACT),
                (false, Kind::Any | Kind::Parameter(_)) => Some(CONVERTED),
                _ => None,
            },
            (_, Kind::Analog | Kind::Digital) => None,
            _ if to.pointer => None,
            (_, Kind::Parameter(_)) => Some(EXACT + u8::from(it.kind == Kind::Any)),
            (_, Kind::Any) if self.layouts.contains_key(&to.of) => None,
            (_, Kind::Any) => Some(ANY),
            (_, kind) if kind == it.kind => Some(EXACT),
            (_, kind) => Some(match (it.kind, kind) {
                (Kind::Flag | Kind::Bits(8 | 16, _), Kind::INT)
                | (Kind::Float | Kind::Real, Kind::Float | Kind::Real) => PROMOTED,
                _ => CONVERTED,
            }),
        }
    }

    /// An argument, with where it lies, evaluated once.
    fn argument(&mut self, it: &Expr) -> Argument {
        let reached = self.reach(it);
        let value = self.load(&reached, it);
        let (spot, kind) = match reached {
            Reach::Spot(slot, path) => {
                let kind = self.kind_at(slot, &path);
                (Some((slot, path)), kind)
            }
            _ => (None, self.written_kind(it)),
        };
        let kind = if kind == Kind::Any {
            value.kind()
        } else {
            kind
        };
        Argument { value, spot, kind }
    }

    /// The type that an expression shows by how it is written.
    fn written_kind(&self, it: &Expr) -> Kind {
        match &it.node {
            ExprNode::Convert(kind, _) => self.resolved(*kind),
            ExprNode::Unary("!", _)
            | ExprNode::Binary("<" | ">" | "<=" | ">=" | "==" | "!=" | "&&" | "||", ..) => {
                Kind::Flag
            }
            _ => Kind::Any,
        }
    }

    /// `static_assert(condition, "why")`
    fn asserted(&mut self, given: &[Expr], place: Place) -> Value {
        let holds = given.first().map(|it| self.value(it));
        let why = match given.get(1).map(|it| &it.node) {
            Some(ExprNode::Text(text)) => format!(": {text}"),
            _ => String::new(),
        };
        match holds.as_ref().map(Value::number) {
            Some(Some(value)) if value != 0.0 => {}
            Some(Some(_)) => self.error(
                place,
                format!("`static_assert` does not hold{why}"),
                "this condition is false",
                "change what it is about",
            ),
            _ => self.error(
                place,
                "`static_assert` of something that is no constant".to_owned(),
                "this condition",
                "give it what is known beforehand, or take it out",
            ),
        }
        Value::Whole(0)
    }

    /// `std::vector name(length, value)`
    fn filled(&mut self, given: &[Expr], place: Place) -> Value {
        let all: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let (Some(value), Some(length)) = (all.get(1), all.first().and_then(Value::whole)) else {
            return Value::Unknown("an array whose length only the run knows".into());
        };
        match usize::try_from(length) {
            Ok(length) if length <= 1 << 20 => Value::List(vec![value.clone(); length]),
            _ => {
                self.error(
                    place,
                    format!("an array of {length} elements"),
                    "this length",
                    "give it a length up to 1048576",
                );
                Value::Whole(0)
            }
        }
    }

    /// `std::swap(a, b)`
    fn swapped(&mut self, a: &Expr, b: &Expr) -> Value {
        let (first, second) = (self.reach(a), self.reach(b));
        let raw = |reached: &Reach| match reached {
            Reach::Spot(slot, path) => Some(self.at(*slot, path)),
            _ => None,
        };
        let (one, other) = match (raw(&first), raw(&second)) {
            (Some(one), Some(other)) => (one, other),
            _ => (self.load(&first, a), self.load(&second, b)),
        };
        self.store(&first, other, a);
        self.store(&second, one, b);
        Value::Whole(0)
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

    /// Runs a function with these arguments. A lambda has with it what it uses of the names around
    /// it.
    pub(super) fn enter(&mut self, function: &Rc<Function>, given: &[Expr], place: Place) -> Value {
        let given = given.iter().map(|it| self.argument(it)).collect();
        self.enter_with(function, given, None, place)
    }

    pub(super) fn enter_with(
        &mut self,
        function: &Rc<Function>,
        given: Vec<Argument>,
        angles: Option<Vec<TemplateArgument>>,
        place: Place,
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
        let mut scope: BTreeMap<Word, usize> = function.held.iter().cloned().collect();
        let types = if function.template.is_empty() {
            // A lambda inside a template has its types.
            function.name.is_empty().then(|| self.types.clone())
        } else {
            Some(self.template(
                function,
                &given,
                angles.unwrap_or_default(),
                &mut scope,
                place,
            ))
        };
        let outer = std::mem::replace(&mut self.types, types.unwrap_or_default());
        let mut given = given.into_iter();
        for (i, parameter) in function.parameters.iter().enumerate() {
            let kind = self.resolved(parameter.kind);
            let slot = match (given.next(), self.default(function, i)) {
                (Some(it), _) => match it.spot {
                    Some((slot, path)) if parameter.reference && path.is_empty() => slot,
                    Some((slot, path)) if parameter.reference => {
                        self.hold(Value::Reference(slot, path), Kind::Any)
                    }
                    _ => self.taken(it.value, kind, parameter),
                },
                (None, Some(default)) => {
                    // It sees the names of the file, not those of the caller.
                    let base = std::mem::replace(&mut self.base, self.scopes.len());
                    let space = std::mem::replace(&mut self.space, function.space.clone());
                    let value = self.value(&default);
                    (self.base, self.space) = (base, space);
                    self.taken(value, kind, parameter)
                }
                // What `main` is started with.
                (None, None) => {
                    let why = format!("`{}`", parameter.name);
                    self.hold(Value::Unknown(why.into()), Kind::Any)
                }
            };
            scope.insert(parameter.name.clone(), slot);
        }
        let (base, maybe) = (self.base, self.maybe.clone());
        let space = std::mem::replace(&mut self.space, function.space.clone());
        self.base = self.scopes.len();
        self.scopes.push(scope);
        self.depth += 1;
        let flow = self.statements(&function.body);
        self.depth -= 1;
        self.scopes.pop();
        self.base = base;
        self.space = space;
        let returns = self.resolved(function.returns);
        self.types = outer;
        // Whether it returned early is its own affair, but for what it gives back.
        let unsure = std::mem::replace(&mut self.maybe, maybe.clone());
        match (flow, unsure) {
            (_, Some(why)) if maybe.is_none() => Value::Unknown(why),
            (Flow::Return(value), _) => value.converted(returns),
            _ => Value::Whole(0),
        }
    }

    /// The variable that a parameter is.
    fn taken(&mut self, value: Value, kind: Kind, parameter: &Parameter) -> usize {
        let value = match (self.layouts.get(&parameter.of), value) {
            (Some(layout), Value::List(all)) if !parameter.pointer => {
                super::shape::record(layout, all).unwrap_or_else(|why| Value::Unknown(why.into()))
            }
            (_, value) => super::shape::deep(value, kind),
        };
        let whole = matches!(value, Value::List(_));
        let slot = self.hold(value, kind);
        if whole {
            self.copied.insert(slot);
        }
        slot
    }

    /// What the parameters of a template are: stated in `<…>`, taken from the arguments, or their
    /// defaults. Values become variables, types are given back by position.
    fn template(
        &mut self,
        function: &Function,
        given: &[Argument],
        angles: Vec<TemplateArgument>,
        scope: &mut BTreeMap<Word, usize>,
        place: Place,
    ) -> Vec<Kind> {
        let mut types = Vec::new();
        let mut angles = angles.into_iter();
        for (at, parameter) in function.template.iter().enumerate() {
            let stated = angles.next();
            let default = stated.is_none();
            let stated = stated.or_else(|| parameter.default.clone());
            let deduced = || {
                let mut all = given.iter().zip(&function.parameters);
                let it = all.find(|(_, to)| to.kind == Kind::Parameter(at))?.0;
                Some(TemplateArgument::Type(it.kind))
            };
            let length = || {
                let mut all = given.iter().zip(&function.parameters);
                let it = all
                    .find(|(_, to)| to.extent.as_ref() == Some(&parameter.name))?
                    .0;
                let (slot, path) = it.spot.as_ref()?;
                let Some(Value::List(all)) = self.peek(*slot, path) else {
                    return None;
                };
                Some(Value::Whole(all.len() as i64))
            };
            if let (None, false, Some(length)) = (&stated, parameter.is_type, length()) {
                let slot = self.hold(length, Kind::INT);
                scope.insert(parameter.name.clone(), slot);
                types.push(Kind::Any);
                continue;
            }
            let kind = match stated.or_else(deduced) {
                Some(TemplateArgument::Type(kind)) => self.resolved(kind),
                Some(TemplateArgument::Value(value)) if !parameter.is_type => {
                    // A default knows the parameters before it.
                    let around = if default {
                        scope.clone()
                    } else {
                        BTreeMap::new()
                    };
                    self.scopes.push(around);
                    let value = self.value(&value);
                    self.scopes.pop();
                    let slot = self.hold(value, Kind::Any);
                    scope.insert(parameter.name.clone(), slot);
                    Kind::Any
                }
                _ if parameter.is_type => Kind::Any,
                _ => {
                    let name = &function.name;
                    self.error(
                        place,
                        format!("`{}` of the template `{name}` is not given", parameter.name),
                        "this call",
                        &format!("write `{name}<value>(…)`"),
                    );
                    Kind::Any
                }
            };
            types.push(kind);
        }
        types
    }

    fn kernel_mark(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        let ordinal = given.first().and_then(|it| self.value(it).whole());
        let ordinal = ordinal.unwrap_or_default();
        match name {
            "scamp5_kernel_begin" | "scamp5_kernel_begin_print" => {
                self.begin_kernel(place, ordinal, true);
            }
            "scamp5_dynamic_kernel_begin" => self.begin_kernel(place, ordinal, false),
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
        let whole = values
            .iter()
            .all(|it| matches!(it, Value::Whole(_) | Value::Wide(..)));
        let Some(result) = host::number(name, &numbers) else {
            self.error(
                place,
                format!("`{name}` of something that is no known number"),
                "this call",
                "give it numbers; other functions of the mathematical library are not known here: write the value",
            );
            return Value::Whole(0);
        };
        match (name, &values[..]) {
            ("abs" | "min" | "max" | "clamp", [first, ..]) if whole => {
                Value::from_number(result).converted(first.kind())
            }
            ("lround" | "lroundf" | "llround", _) => {
                Value::Real(result).converted(Kind::Bits(64, true))
            }
            _ => Value::Real(result),
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
            let pointed = { given.get(target) }.map(|it| (self.setting(it), self.value(it)));
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
        let mut values = Vec::new();
        for it in given {
            // Callbacks run when somebody moves a slider.
            if !matches!(it.node, ExprNode::Lambda(_)) {
                let value = self.raw(it);
                self.keeps_register(name, &value, place);
                values.push(value);
            }
        }
        if written(name) {
            self.written_by(name, &values);
        }
        match name {
            "vs_post_text" | "printf" | "puts" => {
                self.post(&values);
                Value::Whole(0)
            }
            "scamp5_output_bitstack_begin" => {
                self.stack = values.first().cloned();
                Value::Whole(0)
            }
            "vs_gui_add_display" => match values.into_iter().next() {
                Some(Value::Text(text)) => Value::Text(text),
                _ => Value::Text("".into()),
            },
            // A handle of a slider is its value here.
            "vs_gui_read_slider" => match values.into_iter().next() {
                Some(value @ (Value::Whole(_) | Value::Wide(..) | Value::Real(_))) => value,
                Some(Value::Symbol(gain)) if &*gain == "VS_GUI_FRAME_GAIN" => {
                    let value = self.set("frame_gain").unwrap_or(Value::Whole(1));
                    self.constants
                        .insert("frame_gain".to_owned(), value.number().unwrap_or(1.0));
                    value
                }
                _ => Value::Unknown("a slider of the GUI".into()),
            },
            "vs_gui_is_on" => Value::Whole(1),
            "rand" if self.companion.is_some() => {
                Value::Whole(self.companion.as_mut().map_or(0, Companion::random))
            }
            "strlen" => match values.into_iter().next() {
                Some(Value::Text(text)) => Value::Wide(text.len() as i64, Width::UnsignedLong),
                _ => Value::Unknown("the length of a text".into()),
            },
            _ => Value::Unknown(format!("`{name}`").into()),
        }
    }

    /// What is only there where the vendor simulates the chip: here the chip is meant, but for the
    /// pictures that are saved.
    fn simulated(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        match name {
            "save_image" => self.show(name, given, place),
            "is_simulation" => {
                let value = self.set(name).unwrap_or(Value::Whole(0));
                let number = value.number().unwrap_or_default();
                self.constants.insert(name.to_owned(), number);
                value
            }
            "pix_integrate" => {
                self.fault(
                    Fault::warning(
                        place,
                        "the light is that of the scene: `pix_integrate` does nothing",
                        "this call",
                    )
                    .help("give the light by `exec --image`"),
                );
                Value::Whole(0)
            }
            _ => self.library(name, given, place),
        }
    }

    /// The name that a slider's variable is set by: `name`, `name[0]`, `name.member`.
    fn setting(&mut self, it: &Expr) -> String {
        match &it.node {
            ExprNode::Unary(_, of) | ExprNode::Convert(_, of) | ExprNode::Recast(_, of) => {
                self.setting(of)
            }
            ExprNode::Member(of, member) => format!("{}.{member}", self.setting(of)),
            ExprNode::Index(of, at) => match self.value(at).whole() {
                Some(at) => format!("{}[{at}]", self.setting(of)),
                None => self.setting(of),
            },
            _ => base_name(it),
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

    /// A call of `object.member`.
    fn method(
        &mut self,
        callee: &Expr,
        (of, member): (&Expr, &str),
        given: &[Expr],
        place: Place,
    ) -> Value {
        let name = base_name(of);
        let reached = self.reach(of);
        let reached = self.through(reached);
        if let Some(Value::Record(layout, _)) = self.reached(&reached) {
            let layout = Rc::clone(layout);
            if let Some(found) = self.member_call(&layout, &reached, member, given, place) {
                return found;
            }
        }
        let held = self.reached(&reached);
        match (held, &reached) {
            (Some(Value::List(_)), Reach::Spot(slot, path)) => {
                if let ("swap", [other]) = (member, given) {
                    return self.swapped(of, other);
                }
                let spot = (*slot, path.clone());
                self.list_method(spot.clone(), member, given)
                    .unwrap_or_else(|| {
                        // It may be longer or shorter now.
                        let why: Arc<str> = format!("`{name}.{member}`").into();
                        self.put(spot.0, &spot.1, Value::Unknown(Arc::clone(&why)));
                        Value::Unknown(why)
                    })
            }
            (Some(Value::Record(layout, _)), _)
                if layout.members.iter().any(|it| &*it.name == member) =>
            {
                let reached = self.member(reached, member);
                self.call_reached(callee, &reached, given, place)
            }
            (_, Reach::Spot(slot, _))
                if self.companion.is_some() && matches!(member, "reset" | "get_usec") =>
            {
                let slot = *slot;
                self.stopwatch(slot, member).unwrap_or(Value::Whole(0))
            }
            (held, _) => {
                let record = matches!(held, Some(Value::Record(..)));
                if self.leaves_array(&name, member, place) {
                    self.outside(&format!("{name}.{member}"), given, place);
                }
                // What it does with the members of its object is not known.
                if let (Reach::Spot(slot, path), true) = (&reached, record) {
                    self.forget(*slot, path, &format!("what `{name}.{member}` does").into());
                }
                Value::Unknown(format!("`{name}.{member}`").into())
            }
        }
    }

    fn list_method(&mut self, spot: Spot, member: &str, given: &[Expr]) -> Option<Value> {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let Some(Value::List(all)) = self.peek(spot.0, &spot.1) else {
            return None;
        };
        if matches!(member, "size" | "length") {
            return Some(Value::Wide(all.len() as i64, Width::UnsignedLong));
        }
        let all = all.clone();
        self.of_array(spot, all, member, &values)
    }

    /// A function of an array of the language's library.
    fn of_array(
        &mut self,
        (slot, path): Spot,
        mut all: Vec<Value>,
        member: &str,
        given: &[Value],
    ) -> Option<Value> {
        let kind = self.kind_at(slot, &path);
        let length = all.len();
        let of_kind = |value: &Value| super::shape::deep(value.clone(), kind);
        let to = |at: usize| Value::Pointer(slot, [&path[..], &[at]].concat(), "data".into());
        let place = |value: &Value| match value {
            Value::Pointer(of, way, _) if *of == slot => way.last().copied(),
            _ => None,
        };
        let count = |value: &Value| {
            usize::try_from(value.whole()?)
                .ok()
                .filter(|it| *it <= LONGEST)
        };
        // What a new element of an array of arrays is, is not known here.
        let plain = all.first().is_none_or(|it| it.number().is_some());
        let mut found = Value::Whole(0);
        match (member, given) {
            ("empty", []) => return Some(Value::flag(all.is_empty())),
            ("data" | "begin" | "cbegin", []) => return Some(to(0)),
            ("end" | "cend", []) => return Some(to(length)),
            ("front", []) => return all.first().cloned(),
            ("back", []) => return all.last().cloned(),
            ("at", [index]) => return all.get(count(index)?).cloned(),
            ("reserve" | "shrink_to_fit", _) => return Some(found),
            ("push_back" | "emplace_back", [value]) => all.push(of_kind(value)),
            ("push_front" | "emplace_front", [value]) => all.insert(0, of_kind(value)),
            ("pop_back", []) => drop(all.pop()),
            ("pop_front", []) => drop(all.drain(..length.min(1))),
            ("clear", []) => all.clear(),
            ("fill", [value]) => all.fill(of_kind(value)),
            ("resize", [length]) if plain => all.resize(count(length)?, of_kind(&Value::Whole(0))),
            ("resize", [length, value]) => all.resize(count(length)?, of_kind(value)),
            ("assign", [length, value]) if count(length).is_some() => {
                all = vec![of_kind(value); count(length)?];
            }
            ("insert", [at, value]) if place(at)? <= length => {
                found = at.clone();
                all.insert(place(at)?, of_kind(value));
            }
            ("erase", [at]) if place(at)? < length => {
                found = at.clone();
                all.remove(place(at)?);
            }
            ("erase", [from, end]) if place(from)? <= place(end)? && place(end)? <= length => {
                found = from.clone();
                all.drain(place(from)?..place(end)?);
            }
            _ => return None,
        }
        self.put(slot, &path, Value::List(all));
        Some(found)
    }

    /// `std::begin(array)`, `std::end(array)`, `std::size(array)`
    fn of_whole(&mut self, of: &Expr, name: &str) -> Option<Value> {
        let Reach::Spot(slot, path) = self.reach(of) else {
            return None;
        };
        match self.peek(slot, &path) {
            Some(Value::List(_)) => self.list_method((slot, path), name, &[]),
            _ => None,
        }
    }

    /// A register is shown: as a picture of what it holds now.
    fn show(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let stack = self.stack.clone().filter(|_| name.contains("bitstack"));
        if let Some(Value::Text(title)) = stack.as_ref().or(values.get(1)) {
            let own = self.files.own(place);
            let (line, _) = crate::config::line_column(self.text, own.start);
            self.titles
                .entry(line)
                .or_default()
                .insert(title.to_string());
        }
        let Some(register) = values.first() else {
            return Value::Whole(0);
        };
        let divisor = values.get(2).and_then(Value::number).unwrap_or(1.0);
        if name == "scamp5_output_areg" && divisor > 1.0 {
            let samples = divisor * divisor;
            self.fault(
                Fault::warning(
                    place,
                    format!(
                        "the whole register is read here, {samples} times the samples of the chip"
                    ),
                    "this asks for fewer of them",
                )
                .help("`scamp5_scan_areg` with the same steps says what fewer samples cost"),
            );
        }
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
        let mut targets = Vec::new();
        // What is shown is written into memory as well.
        if let ("scamp5_output_boundingbox", Some((Value::Pointer(slot, path, _), ..))) =
            (name, values.get(2))
        {
            targets.push((*slot, path.clone()));
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
        // Only what is read goes into memory; words that are not known are named for that.
        let buffers = host::role(&name, values.len()) == Role::Read
            || self.device.callables(&name).is_empty();
        let mut terms = Vec::new();
        for (i, (value, _, buffer)) in values.iter().enumerate() {
            let term = match value {
                Value::Pointer(..) | Value::Text(_) | Value::List(_) if !buffers => None,
                Value::Pointer(slot, path, _) => {
                    targets.push((*slot, path.clone()));
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
        let why: Arc<str> = format!("what `{name}` reads in {}", self.line(place)).into();
        // The count destroys a register, and is read none the less.
        let read = host::role(&name, values.len()) == Role::Read || name == "scamp5_global_count";
        let answer = { read.then(|| self.run_asked()) }
            .flatten()
            .unwrap_or_default();
        for target in &targets {
            match &answer.memory {
                Some(memory) => self.fill(target, memory, &name, place),
                None => self.forget_from(target.0, &target.1, &why),
            }
        }
        if let Some(value) = answer.value {
            return Value::Whole(value);
        }
        Value::Unknown(why)
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
        self.begin_kernel(function.place, 0, false);
        let value = self.enter(function, &[], function.place);
        self.end_kernel(function.place);
        value
    }
}

/// What a function is given: its value, where that lies, its type.
pub(super) struct Argument {
    pub value: Value,
    pub spot: Option<Spot>,
    pub kind: Kind,
}

/// Whether a function of the library writes what it is given the place of.
fn written(name: &str) -> bool {
    !name.starts_with("vs_post") && !name.starts_with("scamp5_display") && name != "printf"
}
