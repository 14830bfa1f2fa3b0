//! Functions of objects that are not run: what they could change is not known afterwards.

use std::rc::Rc;

use crate::{
    config::Place,
    program::vendor::{
        analysis::effects,
        interpreter::{
            lvalue::{Reach, base_name},
            machine::Machine,
            reason::Reason,
            value::Value,
        },
        syntax::tree::{Expr, ExprNode, Function},
    },
};

impl Machine<'_> {
    /// A call of `object.member`, which is nothing that can be run.
    pub(in crate::program::vendor) fn unfollowed(
        &mut self,
        callee: &Expr,
        (reached, name, member): (&Reach, &str, &str),
        given: &[Expr],
        place: Place,
    ) -> Value {
        let held = self.reached(reached);
        let record = matches!(held, Some(Value::Record(..)));
        let why = match (held, reached) {
            (Some(Value::Unknown(why)), _) | (_, Reach::Lost(_, _, why)) => Some(why.clone()),
            _ => None,
        };
        let chosen = matches!(&callee.node, ExprNode::Member(of, _) if self.chosen(of));
        if let Some(why @ Reason::Run(_)) = why.clone()
            && (chosen || self.acting(member).is_some())
        {
            let message = format!("what `{name}.{member}` runs depends on {why}");
            self.unknown(place, message, &why, None);
            return Value::Unknown(why);
        }
        if self.words_of_nobody((name, member), given, place) {
            return Value::Unknown(format!("`{name}.{member}`").into());
        }
        let cause = match &why {
            Some(why) => Some(why.clone()),
            None => self.not_followed(reached),
        };
        if self.leaves_array((name, member), cause.as_ref(), place) {
            self.outside(&format!("{name}.{member}"), given, place);
        }
        let why = self.not_followed(reached);
        let does: Reason = format!("what `{name}.{member}` does").into();
        self.forget_called(callee, given, &why.clone().unwrap_or_else(|| does.clone()));
        if let Some(why) = why {
            return Value::Unknown(why);
        }
        // What it does with the members of its object is not known.
        if let (Reach::Location(slot, path), true) = (reached, record) {
            self.forget(*slot, path, &does);
        }
        Value::Unknown(format!("`{name}.{member}`").into())
    }

    /// Tells of a word of the chip that is called as a function of an object whose class no file
    /// here defines, with registers of that object: `s.add(s.A, s.A, s.B)`.
    fn words_of_nobody(
        &mut self,
        (name, member): (&str, &str),
        given: &[Expr],
        place: Place,
    ) -> bool {
        let register = |it: &Expr| match &it.node {
            ExprNode::Member(of, part) if base_name(of) == name => {
                self.device.value_of(part).is_some().then(|| part.clone())
            }
            _ => None,
        };
        let Some(first) = given.iter().find_map(register) else {
            return false;
        };
        if self.device.callables(member).is_empty() || !effects::members(self, member).is_empty() {
            return false;
        }
        let message = format!("what `{name}.{member}` does with `{name}.{first}` is not known");
        let own = |it: &Expr| {
            let text = self.files.written(self.text, it.place);
            let member = text.strip_prefix(name).unwrap_or_default();
            let member = member.strip_prefix('.').or(member.strip_prefix("->"));
            member.unwrap_or(text).to_owned()
        };
        let all: Vec<String> = given.iter().map(own).collect();
        let help = format!(
            "no file here defines the class of `{name}`: write `{member}({});`",
            all.join(", ")
        );
        self.error(place, message, "this call", &help);
        true
    }

    /// `dynamic_cast<Class *>(pointer)`: null where the object is of another class.
    pub(super) fn as_class(&mut self, class: &Expr, of: &Expr) -> Value {
        let pointer = self.value(of);
        let (Value::Pointer(slot, path, _), ExprNode::Text(class)) = (&pointer, &class.node) else {
            return pointer;
        };
        let (slot, path) = self.pointed(*slot, path.clone());
        match self.peek(slot, &path) {
            Some(Value::Record(layout, _)) if !layout.line().any(|it| it.name == *class) => {
                Value::Whole(0)
            }
            Some(Value::Record(..)) => pointer,
            _ => Value::Unknown("what `dynamic_cast` gives".into()),
        }
    }

    /// Forgets what the functions assign that this may call: variables of the file, and those that
    /// it is given by reference.
    pub(in crate::program::vendor) fn forget_called(
        &mut self,
        callee: &Expr,
        given: &[Expr],
        why: &Reason,
    ) {
        let (ExprNode::Member(_, name) | ExprNode::Name(name)) = &callee.node else {
            return;
        };
        let all = effects::members(self, name);
        if all.is_empty() {
            return;
        }
        let call = Expr {
            node: ExprNode::Call(callee.clone().into(), given.to_vec()),
            place: callee.place,
        };
        effects::forget(self, &effects::statement(&call), why);
        for (at, it) in given.iter().enumerate() {
            // Of a function that is not read it is not known either what it takes.
            let written = |of: &Rc<Function>| of.parameters.get(at).is_none_or(|it| it.reference);
            if all.iter().any(written)
                && self.has_place(it)
                && let Reach::Location(slot, path) = self.reach(it)
            {
                self.forget(slot, &path, why);
            }
        }
    }

    /// A member of a class of the file is called: classes are not run, so that it must leave the
    /// array alone.
    fn leaves_array(
        &mut self,
        (name, member): (&str, &str),
        cause: Option<&Reason>,
        place: Place,
    ) -> bool {
        let Some(acting) = self.acting(member) else {
            return true;
        };
        let line = self.line(acting.place);
        let cause = cause.map_or_else(String::new, |it| format!("the reason is {it}: "));
        self.error(
            place,
            format!(
                "`{name}.{member}` runs instructions of the array, but member functions of this class are not supported"
            ),
            "this call",
            &format!(
                "{cause}make `{member}`, in {line}, a function outside the class, and call that"
            ),
        );
        false
    }

    /// A function of this name of a class that runs words of the array.
    fn acting(&self, member: &str) -> Option<Rc<Function>> {
        let acts = |it: &Rc<Function>| it.body.iter().any(|it| effects::changes(self, it));
        effects::members(self, member).into_iter().find(acts)
    }
}
