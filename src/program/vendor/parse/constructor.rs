//! Constructors of classes that hold data: they are run when an object is made.

use std::rc::Rc;

use super::super::tree::{Expr, ExprNode, Function, Stmt, StmtNode, last};
use super::{Parsed, Parser, types::QUALIFIERS};

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
            self.member(class).map(StmtNode::Function)
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
        let mut body = Vec::new();
        if self.take("=") {
            // That which an object has anyway, and one that nobody may call.
            let deleted = self.word(0) == "delete";
            self.at += 1;
            if !self.take(";") {
                return Ok(None);
            }
            if deleted || !parameters.is_empty() {
                return Ok(Some(StmtNode::Nothing));
            }
        } else {
            if self.take(":") {
                loop {
                    let Some(set) = self.member_set()? else {
                        return Ok(None);
                    };
                    body.push(set);
                    if !self.take(",") {
                        break;
                    }
                }
            }
            body.extend(self.block()?);
        }
        Ok(Some(StmtNode::Function(Rc::new(Function {
            space: self.space.as_str().into(),
            parameters: parameters.into(),
            body: body.into(),
            ..Function::new(class.into(), place)
        }))))
    }

    /// `member(value)` or `member{value}`, as an assignment; nothing where there is no one value.
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
        if self.take(close) {
            return Ok(None);
        }
        let value = self.assignment()?;
        if !self.take(close) {
            return Ok(None);
        }
        let place = place.to(self.before());
        let at = |node| Box::new(Expr { node, place });
        // A parameter may have the name of the member.
        let this = at(ExprNode::Name("this".into()));
        let member = at(ExprNode::Member(this, name));
        let node = StmtNode::Expr(*at(ExprNode::Assign(None, member, value.into())));
        Ok(Some(Stmt { node, place }))
    }
}
