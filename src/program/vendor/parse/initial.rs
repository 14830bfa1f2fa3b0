//! What the members of an object begin with: in the order in which they are declared, anew for each
//! object.

use std::{collections::BTreeSet, rc::Rc};

use super::super::{
    tree::{Declared, Expr, ExprNode, Function, Stmt, StmtNode, Word},
    walk::{Part, values},
};
use super::{Parser, constructor::set, within};
use crate::order::Order;

impl Parser<'_> {
    /// Lets constructors set the members in their order, also those whose declaration says by what
    /// may change what they begin with; false where that is not followed.
    pub(super) fn begin(
        &self,
        class: &str,
        data: &mut [Declared],
        functions: &mut Vec<Rc<Function>>,
    ) -> bool {
        let members: BTreeSet<Word> = data.iter().map(|it| it.name.clone()).collect();
        let variable = |name: &Word| members.contains(name) || self.variables.contains(name);
        let constructor = |it: &Rc<Function>| &*it.name == class && !it.hidden;
        let made = functions.iter().any(constructor);
        let begins: Vec<Option<Expr>> = { data.iter() }
            .map(|it| {
                let value = it.value.clone();
                value.filter(|of| !it.reference && varies(of, made, &variable))
            })
            .collect();
        if !made && begins.iter().any(Option::is_some) {
            let place = self.place();
            functions.push(Rc::new(Function {
                space: within(&self.space, &[class]).into(),
                body: Rc::new([Self::sets(Vec::new(), place)]),
                ..Function::new(class.into(), place)
            }));
        }
        for it in functions.iter_mut().filter(|it| constructor(it)) {
            let hides = |of: &Expr| {
                let all = names(of);
                it.parameters.iter().any(|it| all.contains(&it.name))
            };
            if begins.iter().flatten().any(hides) {
                return false;
            }
            let mut body = it.body.to_vec();
            if let Some(sets) = sets_of(&mut body, class) {
                ordered(sets, data, &begins);
            }
            Rc::make_mut(it).body = body.into();
        }
        for (it, _) in data.iter_mut().zip(&begins).filter(|it| it.1.is_some()) {
            it.value = None;
        }
        true
    }
}

/// Where a constructor sets members before its body; nothing where another constructor does.
fn sets_of<'b>(body: &'b mut [Stmt], class: &str) -> Option<&'b mut Vec<Stmt>> {
    let other = |it: &Stmt| match &it.node {
        StmtNode::Expr(Expr {
            node: ExprNode::Call(callee, _),
            ..
        }) => matches!(&callee.node, ExprNode::Member(_, name) if &**name == class),
        _ => false,
    };
    if body.first().is_some_and(other) {
        return None;
    }
    body.iter_mut().take(2).find_map(|it| match &mut it.node {
        StmtNode::Block(all) => Some(all),
        _ => None,
    })
}

/// Brings what is set into the order of the members, with what their declarations say of the others.
fn ordered(sets: &mut Vec<Stmt>, data: &[Declared], begins: &[Option<Expr>]) {
    let member = |it: &Stmt| match &it.node {
        StmtNode::Expr(Expr {
            node: ExprNode::Assign(None, to, _),
            ..
        }) => match &to.node {
            ExprNode::Member(_, name) => data.iter().position(|it| it.name == *name),
            _ => None,
        },
        _ => None,
    };
    let known: BTreeSet<usize> = sets.iter().filter_map(member).collect();
    for (at, (it, value)) in data.iter().zip(begins).enumerate() {
        if let (Some(value), false) = (value, known.contains(&at)) {
            sets.push(set(it.name.clone(), value.clone(), it.place));
        }
    }
    sets.order_by(|a, b| member(a).cmp(&member(b)));
}

/// Whether what a member begins with may differ from object to object. Where constructors are there
/// anyway, they call what it calls.
fn varies(it: &Expr, made: bool, variable: &dyn Fn(&Word) -> bool) -> bool {
    let mut found = false;
    values(it, &mut |part| {
        let Part::Expr(it) = part else { return };
        found |= match &it.node {
            ExprNode::Name(name) => variable(name),
            ExprNode::Step(..) | ExprNode::Assign(..) => true,
            ExprNode::Call(..) => made,
            _ => false,
        };
    });
    found && !matches!(it.node, ExprNode::Lambda(_))
}

/// The names in a value.
fn names(it: &Expr) -> BTreeSet<Word> {
    let mut found = BTreeSet::new();
    values(it, &mut |part| {
        if let Part::Expr(Expr {
            node: ExprNode::Name(name),
            ..
        }) = part
        {
            found.insert(name.clone());
        }
    });
    found
}
