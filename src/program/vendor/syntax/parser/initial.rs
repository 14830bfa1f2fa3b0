//! What the members of an object begin with: in the order in which they are declared, anew for each
//! object.

use std::{collections::BTreeSet, rc::Rc};

use super::{Parser, constructor::set, member_initialiser::MemberInitialisers, within};
use crate::{
    order::Order,
    program::vendor::syntax::{
        tree::{Bound, Declared, Expr, ExprNode, Function, Kind, Stmt, StmtNode, Word},
        walk::{Part, values},
    },
};

impl MemberInitialisers {
    /// Lets a constructor begin the members; false where that is not supported.
    pub(super) fn apply(&self, it: &mut Function) -> bool {
        let hides = |of: &Expr| {
            let all = names(of);
            it.parameters.iter().any(|it| all.contains(&it.name))
        };
        if self.values.iter().flatten().any(hides) {
            return false;
        }
        let mut body = it.body.to_vec();
        if let Some(sets) = sets_of(&mut body, &it.name) {
            self.ordered(sets);
        }
        it.body = body.into();
        true
    }

    /// Brings what is set into the order of the members, with what their declarations say of the
    /// others.
    fn ordered(&self, sets: &mut Vec<Stmt>) {
        let position = |name: &Word| self.data.iter().position(|it| it.name == *name);
        let known: BTreeSet<usize> = { sets.iter() }
            .filter_map(|it| position(member(it)?))
            .collect();
        for it in sets.iter_mut() {
            let at = member(it).and_then(position);
            match at {
                Some(at) if self.made[at] => make(it, &self.data[at].of),
                Some(at) if is_number(&self.data[at]) => begins_at_0(it),
                _ => {}
            }
        }
        for (at, (it, value)) in self.data.iter().zip(&self.values).enumerate() {
            if let (Some(value), false) = (value, known.contains(&at)) {
                sets.push(set(it.name.clone(), value.clone(), it.place));
            }
        }
        sets.order_by(|a, b| {
            let at = |it| member(it).and_then(position);
            at(a).cmp(&at(b))
        });
    }
}

impl Parser<'_> {
    /// Lets constructors set the members in their order, also those whose declaration says by what
    /// may change what they begin with; false where that is not supported.
    pub(super) fn begin(
        &mut self,
        class: &str,
        data: &mut [Declared],
        functions: &mut Vec<Rc<Function>>,
    ) -> bool {
        let members: BTreeSet<Word> = data.iter().map(|it| it.name.clone()).collect();
        let variable = |name: &Word| members.contains(name) || self.variables.contains(name);
        let constructor = |it: &Rc<Function>| &*it.name == class && !it.hidden;
        let made = functions.iter().any(constructor);
        let object = |it: &Declared| self.constructs(&it.of) && !it.pointer && !it.library;
        let objects: Vec<bool> = data.iter().map(object).collect();
        let values: Vec<Option<Expr>> = { data.iter().zip(&objects) }
            .map(|(it, object)| {
                let value = it.value.clone();
                value.filter(|of| !it.reference && (*object || varies(of, made, &variable)))
            })
            .collect();
        let space: Word = within(&self.space, &[class]).into();
        if !made && values.iter().any(Option::is_some) {
            let place = self.place();
            functions.push(Rc::new(Function {
                space: space.clone(),
                body: Rc::new([Self::sets(Vec::new(), place)]),
                ..Function::new(class.into(), place)
            }));
        }
        let begins = MemberInitialisers {
            space,
            base: self.base.clone(),
            data: data.to_vec(),
            values,
            made: objects,
        };
        for it in functions.iter_mut().filter(|it| constructor(it)) {
            if !begins.apply(Rc::make_mut(it)) {
                return false;
            }
        }
        for (it, _) in data
            .iter_mut()
            .zip(&begins.values)
            .filter(|it| it.1.is_some())
        {
            it.value = None;
        }
        if functions
            .iter()
            .any(|it| constructor(it) && it.bound == Bound::Announced)
        {
            self.announced.insert(class.into(), begins);
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

/// The member that a statement sets.
fn member(it: &Stmt) -> Option<&Word> {
    match &it.node {
        StmtNode::Expr(Expr {
            node: ExprNode::Assign(None, to, _),
            ..
        }) => match &to.node {
            ExprNode::Member(_, name) => Some(name),
            _ => None,
        },
        _ => None,
    }
}

/// Whether a member is one number, or a pointer.
fn is_number(it: &Declared) -> bool {
    let number = matches!(
        it.kind,
        Kind::Bits(..) | Kind::Flag | Kind::Float | Kind::Real
    );
    it.lengths.is_empty() && !it.library && (it.pointer || number)
}

/// `number()` is 0.
fn begins_at_0(it: &mut Stmt) {
    if let StmtNode::Expr(Expr {
        node: ExprNode::Assign(_, _, value),
        ..
    }) = &mut it.node
        && matches!(&value.node, ExprNode::Braces(given) if given.is_empty())
    {
        value.node = ExprNode::Whole(0);
    }
}

/// What is set is an object of a class, made of what is given.
fn make(it: &mut Stmt, class: &Word) {
    let StmtNode::Expr(Expr {
        node: ExprNode::Assign(_, _, value),
        ..
    }) = &mut it.node
    else {
        return;
    };
    let place = value.place;
    let given = match std::mem::replace(&mut value.node, ExprNode::Whole(0)) {
        ExprNode::Braces(given) => given,
        node => vec![Expr { node, place }],
    };
    **value = Expr::made(class, given, place);
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
