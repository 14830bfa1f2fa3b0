//! Calls: of functions of the file, of the library, of the chip.

mod enter;
mod member;
mod opaque;
mod overload;

pub(in crate::program::vendor) use self::overload::{Argument, Named};

use std::rc::Rc;

use super::{
    lvalue::{Reach, base_name},
    machine::Machine,
    scope::foreign,
    value::{Slot, Value, unassigned},
};
use crate::{
    config::Place,
    program::vendor::{
        analysis::effects,
        host::{self, ALGORITHMS, Random, Role},
        syntax::tree::{
            Expr, ExprNode, FILLED, Function, LIMIT, TemplateArgument, last, qualifier,
        },
    },
};

impl Machine<'_> {
    pub(super) fn call(&mut self, callee: &Expr, given: &[Expr], place: Place) -> Value {
        self.referred = None;
        self.calls += 1;
        let value = self.dispatched(callee, given, place);
        self.calls -= 1;
        value
    }

    fn dispatched(&mut self, callee: &Expr, given: &[Expr], place: Place) -> Value {
        self.work(place);
        let angles = self.angles.take();
        match &callee.node {
            ExprNode::Name(name) => match self.named_location(name) {
                Some((slot, path)) => {
                    self.call_reached(callee, &Reach::Location(slot, path), given, place)
                }
                None => match self.own_call(name, given, place) {
                    Some(found) => found,
                    None => self.call_named(name, given, angles, place),
                },
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

    /// A call of what lies somewhere: it is a function, or a kernel that is defined here.
    pub(in crate::program::vendor) fn call_reached(
        &mut self,
        callee: &Expr,
        reached: &Reach,
        given: &[Expr],
        place: Place,
    ) -> Value {
        if let (Reach::Location(slot, path), [only]) = (reached, given)
            && let ExprNode::Lambda(function) = &only.node
            && self.takes_kernel(*slot, path)
        {
            let function = self.closure(function);
            // It runs when it is launched, with the words that it has now.
            return self.filled_with((*slot, path), function);
        }
        if let Some(Value::Record(layout, _)) = self.reached(reached) {
            let layout = Rc::clone(layout);
            if let Some(found) = self.member_call(&layout, reached, "operator()", given, place) {
                return found;
            }
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
        if let Some(layout) = self.layouts.get(last(name)).filter(|it| it.constructs()) {
            return self.constructed(&layout.clone(), given, place);
        }
        let mut all = self.candidates(name, given.len(), place);
        if all.is_empty() && !foreign(name) {
            all = self.announced(name, given.len());
        }
        if !all.is_empty() {
            let given: Vec<_> = given.iter().map(|it| self.argument(it)).collect();
            let Some(function) = self.overload(last(name), &all, &given, place) else {
                return Value::Whole(0);
            };
            if self.hides_word(&function, place) {
                return Value::Whole(0);
            }
            return self.enter_with(&function, given, angles, place);
        }
        if let Some(layout) = self.layouts.get(last(name)).cloned() {
            // An object of data alone: `Class{a, b}`.
            if !self.fits(layout.values, place) {
                return Value::Unknown(format!("an object of `{name}`").into());
            }
            self.passes(layout.values);
            let given = given.iter().map(|it| self.value(it)).collect();
            return self.record(&layout, given);
        }
        if host::simulates(name) {
            return self.simulated(last(name), given, place);
        }
        let standard = foreign(name) && qualifier(name).is_some_and(|it| it.ends_with("std"));
        let name = last(name);
        match (name, given) {
            (FILLED, _) => return self.filled(given, place),
            ("string", _) if standard || !self.layouts.contains_key(name) => {
                return self.text(given);
            }
            (LIMIT, [name, of]) => {
                return self.limit(name, of);
            }
            ("static_assert", _) => return self.asserted(given, place),
            ("make_pair" | "make_tuple", _) => return self.tuple(name, given),
            ("max" | "min", [only]) => return self.extreme(name, only, place),
            ("get", [of]) => {
                if let Some([TemplateArgument::Value(index)]) = angles.as_deref() {
                    let index = self.value(index);
                    return self.got(&index, of, place);
                }
            }
            ("dynamic_cast", [class, of]) => return self.as_class(class, of),
            ("back_inserter" | "front_inserter" | "inserter", [into, ..]) => {
                return self.inserts(name, into);
            }
            ("swap", [a, b]) => return self.swapped(a, b),
            (host::MOVE_TO_HEAP, [moved]) => {
                let moved = self.condition(moved).truth() != Ok(false);
                self.moves_to_heap(moved, place);
                return Value::Whole(0);
            }
            ("begin" | "end" | "size", [of]) => {
                if let Some(found) = self.of_whole(of, name) {
                    return found;
                }
            }
            _ if let Some(random) = Random::named(name) => return self.random(random, given),
            _ if ALGORITHMS.contains(&name) => return self.algorithm(name, given, place),
            _ => {}
        }
        match host::role(name, given.len()) {
            Role::Chip if standard => {
                if given.iter().any(|it| self.text_under(it).is_some()) {
                    self.text_places(name, place);
                }
                self.outside(name, given, place);
                Value::Unknown(format!("`{name}`").into())
            }
            Role::Kernel => self.no_statement(name, place),
            Role::Sync => {
                self.in_kernel(name, place);
                if name == "vs_frame_loop_control" {
                    self.count_turn();
                }
                self.sync(place);
                Value::Whole(1)
            }
            Role::Number => self.number(name, given, place),
            Role::Library => self.library(name, given, place),
            Role::Show => self.show(name, given, place),
            Role::Read | Role::Chip => self.chip(name, given, place),
        }
    }

    /// Tells of a function of the file that has the name of a word of the chip and is called in its
    /// place, inside a kernel; whether it is one.
    fn hides_word(&mut self, function: &Function, place: Place) -> bool {
        let name = &function.name;
        let hides = self.recording.is_some() && !self.device.callables(name).is_empty() && {
            function.body.iter()
        }
        .any(|it| effects::begins_kernel(self, it));
        if hides {
            self.error(
                place,
                format!(
                    "`{name}` is here a function of this file, which begins a kernel inside a kernel"
                ),
                "this call",
                &format!(
                    "the chip has an instruction of this name: rename the function in {}",
                    self.line(function.place)
                ),
            );
        }
        hides
    }

    /// A template without a body of its own, which has bodies for some of what it is given.
    fn announced(&self, name: &str, given: usize) -> Vec<Rc<Function>> {
        if !self.specials.contains_key(last(name)) {
            return Vec::new();
        }
        let all = self.prototypes.get(last(name)).into_iter().flatten();
        let fits = |it: &&Rc<Function>| !it.template.is_empty() && it.parameters.len() == given;
        all.filter(fits).take(1).cloned().collect()
    }

    fn called(&mut self, callee: &Expr, value: Value, given: &[Expr], place: Place) -> Value {
        match value {
            Value::Lambda(function) if function.words.is_some() || self.is_kernel(&function) => {
                self.launch(&function, place)
            }
            Value::Lambda(function) => self.enter(&function, given, place),
            // A function by another name.
            Value::Symbol(name) => self.call_named(&name, given, None, place),
            Value::Unknown(why) if why != unassigned(&base_name(callee)) => {
                let message = format!("what this call runs depends on {why}");
                self.unknown(place, message, &why, Some(callee));
                Value::Unknown(why)
            }
            Value::Random(random, parameters) => self.draws(random, parameters, given),
            // An object of a library.
            _ => {
                self.outside(&base_name(callee), given, place);
                Value::Unknown("what a call returns".into())
            }
        }
    }

    /// Arguments of something that is not declared here: it may be given numbers, no registers.
    pub(super) fn outside(&mut self, name: &str, given: &[Expr], place: Place) -> Vec<Value> {
        let values: Vec<Value> = given.iter().map(|it| self.raw(it)).collect();
        for value in &values {
            self.keeps_register(name, value, place);
        }
        self.written_by(name, &values);
        values
    }

    /// Tells of a register that goes where it is not known what is done with it.
    pub(in crate::program::vendor) fn keeps_register(
        &mut self,
        name: &str,
        value: &Value,
        place: Place,
    ) {
        let Value::Symbol(register) = value else {
            return;
        };
        if self.device.value_of(register).is_some() {
            self.error(
                place,
                format!("what `{name}` does with `{register}` is not known"),
                "this call",
                "define it as a function of this file that takes registers, and call that",
            );
        }
    }

    /// Whether a function is the body of a kernel: it asks words, and begins no kernel itself.
    pub(in crate::program::vendor) fn is_kernel(&self, function: &Function) -> bool {
        self.recording.is_none()
            && function.parameters.is_empty()
            && function.body.iter().any(|it| effects::changes(self, it))
            && !function
                .body
                .iter()
                .any(|it| effects::begins_kernel(self, it) || effects::asks_host(self, it))
    }
}
