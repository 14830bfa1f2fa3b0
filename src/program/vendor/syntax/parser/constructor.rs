//! Constructors of classes that hold data: they are run when an object is made.

use std::rc::Rc;

use super::{Parsed, Parser, expression::arguments, types::QUALIFIERS, within};
use crate::{
    config::{Fault, Place},
    program::vendor::syntax::tree::{
        Expr, ExprNode, Function, Parameter, Stmt, StmtNode, Word, last,
    },
};

impl Parser<'_> {
    /// Whether objects of this class are made by a constructor.
    pub(in crate::program::vendor) fn constructs(&self, class: &str) -> bool {
        self.constructed.contains(last(class))
    }

    /// A constructor or a destructor of a class, if one stands here; an error, and no step ahead,
    /// where it is not understood.
    pub(super) fn constructor(&mut self, class: &str) -> Option<Result<StmtNode, ()>> {
        let (start, told) = (self.at, self.faults.len());
        while QUALIFIERS.contains(&self.word(0)) {
            self.at += 1;
        }
        let ends = self.take("~");
        let named = self.word(0) == class && self.peek(1).is_some_and(|t| t.is("("));
        if !named {
            self.at = start;
            return None;
        }
        let read = if ends {
            // It must leave the array alone, which is held against it as with an operator.
            self.member(class)
                .map(StmtNode::Function)
                .or_else(|| self.plain_end())
        } else {
            self.defined(class).ok().flatten()
        };
        let clean = self.faults.len() == told;
        self.faults.truncate(told);
        let read = read.filter(|_| clean).ok_or(());
        if read.is_err() {
            self.at = start;
        }
        Some(read)
    }

    /// `Class(parameters) : member(value) { body }`, from its name on.
    fn defined(&mut self, class: &str) -> Parsed<Option<StmtNode>> {
        let place = self.place();
        self.at += 2;
        let parameters = self.parameters()?;
        self.take_word("noexcept");
        let copying = copies(class, &parameters);
        let space = within(&self.space, &[class]).into();
        let (mut parts, mut sets, mut rest) = (Vec::new(), Vec::new(), Vec::new());
        if !copying && self.take(";") {
            return Ok(Some(StmtNode::Prototype(Rc::new(Function {
                space,
                parameters: parameters.into(),
                ..Function::new(class.into(), place)
            }))));
        } else if self.take("=") {
            // That which an object has anyway, and one that nobody may call.
            let deleted = self.word(0) == "delete";
            self.at += 1;
            if !self.take(";") {
                return Ok(None);
            }
            if deleted || !parameters.is_empty() {
                return Ok(Some(StmtNode::Nothing));
            }
        } else if copying {
            return Ok(None);
        } else {
            if self.take(":") {
                loop {
                    if self.is_part(class) {
                        // A base is made first, wherever it stands.
                        parts.push(self.part()?);
                    } else if let Some(set) = self.member_set()? {
                        sets.push(set);
                    } else {
                        return Ok(None);
                    }
                    if !self.take(",") {
                        break;
                    }
                }
            }
            let base = self.base.clone();
            let base = base.filter(|it| parts.is_empty() && self.constructs(it));
            parts.extend(base.map(|it| Self::makes_part(&it, Vec::new(), place)));
            rest = self.body(&class.into())?;
        }
        let mut body = parts;
        body.push(Self::sets(sets, place));
        body.extend(rest);
        Ok(Some(StmtNode::Function(Rc::new(Function {
            space,
            parameters: parameters.into(),
            body: body.into(),
            ..Function::new(class.into(), place)
        }))))
    }

    /// What a constructor sets before its body.
    pub(super) fn sets(all: Vec<Stmt>, place: Place) -> Stmt {
        let node = StmtNode::Block(all);
        Stmt { node, place }
    }

    /// A constructor or a destructor that stands behind its class: `Class::Class() { … }`.
    pub(super) fn behind_class(&mut self) -> Parsed<StmtNode> {
        while QUALIFIERS.contains(&self.word(0)) {
            self.at += 1;
        }
        while self.peek(1).is_some_and(|t| t.is("::")) {
            self.at += 2;
        }
        let (class, place) = (self.word(0), self.place());
        if self.take("~") {
            let class = self.word(0);
            if let Some(mut it) = self.member(class) {
                Rc::make_mut(&mut it).qualified = true;
                return Ok(StmtNode::Class(vec![it]));
            }
            return self.plain_end().ok_or_else(|| not_understood(place));
        }
        let Some(begins) = self.announced.get(class).cloned() else {
            let member = self.member(class);
            return Ok(StmtNode::Class(member.into_iter().collect()));
        };
        let outer = std::mem::replace(&mut self.base, begins.base.clone());
        let read = self.of_class(class, |it| it.defined(class));
        self.base = outer;
        match read? {
            Some(StmtNode::Function(mut function)) => {
                let it = Rc::make_mut(&mut function);
                (it.qualified, it.space) = (true, begins.space.clone());
                if !begins.apply(it) {
                    return Err(not_understood(place));
                }
                Ok(StmtNode::Function(function))
            }
            Some(node) => Ok(node),
            None => Err(not_understood(place)),
        }
    }

    /// `~Class() = default;`, and one that is only announced.
    fn plain_end(&mut self) -> Option<StmtNode> {
        let start = self.at;
        self.at += 1;
        self.skip_group();
        self.take_word("noexcept");
        let found = self.take(";") || self.take("=") && self.take_word("default") && self.take(";");
        if !found {
            self.at = start;
        }
        found.then_some(StmtNode::Nothing)
    }

    /// Whether what a constructor sets here is not a member: the part of the base, or all of it.
    fn is_part(&self, class: &str) -> bool {
        let mut ahead = 0;
        while self.peek(ahead + 1).is_some_and(|t| t.is("::")) {
            ahead += 2;
        }
        let name = self.word(ahead);
        name == class || self.base.as_deref() == Some(name)
    }

    /// `Base(values)`
    fn part(&mut self) -> Parsed<Stmt> {
        let place = self.place();
        let mut name = self.name("the name of a class")?;
        while self.take("::") {
            name = self.name("the name of a class")?;
        }
        let given = if self.sees("{") {
            match self.assignment()?.node {
                ExprNode::Braces(given) => given,
                node => vec![Expr { node, place }],
            }
        } else {
            arguments(self, "a base is initialised with `Base(values)`")?
        };
        Ok(Self::makes_part(&name, given, place))
    }

    /// `member(value)` or `member{value}`, as an assignment; of none or several values, of braces.
    fn member_set(&mut self) -> Parsed<Option<Stmt>> {
        let place = self.place();
        let name = self.name("the name of a member")?;
        let close = match (self.take("("), self.sees("{")) {
            (true, _) => ")",
            (false, true) => {
                self.at += 1;
                "}"
            }
            (false, false) => return Ok(None),
        };
        let mut given = Vec::new();
        while !self.take(close) {
            given.push(self.assignment()?);
            if !self.take(",") && !self.sees(close) {
                return Ok(None);
            }
        }
        let place = place.to(self.before());
        let value = match given.len() {
            1 => given.remove(0),
            _ => Expr {
                node: ExprNode::Braces(given),
                place,
            },
        };
        Ok(Some(set(name, value, place)))
    }
}

/// Of a constructor behind its class that sets what is not supported.
fn not_understood(place: Place) -> Fault {
    let message = "the initialiser list of this constructor is not supported";
    Fault::error(place, message, "this constructor").help("assign the members in its body")
}

/// Whether a constructor with these parameters copies an object: where that happens is not supported.
pub(super) fn copies(class: &str, parameters: &[Parameter]) -> bool {
    let first = parameters.first();
    first.is_some_and(|it| it.alias && &*it.of == class && !it.pointer)
}

/// A member is set: a parameter may have its name.
pub(super) fn set(name: Word, value: Expr, place: Place) -> Stmt {
    let at = |node| Box::new(Expr { node, place });
    let this = at(ExprNode::Name("this".into()));
    let member = at(ExprNode::Member(this, name));
    let node = StmtNode::Expr(*at(ExprNode::Assign(None, member, value.into())));
    Stmt { node, place }
}
