//! Functions of classes that hold data and nothing more: they are run with their object.

use std::rc::Rc;

use super::{
    super::{
        machine::{Location, Machine},
        parse::UNREAD,
        reach::Reach,
        shape,
        tree::{Expr, ExprNode, Function, Kind, StmtNode, Word},
        value::{Layout, Slot, Value, unassigned},
    },
    Argument,
};
use crate::{config::Place, unit::counted};

impl Machine<'_> {
    /// Calls a function of an object; nothing where its class defines none that can be run.
    pub(super) fn member_call(
        &mut self,
        layout: &Rc<Layout>,
        object: &Reach,
        member: &str,
        given: &[Expr],
        place: Place,
    ) -> Option<Value> {
        let fitting = layout.fitting(member, given.len());
        if fitting.is_empty() {
            return None;
        }
        let location = match object {
            Reach::Location(slot, path) => (*slot, path.clone()),
            Reach::Value(value) => (self.hold(value.clone(), Kind::Any), Vec::new()),
            Reach::Lost(..) | Reach::Beyond(_) => return None,
        };
        let given: Vec<_> = given.iter().map(|it| self.argument(it)).collect();
        let Some(function) = self.overload(member, &fitting, &given, place) else {
            return Some(Value::Whole(0));
        };
        Some(self.enter_member(layout, &function, &location, given, place))
    }

    /// Runs a function of an object.
    fn enter_member(
        &mut self,
        layout: &Rc<Layout>,
        function: &Function,
        object: &Location,
        given: Vec<Argument>,
        place: Place,
    ) -> Value {
        let mut held = self.members_of(layout, object);
        // Each name is a variable, and is looked up in the call.
        self.looks(8 * (layout.members.len() + layout.functions.len()));
        for other in layout.functions.iter().filter(|it| runs(it)) {
            let mut own = Function::clone(other);
            own.held.clone_from(&held);
            self.passes(8 * held.len());
            let slot = self.hold(Value::Lambda(own.into()), Kind::Any);
            held.push((other.name.clone(), slot));
        }
        let mut function = function.clone();
        function.held = held;
        self.enter_with(&function.into(), given, None, place)
    }

    /// An object of a class with constructors, made of these.
    pub(in crate::program::vendor) fn constructed(
        &mut self,
        layout: &Rc<Layout>,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let name = &layout.name;
        let fitting = layout.fitting(name, given.len());
        let given: Vec<_> = given.iter().map(|it| self.argument(it)).collect();
        let same = |it: &Value| matches!(it, Value::Record(of, _) if of.name == *name);
        let copied = match &given[..] {
            [only] if same(&only.value) => Some(only.value.clone()),
            _ => None,
        };
        let copies = |it: &&Rc<Function>| it.parameters.first().is_some_and(|of| of.of == *name);
        let copying = fitting.iter().find(copies).cloned();
        if let (Some(copied), None) = (&copied, &copying) {
            return copied.clone();
        }
        let unknown = Value::Unknown(format!("an object of `{name}`").into());
        if fitting.is_empty() {
            let given = counted(given.len(), "value");
            self.error(
                place,
                format!("no constructor of `{name}` takes {given}"),
                "made here",
                "give what one of its constructors takes",
            );
            return unknown;
        }
        let function = match copied {
            Some(_) => copying,
            None => self.overload(name, &fitting, &given, place),
        };
        let Some(function) = function else {
            return unknown;
        };
        let fresh = shape::fresh(layout, &Value::Unknown(unassigned(name)));
        let slot = self.hold(fresh, Kind::Any);
        self.enter_member(layout, &function, &(slot, Vec::new()), given, place);
        self.slots[slot].clone()
    }

    /// What the functions of an object call its members by.
    fn members_of(&mut self, layout: &Layout, (slot, path): &Location) -> Vec<(Word, Slot)> {
        let mut held: Vec<(Word, Slot)> = Vec::new();
        for (i, member) in layout.members.iter().enumerate() {
            let own = Value::Reference(*slot, [&path[..], &[i]].concat());
            held.push((member.name.clone(), self.hold(own, Kind::Any)));
        }
        let this = Value::Pointer(*slot, path.clone(), "this".into());
        held.push(("this".into(), self.hold(this, Kind::Any)));
        held
    }
}

impl Layout {
    /// The functions of this name that take so many arguments and can be run.
    fn fitting(&self, name: &str, given: usize) -> Vec<Rc<Function>> {
        let fits = |it: &&Rc<Function>| {
            let least = it.parameters.iter().filter(|it| it.default.is_none());
            *it.name == *name && (least.count()..=it.parameters.len()).contains(&given) && runs(it)
        };
        self.functions.iter().filter(fits).cloned().collect()
    }

    /// Whether its objects are made by a constructor.
    pub(in crate::program::vendor) fn constructs(&self) -> bool {
        self.functions
            .iter()
            .any(|it| it.name == self.name && !it.hidden)
    }
}

/// Whether all of a function was understood.
fn runs(it: &Function) -> bool {
    it.template.is_empty()
        && !it.hidden
        && it.body.iter().all(|part| match &part.node {
            StmtNode::Expr(Expr {
                node: ExprNode::Call(callee, _),
                ..
            }) => !matches!(&callee.node, ExprNode::Name(name) if name.starts_with(UNREAD)),
            _ => true,
        })
}
