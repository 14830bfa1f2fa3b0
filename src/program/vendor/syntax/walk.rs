//! The parts of a statement, one after the other, without running any.

use super::tree::{Expr, ExprNode, Kernel, Stmt, StmtNode, TemplateArgument, last};

/// A statement, or a value in one.
pub(in crate::program::vendor) enum Part<'a> {
    Stmt(&'a Stmt),
    Expr(&'a Expr),
}

/// Every call by a name in it, with the number of its arguments.
pub(in crate::program::vendor) fn calls(it: &Stmt, act: &mut dyn FnMut(&str, usize)) {
    walk(it, false, &mut |part| {
        if let Part::Expr(value) = part
            && let ExprNode::Call(callee, given) = &value.node
            && let ExprNode::Name(name) = &callee.node
        {
            act(last(name), given.len());
        }
    });
}

// A line for each part reads better than a loop for each.
#[allow(clippy::needless_for_each)]
/// Every statement and value in it; `own` leaves out what loops inside it have for themselves.
pub(in crate::program::vendor) fn walk(it: &Stmt, own: bool, act: &mut dyn FnMut(Part<'_>)) {
    act(Part::Stmt(it));
    match &it.node {
        StmtNode::Block(all)
        | StmtNode::Namespace(_, all)
        | StmtNode::Kernel(Kernel { body: all, .. }) => {
            all.iter().for_each(|it| walk(it, own, act));
        }
        StmtNode::Switch(on, all) => {
            values(on, act);
            if own {
                // Its `break` is its own.
                let kept = all.iter().filter(|it| !matches!(it.node, StmtNode::Break));
                kept.for_each(|it| walk(it, own, act));
            } else {
                all.iter().for_each(|it| walk(it, own, act));
            }
        }
        StmtNode::Declare(all) => {
            for declared in all {
                let lengths = declared.lengths.iter().flatten();
                lengths
                    .chain(&declared.value)
                    .for_each(|it| values(it, act));
            }
        }
        StmtNode::Expr(value) | StmtNode::Return(Some(value)) | StmtNode::Case(Some(value)) => {
            values(value, act);
        }
        StmtNode::If(condition, yes, no) => {
            values(condition, act);
            walk(yes, own, act);
            no.iter().for_each(|it| walk(it, own, act));
        }
        StmtNode::For(start, condition, step, body) => {
            start.iter().for_each(|it| walk(it, own, act));
            condition.iter().chain(step).for_each(|it| values(it, act));
            if !own {
                walk(body, own, act);
            }
        }
        StmtNode::Each(_, list, body) => {
            values(list, act);
            if !own {
                walk(body, own, act);
            }
        }
        StmtNode::While(condition, body) | StmtNode::DoWhile(body, condition) => {
            values(condition, act);
            if !own {
                walk(body, own, act);
            }
        }
        StmtNode::Case(None)
        | StmtNode::Break
        | StmtNode::Continue
        | StmtNode::Return(None)
        | StmtNode::Function(_)
        | StmtNode::Prototype(_)
        | StmtNode::Struct(_)
        | StmtNode::Class(_)
        | StmtNode::Nothing => {}
    }
}

#[allow(clippy::needless_for_each)]
pub(in crate::program::vendor) fn values(it: &Expr, act: &mut dyn FnMut(Part<'_>)) {
    act(Part::Expr(it));
    match &it.node {
        ExprNode::Call(callee, given) => {
            values(callee, act);
            given.iter().for_each(|it| values(it, act));
        }
        ExprNode::Member(of, _)
        | ExprNode::Unary(_, of)
        | ExprNode::Step(of, ..)
        | ExprNode::Convert(_, of)
        | ExprNode::Recast(_, of)
        | ExprNode::SizeOf(of) => values(of, act),
        ExprNode::Template(given, of) => {
            for it in given {
                if let TemplateArgument::Value(value) = it {
                    values(value, act);
                }
            }
            values(of, act);
        }
        ExprNode::New(declared) => declared.value.iter().for_each(|it| values(it, act)),
        ExprNode::Index(a, b) | ExprNode::Binary(_, a, b) | ExprNode::Assign(_, a, b) => {
            values(a, act);
            values(b, act);
        }
        ExprNode::Choose(a, b, c) => [a, b, c].into_iter().for_each(|it| values(it, act)),
        ExprNode::Braces(all) => all.iter().for_each(|it| values(it, act)),
        ExprNode::Designated(all) => all.iter().for_each(|(_, it)| values(it, act)),
        ExprNode::Block(all) => all.iter().for_each(|it| walk(it, false, act)),
        // Callbacks run when somebody moves a slider, not here.
        ExprNode::Lambda(_)
        | ExprNode::Whole(_)
        | ExprNode::Wide(..)
        | ExprNode::Real(_)
        | ExprNode::Text(_)
        | ExprNode::Name(_) => {}
    }
}

/// The variables of `std::tie(a, b)`.
pub(in crate::program::vendor) fn tied(it: &Expr) -> Option<&[Expr]> {
    match &it.node {
        ExprNode::Call(callee, given) => {
            let tie = matches!(&callee.node, ExprNode::Name(name) if matches!(&**name, "tie" | "std::tie"));
            tie.then_some(given)
        }
        _ => None,
    }
}
