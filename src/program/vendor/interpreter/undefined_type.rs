//! Objects of types that nothing defines here, and words that stand where they do nothing.

use std::borrow::Cow;

use super::{machine::Machine, value::Value};
use crate::{
    config::{Fault, suggestion},
    program::vendor::{
        frame::kernel,
        host::{Random, vendors},
        syntax::tree::{Declared, Expr, ExprNode, Function, Kind, OF_OTHERS, last},
    },
};

/// Types of the language's library that hold what they are given, registers too.
const HOLDERS: [&str; 14] = [
    "array",
    "auto",
    "deque",
    "forward_list",
    "function",
    "initializer_list",
    "list",
    "optional",
    "pair",
    "string",
    "tuple",
    "valarray",
    "vector",
    "void",
];

impl Machine<'_> {
    /// What a declaration leaves to be done, once it is known what an object of a type that is defined
    /// elsewhere is given.
    pub(super) fn begun<'b>(&mut self, it: &'b Declared) -> Cow<'b, Declared> {
        let plain = !it.pointer && !it.reference && !it.library;
        let strange = plain && it.kind == Kind::Any && self.strange(&it.of);
        if strange && !self.device.callables(&it.of).is_empty() {
            self.no_type(&it.of, it);
        } else if strange {
            self.misspelt(it);
        }
        match it.value.as_ref().map(|it| &it.node) {
            Some(ExprNode::Call(callee, given)) if matches!(&callee.node, ExprNode::Name(name) if &**name == OF_OTHERS) =>
            {
                if strange && !self.device.callables(&it.name).is_empty() {
                    self.no_name(it);
                }
                self.given_elsewhere(it, given, strange);
                Cow::Owned(Declared {
                    value: None,
                    ..it.clone()
                })
            }
            Some(ExprNode::Braces(given)) if strange && it.lengths.is_empty() => {
                self.keeps_registers(it, given);
                Cow::Borrowed(it)
            }
            _ => Cow::Borrowed(it),
        }
    }

    /// What an object is given by whom nothing is known.
    fn given_elsewhere(&mut self, it: &Declared, given: &[Expr], strange: bool) {
        if it.lasting {
            // It is made once, and declared again in every frame.
            if strange {
                self.keeps_registers(it, given);
            }
        } else if strange {
            self.outside(last(&it.of), given, it.place);
        } else {
            for value in given {
                self.value(value);
            }
        }
    }

    /// Tells of registers among what an object is given.
    fn keeps_registers(&mut self, it: &Declared, given: &[Expr]) {
        for value in given {
            if let ExprNode::Name(_) = value.node {
                let held = self.value(value);
                self.keeps_register(last(&it.of), &held, it.place);
            }
        }
    }

    /// Whether neither the file nor the libraries that are known here have a type of this name.
    fn strange(&self, of: &str) -> bool {
        let name = last(of);
        let known = HOLDERS.contains(&name)
            || matches!(name, "" | "AREG" | "DREG" | kernel::CLASS)
            || vendors(name)
            || Random::named(name).is_some();
        !known
            && !self.layouts.contains_key(of)
            && !self.layouts.contains_key(name)
            && !self.unread.contains_key(name)
            && !self.enumerations.contains_key(name)
    }

    /// Tells of a type that no file defines, where one has nearly its name.
    fn misspelt(&mut self, it: &Declared) {
        let of = last(&it.of);
        let known = self.layouts.keys().chain(self.enumerations.keys());
        let near = suggestion(of, known.map(|name| last(name)));
        if let (Some(near), true) = (near, self.missing.is_empty()) {
            let message = format!("the type `{of}` is not defined in any file here");
            self.error(it.place, message, "this declaration", &near);
        }
    }

    /// Tells of an instruction where a type stands.
    fn no_type(&mut self, of: &str, it: &Declared) {
        let message = format!("`{of}` is a statement of the chip, not a type");
        let help = format!("write `{of}(…);`, and what follows as a separate statement");
        self.error(it.place, message, "this would declare a variable", &help);
    }

    /// Tells of an instruction where the name of an object stands whose type nothing defines.
    fn no_name(&mut self, it: &Declared) {
        let (name, of) = (&it.name, last(&it.of));
        let message = format!("`{name}` is a statement of the chip, and `{of}` is not a type here");
        let help = format!("write `{name}(…);` as a separate statement, or rename the variable");
        self.error(it.place, message, "this would declare a variable", &help);
    }

    /// Tells of a function that seems to be declared where two statements stand: `nop all();`.
    pub(super) fn seems_declared(&mut self, it: &Function) {
        let of = &it.gives;
        if it.returns != Kind::Any || !self.strange(of) {
            return;
        }
        let inside = self.scopes.len() > 1 && !self.device.callables(&it.name).is_empty();
        if inside || !self.device.callables(of).is_empty() {
            let message = format!(
                "`{of}` is not a type, but `{}` is declared with it",
                it.name
            );
            let help = "a statement is `name(argument, argument);`, and ends before the next one";
            self.error(it.place, message, "this would declare a function", help);
        }
    }

    /// Warns of a statement that is a function or registers alone.
    pub(super) fn does_nothing(&mut self, it: &Expr, held: &Value) {
        let told = |fault: &Fault| fault.place.start == it.place.end;
        if self.faults.iter().any(told) {
            return;
        }
        let fault = |help: &str| {
            let message = "this statement does nothing".to_owned();
            Fault::warning(it.place, message, "its value is not used").help(help)
        };
        match (&it.node, held) {
            (ExprNode::Name(_), Value::Symbol(name)) => {
                let called = !self.device.callables(name).is_empty()
                    || self.functions.contains_key(last(name));
                if called {
                    let help = format!("write `{name}(…);` to call it, or remove it");
                    self.fault(fault(&help));
                } else if self.device.value_of(name).is_some() {
                    self.fault(fault("write what to do with it, or remove it"));
                } else if &**name != "this" {
                    self.unheard(name, it.place);
                }
            }
            (ExprNode::Binary(operator, ..), Value::Symbols(_)) if *operator != "," => {
                self.fault(fault("write what to do with it, such as `add(C, A, B);`"));
            }
            _ => {}
        }
    }
}
