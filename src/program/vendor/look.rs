//! What a part of the text could do, without running it: for branches of which only the run
//! knows whether they are taken.

use std::{collections::BTreeSet, sync::Arc};

use super::{
    host::{self, Role},
    machine::Machine,
    tree::{Expr, ExprNode, Stmt, StmtNode, Word},
    value::Value,
};

/// Whether it changes anything in the array.
pub(super) fn changes(machine: &Machine<'_>, it: &Stmt) -> bool {
    let mut seen = BTreeSet::new();
    let mut found = false;
    calls(it, &mut |name, given| {
        found |= acts(machine, name, given, &mut seen);
    });
    found
}

fn acts(machine: &Machine<'_>, name: &str, given: usize, seen: &mut BTreeSet<Word>) -> bool {
    if let Some(functions) = machine.functions.get(name) {
        if !seen.insert(name.into()) {
            return false;
        }
        let mut found = false;
        for function in functions {
            for statement in &function.body {
                calls(statement, &mut |name, given| {
                    found |= acts(machine, name, given, seen);
                });
            }
        }
        return found;
    }
    match host::role(name, given) {
        Role::Library | Role::Number | Role::Show | Role::Read | Role::Kernel => false,
        Role::Sync => true,
        Role::Chip => machine.find(name).is_none(),
    }
}

/// The first variable of a value that only the run knows.
pub(super) fn unknown(machine: &Machine<'_>, it: &Expr) -> Option<Word> {
    let mut found = None;
    values(it, &mut |part| {
        let Part::Expr(Expr {
            node: ExprNode::Name(name),
            ..
        }) = part
        else {
            return;
        };
        let slot = machine.find(name);
        if found.is_none()
            && slot.is_some_and(|slot| matches!(machine.slots[slot], Value::Unknown(_)))
        {
            found = Some(name.clone());
        }
    });
    found
}

/// Whether it can leave the block that it is in.
pub(super) fn leaves(it: &Stmt) -> bool {
    let mut found = false;
    walk(it, true, &mut |part| {
        found |= matches!(
            part,
            Part::Stmt(Stmt {
                node: StmtNode::Break | StmtNode::Continue | StmtNode::Return(_),
                ..
            })
        );
    });
    found
}

/// Forgets what it assigns.
pub(super) fn forget(machine: &mut Machine<'_>, it: &Stmt, why: &Arc<str>) {
    let mut names: Vec<Word> = Vec::new();
    let mut seen = BTreeSet::new();
    assigned(machine, it, &mut names, &mut seen);
    for name in names {
        let Some(slot) = machine.find(&name) else {
            continue;
        };
        match machine.slots[slot].clone() {
            Value::Pointer(slot, path, _) | Value::Reference(slot, path) => {
                machine.forget(slot, &path, why);
            }
            Value::Symbol(_) | Value::Lambda(_) => {}
            _ => machine.forget(slot, &[], why),
        }
    }
}

fn assigned(machine: &Machine<'_>, it: &Stmt, names: &mut Vec<Word>, seen: &mut BTreeSet<Word>) {
    let mut called = Vec::new();
    walk(it, false, &mut |part| {
        let Part::Expr(value) = part else { return };
        match &value.node {
            ExprNode::Assign(_, to, _) | ExprNode::Step(to, ..) => names.extend(base(to)),
            ExprNode::Unary("&", of) => names.extend(base(of)),
            ExprNode::Call(callee, given) => {
                // An array that is given may be written.
                let arrays = given.iter().filter_map(base);
                let list = |name: &Word| {
                    let slot = machine.find(name);
                    slot.is_some_and(|slot| {
                        matches!(machine.slots[slot], Value::List(_) | Value::Pointer(..))
                    })
                };
                names.extend(arrays.filter(list));
                if let ExprNode::Name(name) = &callee.node {
                    called.push(name.clone());
                }
            }
            _ => {}
        }
    });
    for name in called {
        if !seen.insert(name.clone()) {
            continue;
        }
        for function in machine.functions.get(&name).into_iter().flatten() {
            for statement in &function.body {
                assigned(machine, statement, names, seen);
            }
        }
    }
}

/// The variable that is meant by a target.
fn base(it: &Expr) -> Option<Word> {
    match &it.node {
        ExprNode::Name(name) => Some(name.clone()),
        ExprNode::Member(of, _) | ExprNode::Index(of, _) | ExprNode::Unary(_, of) => base(of),
        _ => None,
    }
}

/// Does what it shows and reads, where that is all it does to the array.
pub(super) fn show(machine: &mut Machine<'_>, it: &Stmt) {
    let mut shown = Vec::new();
    walk(it, false, &mut |part| {
        if let Part::Expr(value) = part
            && let ExprNode::Call(callee, given) = &value.node
            && let ExprNode::Name(name) = &callee.node
            && host::role(name, given.len()) == Role::Show
        {
            shown.push(value.clone());
        }
    });
    for call in shown {
        machine.value(&call);
    }
}

/// Whether frames begin in it.
pub(super) fn syncs(machine: &Machine<'_>, it: &Stmt) -> bool {
    let mut found = false;
    let mut seen = BTreeSet::new();
    calls(it, &mut |name, given| {
        found |= begins(machine, name, given, &mut seen);
    });
    found
}

fn begins(machine: &Machine<'_>, name: &str, given: usize, seen: &mut BTreeSet<Word>) -> bool {
    let Some(functions) = machine.functions.get(name) else {
        return host::role(name, given) == Role::Sync;
    };
    if !seen.insert(name.into()) {
        return false;
    }
    let mut found = false;
    for statement in functions.iter().flat_map(|function| &function.body) {
        calls(statement, &mut |name, given| {
            found |= begins(machine, name, given, seen);
        });
    }
    found
}

/// Whether it can leave a loop that has no condition.
pub(super) fn breaks(it: &Stmt) -> bool {
    let mut found = false;
    walk(it, true, &mut |part| {
        found |= matches!(
            part,
            Part::Stmt(Stmt {
                node: StmtNode::Break | StmtNode::Return(_),
                ..
            })
        );
    });
    found
}

/// Whether a kernel begins in it.
pub(super) fn begins_kernel(it: &Stmt) -> bool {
    let mut found = false;
    calls(it, &mut |name, given| {
        found |= host::role(name, given) == Role::Kernel;
    });
    found
}

enum Part<'a> {
    Stmt(&'a Stmt),
    Expr(&'a Expr),
}

fn calls(it: &Stmt, act: &mut dyn FnMut(&str, usize)) {
    walk(it, false, &mut |part| {
        if let Part::Expr(value) = part
            && let ExprNode::Call(callee, given) = &value.node
            && let ExprNode::Name(name) = &callee.node
        {
            act(name, given.len());
        }
    });
}

// A line for each part reads better than a loop for each.
#[allow(clippy::needless_for_each)]
/// Every statement and value in it; `own` leaves out what loops inside it have for themselves.
fn walk(it: &Stmt, own: bool, act: &mut dyn FnMut(Part<'_>)) {
    act(Part::Stmt(it));
    match &it.node {
        StmtNode::Block(all) => all.iter().for_each(|it| walk(it, own, act)),
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
        | StmtNode::Nothing => {}
    }
}

#[allow(clippy::needless_for_each)]
fn values(it: &Expr, act: &mut dyn FnMut(Part<'_>)) {
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
        | ExprNode::SizeOf(of)
        | ExprNode::Template(_, of) => values(of, act),
        ExprNode::New(declared) => declared.value.iter().for_each(|it| values(it, act)),
        ExprNode::Index(a, b) | ExprNode::Binary(_, a, b) | ExprNode::Assign(_, a, b) => {
            values(a, act);
            values(b, act);
        }
        ExprNode::Choose(a, b, c) => [a, b, c].into_iter().for_each(|it| values(it, act)),
        ExprNode::Braces(all) => all.iter().for_each(|it| values(it, act)),
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

/// Whether a function calls another.
pub(super) fn calls_function(it: &super::tree::Function, name: &str) -> bool {
    let mut found = false;
    for statement in &it.body {
        calls(statement, &mut |called, _| found |= called == name);
    }
    found && *it.name != *name
}

/// The names that a lambda uses, and those inside it.
pub(super) fn names(function: &super::tree::Function) -> BTreeSet<Word> {
    let mut found = BTreeSet::new();
    for statement in &function.body {
        walk(statement, false, &mut |part| {
            let Part::Expr(value) = part else { return };
            match &value.node {
                ExprNode::Name(name) => {
                    found.insert(name.clone());
                }
                ExprNode::Lambda(inner) => found.extend(names(inner)),
                _ => {}
            }
        });
    }
    found
}
