//! Statements, run one after the other.

use std::rc::Rc;

use super::{
    lvalue::Reach,
    machine::{Flow, Location, Machine},
    reason::Reason,
    value::Value,
};
use crate::{
    config::{Fault, Place},
    program::vendor::{
        analysis::effects,
        syntax::tree::{Declared, Expr, Function, Kind, Stmt, StmtNode},
    },
};

impl Machine<'_> {
    /// Runs statements in a scope of their own.
    pub(in crate::program::vendor) fn block(&mut self, statements: &[Stmt]) -> Flow {
        self.scopes.push(std::collections::BTreeMap::new());
        let flow = self.statements(statements);
        self.scopes.pop();
        flow
    }

    pub(in crate::program::vendor) fn statements(&mut self, statements: &[Stmt]) -> Flow {
        for statement in statements {
            if self.done() {
                return Flow::End;
            }
            match self.statement(statement) {
                Flow::Next => {}
                other => return other,
            }
        }
        Flow::Next
    }

    fn statement(&mut self, it: &Stmt) -> Flow {
        let flow = self.deeper(it.place, |inner| inner.done_by(it));
        flow.unwrap_or(Flow::End)
    }

    fn done_by(&mut self, it: &Stmt) -> Flow {
        self.work(it.place);
        match &it.node {
            StmtNode::Block(inner) | StmtNode::Namespace(_, inner) => return self.block(inner),
            StmtNode::Kernel(kernel) => return self.kernel(kernel),
            StmtNode::Declare(all) => {
                for declared in all {
                    self.declare(declared);
                }
            }
            StmtNode::Expr(value) => {
                let held = self.value(value);
                self.does_nothing(value, &held);
                if self.looped {
                    return Flow::End;
                }
            }
            StmtNode::If(condition, yes, no) => return self.branch(condition, yes, no.as_deref()),
            StmtNode::For(start, condition, step, body) => {
                self.scopes.push(std::collections::BTreeMap::new());
                if let Some(start) = start {
                    self.statement(start);
                }
                let flow = self.iterations(it, condition.as_ref(), step.as_ref(), body, false);
                self.scopes.pop();
                return flow;
            }
            StmtNode::Each(it, list, body) => return self.each(it, list, body),
            StmtNode::While(condition, body) => {
                return self.iterations(it, Some(condition), None, body, false);
            }
            StmtNode::DoWhile(body, condition) => {
                return self.iterations(it, Some(condition), None, body, true);
            }
            StmtNode::Switch(on, body) => return self.switch(on, body),
            StmtNode::Prototype(function) => {
                self.seems_declared(function);
                self.declare_function(function);
            }
            StmtNode::Case(_) | StmtNode::Nothing => {}
            StmtNode::Break => return Flow::Break,
            StmtNode::Continue => return Flow::Continue,
            StmtNode::Return(None) => return Flow::Return(Value::Whole(0)),
            StmtNode::Return(Some(value)) if self.refers => {
                return Flow::Return(match self.reach(value) {
                    Reach::Location(slot, path) => Value::Reference(slot, path),
                    reached => self.load(&reached, value),
                });
            }
            StmtNode::Return(Some(value)) => return Flow::Return(self.value(value)),
            StmtNode::Function(function) => {
                self.define(function);
                if function.is_operator() {
                    self.check_members(std::slice::from_ref(function));
                }
            }
            StmtNode::Struct(class) => self.class(class, it.place),
            StmtNode::Class(members) => {
                self.define_members(members);
                self.check_members(members);
                // Those in a class are, when that is known.
                let behind = |it: &&Rc<Function>| it.qualified;
                let behind: Vec<_> = members.iter().filter(behind).cloned().collect();
                self.refuse_ends(&behind);
            }
        }
        Flow::Next
    }

    /// The value of a condition.
    pub(in crate::program::vendor) fn condition(&mut self, it: &Expr) -> Value {
        match self.value(it) {
            Value::Symbol(name) if self.device.value_of(&name).is_none() => {
                self.unheard(&name, it.place)
            }
            value if self.no_number(&value, it.place) => Value::Whole(0),
            value => value,
        }
    }

    fn branch(&mut self, condition: &Expr, yes: &Stmt, no: Option<&Stmt>) -> Flow {
        let (mut condition, mut yes, mut no) = (condition, yes, no);
        loop {
            let value = self.condition(condition);
            match (value.truth(), no) {
                (Ok(true), _) => return self.scoped(yes),
                (Ok(false), None) => return Flow::Next,
                (Ok(false), Some(other)) => {
                    // `else if` is no deeper than the `if` before it.
                    let StmtNode::If(next, then, otherwise) = &other.node else {
                        return self.scoped(other);
                    };
                    self.work(other.place);
                    (condition, yes, no) = (next, then, otherwise.as_deref());
                }
                (Err(why), no) => {
                    let parts: Vec<&Stmt> = [Some(yes), no].into_iter().flatten().collect();
                    return self.either(condition, &parts, &why);
                }
            }
        }
    }

    /// Branches of which only the run knows which is taken. What they show is shown beside the array
    /// alone; what they compute is forgotten; that they change the array is a fault.
    pub(super) fn either(&mut self, on: &Expr, parts: &[&Stmt], why: &Reason) -> Flow {
        let changes = parts.iter().any(|part| effects::changes(self, part));
        if changes {
            let message = format!("whether this kernel runs depends on {why}");
            self.unknown(on.place, message, why, Some(on));
        } else if parts.iter().any(|part| effects::reads(self, part)) {
            self.unread(on.place, "whether this is read out", why);
        } else if parts.iter().any(|part| effects::shows(self, part)) {
            self.shown(on.place, "whether this is shown", why);
        } else if self.companion.is_some() && parts.iter().any(|part| effects::posts(self, part)) {
            self.unread(on.place, "whether this is posted", why);
        }
        for part in parts {
            effects::forget(self, part, why);
            if changes {
                // For the faults that are in it, but for those that follow from this one.
                let (told, maybe) = (self.undecided.len(), self.maybe.clone());
                self.scoped(part);
                let mut at = 0..;
                let follows = |it: &Fault| it.message.contains(&why.to_string());
                self.undecided
                    .retain(|it| at.next() < Some(told) || !follows(it));
                self.maybe = maybe;
            } else if self.companion.is_some() {
                effects::show(self, part);
            }
            effects::forget(self, part, why);
            if effects::leaves(part) {
                self.maybe = Some(why.clone());
                self.left += usize::from(effects::ends(part));
            }
        }
        Flow::Next
    }

    pub(in crate::program::vendor) fn scoped(&mut self, it: &Stmt) -> Flow {
        match &it.node {
            StmtNode::Block(inner) => self.block(inner),
            _ => self.block(std::slice::from_ref(it)),
        }
    }

    fn switch(&mut self, on: &Expr, body: &[Stmt]) -> Flow {
        let value = self.value(on);
        if let Value::Unknown(why) = &value {
            return self.any_case(on, body, &why.clone());
        }
        let mut start = None;
        for (i, statement) in body.iter().enumerate() {
            match &statement.node {
                StmtNode::Case(Some(case)) => match self.is_case(case, &value, on.place) {
                    Ok(true) => {
                        start = Some(i);
                        break;
                    }
                    Ok(false) => {}
                    Err(why) => return self.any_case(on, body, &why),
                },
                StmtNode::Case(None) => start = start.or(Some(i)),
                _ => {}
            }
        }
        // `default` counts only where no case does.
        let Some(start) = start else {
            return Flow::Next;
        };
        match self.block(&body[start..]) {
            Flow::Break => Flow::Next,
            other => other,
        }
    }

    /// A `switch` of which only the run knows which case is taken.
    fn any_case(&mut self, on: &Expr, body: &[Stmt], why: &Reason) -> Flow {
        let parts: Vec<&Stmt> = body.iter().collect();
        let (maybe, left) = (self.maybe.clone(), self.left);
        self.either(on, &parts, why);
        // A `break` in it ends the switch, and nothing more.
        if !body.iter().any(effects::leaves_switch) {
            (self.maybe, self.left) = (maybe, left);
        }
        Flow::Next
    }

    /// Whether a case is of this value: `case value:`, or `case first ... last:`; the reason where only
    /// the run knows.
    fn is_case(&mut self, case: &Expr, value: &Value, place: Place) -> Result<bool, Reason> {
        let held = self.value(case);
        let Value::List(ends) = &held else {
            let on = (value.clone(), place);
            return self
                .operated("==", on, (held, case.place), case.place)
                .truth();
        };
        let ends: Option<Vec<f64>> = ends.iter().map(Value::number).collect();
        Ok(match (ends.as_deref(), value.number()) {
            (Some([first, last]), Some(value)) => (*first..=*last).contains(&value),
            _ => false,
        })
    }

    fn each(&mut self, it: &Declared, list: &Expr, body: &Stmt) -> Flow {
        let reached = self.reach(list);
        let (mut location, listed) = match &reached {
            Reach::Location(slot, path) => match self.at(*slot, path) {
                Value::Pointer(slot, path, _) => {
                    let listed = self.at(slot, &path);
                    (Some((slot, path)), listed)
                }
                listed => (Some((*slot, path.clone())), listed),
            },
            other => (None, self.load(other, list)),
        };
        if let (Value::Unknown(_), Some(why)) = (&listed, self.not_followed(&reached)) {
            let message = format!("how often this loop runs depends on {why}");
            self.unknown(list.place, message, &why, None);
            return Flow::Next;
        }
        if let Value::Unknown(why) = &listed {
            let message = format!("how often this loop runs depends on {why}");
            self.unknown(list.place, message, why, None);
            let why = why.clone();
            effects::forget(self, body, &why);
            return Flow::Next;
        }
        let mut of = match &location {
            Some((slot, path)) => self.kind_at(*slot, path),
            None => Kind::Any,
        };
        let listed = match listed {
            Value::Text(text) => {
                // They lie nowhere by themselves.
                if location.take().is_some() && it.reference && !it.constant {
                    self.changes_text(list.place);
                }
                of = Kind::CHARACTER;
                characters(&text)
            }
            listed => listed,
        };
        if let (Value::Record(layout, _), None) = (&listed, &location)
            && layout.entry.is_some()
        {
            // A map that a function gives back.
            location = Some((self.hold(listed.clone(), Kind::Any), Vec::new()));
        }
        let (listed, places) = match (listed, &location) {
            (Value::Record(layout, all), Some((slot, path))) if layout.entry.is_some() => {
                let places = self.ordered_by_key(*slot, path, list.place);
                let listed = places.iter().map(|at| all[*at].clone()).collect();
                (Value::List(listed), Some(places))
            }
            (listed, _) => (listed, None),
        };
        let Value::List(all) = listed else {
            self.error(
                list.place,
                "the values of this list are not known".to_owned(),
                "the loop goes over it",
                "write the values in the file: `int all[] = {1, 2, 3};`",
            );
            return Flow::Next;
        };
        for (i, value) in all.into_iter().enumerate() {
            self.scopes.push(std::collections::BTreeMap::new());
            match &location {
                Some((slot, path)) if it.reference => {
                    let at = places.as_ref().map_or(i, |it| it[i]);
                    let path = [&path[..], &[at]].concat();
                    self.refer(&it.name, (*slot, path));
                }
                _ => {
                    let kind = match self.resolved(it.kind) {
                        // `auto`: of the type of the elements.
                        Kind::Any if !it.pointer => of,
                        kind => kind,
                    };
                    let value = value.converted(kind);
                    let element = { location.as_ref() }.map(|(slot, path)| {
                        let at = places.as_ref().map_or(i, |it| it[i]);
                        (*slot, [&path[..], &[at]].concat())
                    });
                    self.make_each(it, (value, element), kind);
                }
            }
            let flow = self.scoped(body);
            self.scopes.pop();
            match flow {
                Flow::Next | Flow::Continue => {}
                Flow::Break => break,
                other => return other,
            }
        }
        Flow::Next
    }
}

impl Machine<'_> {
    /// The variable of a loop over elements: one of them.
    fn make_each(
        &mut self,
        it: &Declared,
        (value, element): (Value, Option<Location>),
        kind: Kind,
    ) {
        let plain = !it.pointer && self.is_string(&it.of);
        let text = { element.as_ref() }.is_some_and(|(slot, path)| self.string_at(*slot, path));
        let value = match (value, element) {
            // A row of characters.
            (Value::List(_), Some((slot, path))) if plain => {
                let path = [&path[..], &[0]].concat();
                self.string_of(Value::Pointer(slot, path, it.name.clone()))
            }
            (value, _) if plain => self.string_of(value),
            (value, _) => value,
        };
        let slot = self.make(&it.name, value, kind);
        if plain || text && &*it.of == "auto" {
            self.classes.insert(slot, "string".into());
        }
    }

    /// Tells of characters that a loop could assign to.
    fn changes_text(&mut self, place: Place) {
        self.error(
            place,
            "changing the characters of a string one by one is not supported".to_owned(),
            "the loop variable is a reference",
            "loop over `char` or `const char &`, and build a new string",
        );
    }
}

/// The characters of a text, without the 0 at its end.
fn characters(text: &str) -> Value {
    let code = |code| Value::Whole(i64::from(code)).converted(Kind::CHARACTER);
    Value::List(text.bytes().map(code).collect())
}
