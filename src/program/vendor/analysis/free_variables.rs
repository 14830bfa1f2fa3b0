//! What the block of a kernel reads of the variables around it, as far as its text says.

use std::collections::{BTreeMap, BTreeSet};

use super::effects;
use crate::program::vendor::{
    interpreter::machine::Machine,
    syntax::{
        tree::{Expr, ExprNode, Function, Read, Stmt, StmtNode, Word, last},
        walk::{Part, values, walk},
    },
};

impl Read {
    /// As it is written.
    pub(in crate::program::vendor) fn spelled(&self) -> String {
        spelled(&self.of)
    }
}

/// What the block of a kernel reads, with the functions that it calls: of those, variables of the
/// file alone.
pub(in crate::program::vendor) fn around(machine: &Machine<'_>, body: &[Stmt]) -> Vec<Read> {
    let mut all = Reads::default();
    for statement in body {
        all.statement(statement);
    }
    let mut found = all.found(None);
    let called = body.iter().flat_map(|it| effects::called(machine, it));
    let mut seen = BTreeSet::new();
    for function in called.filter(|it| seen.insert(it.place.start)) {
        found.extend(of_function(&function));
    }
    found
}

/// What a function reads that is none of its own.
fn of_function(it: &Function) -> Vec<Read> {
    let mut all = Reads::default();
    let own = it.parameters.iter().map(|it| it.name.clone());
    all.own.extend(own);
    for statement in it.body.iter() {
        all.statement(statement);
    }
    all.found(Some(&it.space))
}

#[derive(Default)]
struct Reads {
    /// By how they are written.
    names: BTreeMap<String, Expr>,
    /// Names that are declared inside, or assigned before they are read.
    own: BTreeSet<Word>,
    /// Parts of what was taken whole, by where they lie in memory.
    parts: BTreeSet<*const Expr>,
}

impl Reads {
    fn found(self, space: Option<&Word>) -> Vec<Read> {
        let Self { names, own, .. } = self;
        let around = names
            .into_values()
            .filter(|it| base(it).is_some_and(|name| !own.contains(name)));
        let read = |of| Read {
            of,
            space: space.cloned(),
        };
        around.map(read).collect()
    }

    fn statement(&mut self, it: &Stmt) {
        walk(it, false, &mut |part| match part {
            Part::Stmt(it) => self.declared(it),
            Part::Expr(it) => self.value(it),
        });
    }

    fn declared(&mut self, it: &Stmt) {
        match &it.node {
            StmtNode::Declare(all) => self.own.extend(all.iter().map(|it| it.name.clone())),
            StmtNode::Each(it, ..) => {
                self.own.insert(it.name.clone());
            }
            _ => {}
        }
    }

    fn value(&mut self, it: &Expr) {
        if self.parts.contains(&std::ptr::from_ref(it)) {
            return;
        }
        match &it.node {
            ExprNode::Assign(None, to, value) => {
                if let ExprNode::Name(name) = &to.node
                    && !self.names.contains_key(&**name)
                    && !names(value, name)
                {
                    self.own.insert(name.clone());
                }
            }
            ExprNode::Name(_) | ExprNode::Member(..) if base(it).is_some() => {
                values(it, &mut |part| {
                    if let Part::Expr(of) = part {
                        self.parts.insert(std::ptr::from_ref(of));
                    }
                });
                self.names.entry(spelled(it)).or_insert_with(|| it.clone());
            }
            ExprNode::Lambda(function) => {
                for read in of_function(function) {
                    self.names.entry(spelled(&read.of)).or_insert(read.of);
                }
            }
            _ => {}
        }
    }
}

/// Whether a value names a variable.
fn names(it: &Expr, name: &str) -> bool {
    let mut found = false;
    values(it, &mut |part| {
        found |= matches!(part, Part::Expr(Expr { node: ExprNode::Name(it), .. }) if **it == *name);
    });
    found
}

/// The variable that a chain of members begins with.
fn base(it: &Expr) -> Option<&Word> {
    match &it.node {
        ExprNode::Name(name) => Some(name),
        ExprNode::Member(of, _) => base(of),
        _ => None,
    }
}

fn spelled(it: &Expr) -> String {
    match &it.node {
        ExprNode::Name(name) => last(name).to_owned(),
        ExprNode::Member(of, name) => format!("{}.{name}", spelled(of)),
        _ => String::new(),
    }
}
