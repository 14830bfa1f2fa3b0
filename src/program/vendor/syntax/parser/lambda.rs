//! Lambdas, and what they take along.

use std::rc::Rc;

use super::{Parsed, Parser, Type, expression::unexpected};
use crate::program::vendor::syntax::tree::{Capture, Captures, Expr, ExprNode, Function};

const HELP: &str = "a lambda captures `[&]`, `[=]`, or names";

impl Parser<'_> {
    /// `[captures](parameters) { body }`
    pub(in crate::program::vendor) fn lambda(&mut self) -> Parsed<Expr> {
        const SHAPE: &str = "a lambda is `[&](type parameter) { … }`";
        let it = self;
        let place = it.place();
        it.at += 1;
        let captures = captures(it)?;
        let parameters = if it.take("(") {
            it.parameters()?
        } else {
            Vec::new()
        };
        let mut of = Type::default();
        let mut captures = captures;
        while it.peek(0).is_some() && !it.sees("{") {
            if it.sees(";") {
                return Err(unexpected(it.peek(0), it.place(), "`{`", SHAPE));
            }
            if it.take("->") {
                of = it.read_cast().unwrap_or_default();
            } else {
                captures.mutable |= it.word(0) == "mutable";
                it.at += 1;
            }
        }
        let body = it.body(&"operator()".into())?;
        let place = place.to(it.before());
        let (gives, element) = of.classes();
        let function = Function {
            gives,
            element,
            parameters: parameters.into(),
            body: body.into(),
            returns: of.value_kind(),
            refers: of.refers(),
            captures,
            ..Function::new("".into(), place)
        };
        Ok(Expr {
            node: ExprNode::Lambda(Rc::new(function)),
            place,
        })
    }
}

/// What a lambda takes along, up to `]`.
fn captures(it: &mut Parser<'_>) -> Parsed<Captures> {
    let mut all = Captures::default();
    while !it.take("]") {
        if it.take("*") {
            // The object is copied, with all its members.
            if !it.take_word("this") {
                return Err(unexpected(it.peek(0), it.place(), "`this`", HELP));
            }
            all.object = true;
            it.take(",");
            continue;
        }
        let reference = it.take("&");
        let copies = !reference && it.take("=");
        all.copies |= copies;
        if !copies && !it.word(0).is_empty() {
            let name = it.name(HELP)?;
            let value = if it.take("=") {
                Some(it.assignment()?)
            } else {
                None
            };
            all.named.push(Capture {
                name,
                reference,
                value,
            });
        } else if !copies && !reference {
            return Err(unexpected(it.peek(0), it.place(), "`]`", HELP));
        }
        it.take(",");
    }
    Ok(all)
}
