//! Kernels: where they begin and end, and objects that hold them.

use std::rc::Rc;

use crate::{
    config::{Fault, Place},
    program::vendor::{
        interpreter::{
            machine::{Location, Machine},
            value::{Slot, Value},
        },
        syntax::tree::{Function, Words},
    },
};

/// The class whose objects hold kernels.
pub(in crate::program::vendor) const CLASS: &str = "scamp5_kernel";

impl Machine<'_> {
    /// Tells of a kernel that begins or ends inside a value.
    pub(in crate::program::vendor) fn no_statement(&mut self, name: &str, place: Place) -> Value {
        self.error(
            place,
            format!("`{name}` is used inside an expression"),
            "it begins or ends a block",
            &format!("write `{name}();` as a statement of its own"),
        );
        Value::Whole(0)
    }

    /// An object that holds a kernel of no words.
    pub(in crate::program::vendor) fn empty_kernel(place: Place) -> Value {
        let mut function = Function::new("".into(), place);
        function.words = Some(Words::default());
        Value::Lambda(function.into())
    }

    /// What holds a kernel that is made of a lambda: the words that it has now.
    pub(in crate::program::vendor) fn kernel_of(&mut self, function: Rc<Function>) -> Value {
        let read = self.read_with_values(&function.body);
        let outer = self.begin_recording(function.place);
        self.enter(&function, &[], function.place);
        let mut words = self.end_recording();
        self.recording = outer;
        words.read = Some(self.keep_read(read));
        let mut function = Rc::unwrap_or_clone(function);
        function.words = Some(words);
        Value::Lambda(function.into())
    }

    /// What lies somewhere is called with a lambda: it is a kernel then that has the words of that. An
    /// object that has words keeps them, as the chip's does.
    pub(in crate::program::vendor) fn filled_with(
        &mut self,
        (slot, path): (Slot, &[usize]),
        function: Rc<Function>,
    ) -> Value {
        const HELP: &str = "a `scamp5_kernel` object is recorded only once: use another object for other instructions";
        let held = match self.peek(slot, path) {
            Some(Value::Lambda(held)) => Some(Rc::clone(held)),
            _ => None,
        };
        let words = held.as_ref().and_then(|it| it.words.as_ref());
        if let (Some(held), Some(words)) = (&held, words)
            && !words.items.is_empty()
        {
            if held.place.start == function.place.start {
                self.tell_changed(words, function.place, HELP);
            } else {
                let message = format!(
                    "this kernel is already recorded, in {}",
                    self.line(held.place)
                );
                let fault = Fault::warning(
                    function.place,
                    message,
                    "the chip keeps the first recording",
                );
                self.fault(fault.help(HELP));
            }
            return Value::Lambda(Rc::clone(held));
        }
        let is_object = words.is_some();
        let value = if is_object || self.is_kernel(&function) {
            self.kernel_of(function)
        } else {
            Value::Lambda(function)
        };
        self.put(slot, path, value.clone());
        value
    }

    /// A function of an object that holds a kernel.
    pub(in crate::program::vendor) fn kernel_method(
        &mut self,
        function: &Rc<Function>,
        (slot, path): Location,
        member: &str,
        place: Place,
    ) -> Value {
        match member {
            "begin" | "recording_start" => {
                self.begin_recording(place);
            }
            "end" | "recording_stop" if self.recording.is_some() => {
                let words = Some(self.end_recording());
                let function = Function {
                    words,
                    ..Function::clone(function)
                };
                self.put(slot, &path, Value::Lambda(function.into()));
            }
            "end" | "recording_stop" => self.error(
                place,
                "this ends no kernel".to_owned(),
                "none is open",
                "begin it with `begin();` of the same object",
            ),
            "launch" => return self.launch(function, place),
            "null" => {
                let words = function.words.as_ref();
                return Value::flag(words.is_none_or(|it| it.items.is_empty()));
            }
            _ => {
                self.error(
                    place,
                    format!("`{CLASS}` has no known member function `{member}`"),
                    "this call",
                    "it has `begin()`, `end()`, `launch()` and `null()`, and can be constructed from a lambda: `kernel([] { … });`",
                );
            }
        }
        Value::Whole(0)
    }

    pub(in crate::program::vendor) fn launch(
        &mut self,
        function: &Rc<Function>,
        place: Place,
    ) -> Value {
        let Some(words) = &function.words else {
            let outer = self.begin_recording(function.place);
            let value = self.enter(function, &[], function.place);
            let words = self.end_recording();
            self.recording = outer;
            self.launched(&words, (function.place, 0));
            return value;
        };
        if self.may_launch(words, place) {
            self.launched(words, (function.place, 0));
        }
        Value::Whole(0)
    }
}
