//! Kernels: where they begin and end, and objects that hold them.

use std::rc::Rc;

use super::super::{
    machine::{Location, Machine},
    tree::{Expr, Function},
    value::Value,
};
use crate::{
    config::Place,
    program::syntax::{Item, Node},
};

/// The class whose objects hold kernels.
pub(in crate::program::vendor) const CLASS: &str = "scamp5_kernel";

impl Machine<'_> {
    pub(super) fn kernel_border(&mut self, name: &str, given: &[Expr], place: Place) -> Value {
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

    /// An object that holds a kernel of no words.
    pub(in crate::program::vendor) fn empty_kernel(place: Place) -> Value {
        let mut function = Function::new("".into(), place);
        function.words = Some(Rc::default());
        Value::Lambda(function.into())
    }

    /// What holds a kernel that is made of a lambda: the words that it has now, which are stored once.
    pub(in crate::program::vendor) fn kernel_of(&mut self, function: Rc<Function>) -> Value {
        if !self.is_kernel(&function) {
            return Value::Lambda(function);
        }
        self.begin_kernel(function.place, 0, false);
        self.enter(&function, &[], function.place);
        let words = Some(self.taken_back());
        let mut function = Rc::unwrap_or_clone(function);
        function.words = words;
        Value::Lambda(function.into())
    }

    /// What was asked since the kernel began, which ends: it is asked no more.
    fn taken_back(&mut self) -> Rc<[Item]> {
        let start = self.kernel.take().map_or(0, |it| it.start);
        self.items.split_off(start.min(self.items.len())).into()
    }

    /// A function of an object that holds a kernel.
    pub(super) fn kernel_method(
        &mut self,
        function: &Rc<Function>,
        (slot, path): Location,
        member: &str,
        place: Place,
    ) -> Value {
        match member {
            "begin" | "recording_start" => self.begin_kernel(place, 0, false),
            "end" | "recording_stop" if self.kernel.is_some() => {
                let words = Some(self.taken_back());
                let function = Function {
                    words,
                    ..Function::clone(function)
                };
                self.put(slot, &path, Value::Lambda(function.into()));
            }
            "end" | "recording_stop" => self.end_kernel(place),
            "launch" => return self.launch(function, place),
            _ => {
                self.error(
                    place,
                    format!("`{CLASS}` has no `{member}` that is known here"),
                    "this call",
                    "it has `begin()`, `end()` and `launch()`, and is made of a lambda: `kernel([] { … });`",
                );
            }
        }
        Value::Whole(0)
    }

    pub(super) fn launch(&mut self, function: &Rc<Function>, place: Place) -> Value {
        let Some(words) = &function.words else {
            self.begin_kernel(function.place, 0, false);
            let value = self.enter(function, &[], function.place);
            self.end_kernel(function.place);
            return value;
        };
        if let Some(why) = self.maybe.clone() {
            let message = format!("whether this kernel runs, {why} decides");
            self.unknown(place, message, &why, None);
        }
        self.passes(words.len());
        if self.asks(words.len(), place) && !words.is_empty() {
            self.push(Node::Kernel(words.to_vec()), self.files.own(function.place));
        }
        Value::Whole(0)
    }
}
