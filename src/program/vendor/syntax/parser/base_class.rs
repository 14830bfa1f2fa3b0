//! Classes that are made from another one.

use std::rc::Rc;

use super::super::tree::{Bound, Expr, ExprNode, Function, Stmt, StmtNode, Word};
use super::{Parser, within};

impl Parser<'_> {
    /// The class behind the `:` of a class, if there is one; what the class is, where it has bases
    /// that are not supported.
    pub(super) fn base_class(&mut self) -> Result<Option<Word>, &'static str> {
        if !self.take(":") {
            return Ok(None);
        }
        while matches!(self.word(0), "public" | "private" | "protected") {
            self.at += 1;
        }
        if self.word(0) == "virtual" {
            return Err("a class with a virtual base");
        }
        let mut name = self.word(0);
        self.at += 1;
        while self.take("::") {
            name = self.word(0);
            self.at += 1;
        }
        if self.sees("<") {
            return Err("a class whose base is a template");
        }
        if self.sees(",") {
            return Err("a class with several bases");
        }
        if self.classes.contains(name) {
            Ok(Some(name.into()))
        } else {
            Err("a class with an unsupported base")
        }
    }

    /// Whether a member of a class that stands here may have another in its place.
    pub(super) fn bound(&self) -> Bound {
        let rest = self.tokens.get(self.at..).unwrap_or_default();
        let head = rest.iter().take_while(|t| !t.is("{") && !t.is(";"));
        let says = |word: &str| matches!(word, "virtual" | "override" | "final");
        let mut words = head.filter_map(|t| t.name());
        if words.any(|it| says(it)) {
            Bound::Virtual
        } else {
            Bound::Own
        }
    }

    /// The constructor of a class without one, whose base has some.
    pub(super) fn inherited(&self, class: &str, own: &[Rc<Function>]) -> Option<Rc<Function>> {
        let base = self.base.as_ref().filter(|it| self.constructs(it))?;
        if own.iter().any(|it| *it.name == *class && !it.hidden) {
            return None;
        }
        let place = self.place();
        Some(Rc::new(Function {
            space: within(&self.space, &[class]).into(),
            body: Rc::new([
                Self::makes_part(base, Vec::new(), place),
                Self::sets(Vec::new(), place),
            ]),
            ..Function::new(class.into(), place)
        }))
    }

    /// A statement that makes the part of an object that is of a base, or the whole of it by another
    /// constructor.
    pub(super) fn makes_part(class: &Word, given: Vec<Expr>, place: crate::config::Place) -> Stmt {
        let at = |node| Box::new(Expr { node, place });
        let this = at(ExprNode::Name("this".into()));
        let callee = at(ExprNode::Member(this, class.clone()));
        let node = StmtNode::Expr(*at(ExprNode::Call(callee, given)));
        Stmt { node, place }
    }
}
