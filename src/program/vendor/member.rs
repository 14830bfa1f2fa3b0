//! Functions of classes that hold data and nothing more: they are run with their object.

use std::rc::Rc;

use super::{
    evaluate::Reach,
    machine::{Machine, Spot},
    parse::UNREAD,
    tree::{Expr, ExprNode, Function, Kind, StmtNode, Word},
    value::{Layout, Slot, Value},
};
use crate::config::Place;

impl Machine<'_> {
    /// Calls a function of an object; nothing where its class states none that can be run.
    pub(super) fn member_call(
        &mut self,
        layout: &Rc<Layout>,
        object: &Reach,
        member: &str,
        given: &[Expr],
        place: Place,
    ) -> Option<Value> {
        let fits = |it: &&Rc<Function>| {
            let least = it.parameters.iter().filter(|it| it.default.is_none());
            *it.name == *member
                && (least.count()..=it.parameters.len()).contains(&given.len())
                && runs(it)
        };
        let mut fitting = layout.functions.iter().filter(fits);
        let function = fitting.next()?;
        if fitting.next().is_some() {
            return None;
        }
        let spot = match object {
            Reach::Spot(slot, path) => (*slot, path.clone()),
            Reach::Value(value) => (self.hold(value.clone(), Kind::Any), Vec::new()),
            Reach::Lost(..) | Reach::Beyond(_) => return None,
        };
        let mut held = self.members_of(layout, &spot);
        for other in layout.functions.iter().filter(|it| runs(it)) {
            let mut own = Function::clone(other);
            own.held.clone_from(&held);
            let slot = self.hold(Value::Lambda(own.into()), Kind::Any);
            held.push((other.name.clone(), slot));
        }
        let mut function = Function::clone(function);
        function.held = held;
        Some(self.enter(&function.into(), given, place))
    }

    /// What the functions of an object call its members by.
    fn members_of(&mut self, layout: &Layout, (slot, path): &Spot) -> Vec<(Word, Slot)> {
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
