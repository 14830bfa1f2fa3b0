//! Expressions of C++.

use std::rc::Rc;

use super::{
    parse::{Parsed, Parser, kind_of},
    token::{Kind as TokenKind, Token},
    tree::{Expr, ExprNode, Function, Kind},
};
use crate::config::{Fault, Place};

const HELP: &str = "a value is a name, a number, a call or what they make together";

/// Operators, from those that bind least.
const LEVELS: [&[&str]; 10] = [
    &["||"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<=", ">=", "<", ">"],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

const ASSIGN: [(&str, Option<&str>); 11] = [
    ("=", None),
    ("+=", Some("+")),
    ("-=", Some("-")),
    ("*=", Some("*")),
    ("/=", Some("/")),
    ("%=", Some("%")),
    ("&=", Some("&")),
    ("|=", Some("|")),
    ("^=", Some("^")),
    ("<<=", Some("<<")),
    (">>=", Some(">>")),
];

/// The fault that something else was expected.
pub(super) fn unexpected(found: Option<&Token>, place: Place, expected: &str, help: &str) -> Fault {
    let what = match found.map(|t| &t.kind) {
        None => "the end of the file".to_owned(),
        Some(TokenKind::Name(name)) => format!("`{name}`"),
        Some(TokenKind::Whole(value)) => format!("the number {value}"),
        Some(TokenKind::Real(value)) => format!("the number {value}"),
        Some(TokenKind::Text(_)) => "text in quotes".to_owned(),
        Some(TokenKind::Mark(mark)) => format!("`{mark}`"),
    };
    Fault::error(
        place,
        format!("expected {expected}, found {what}"),
        format!("expected {expected}"),
    )
    .help(help)
}

/// `a, b`: the last counts.
pub(super) fn comma(it: &mut Parser<'_>) -> Parsed<Expr> {
    let mut left = assignment(it)?;
    while it.take(",") {
        it.link()?;
        let right = assignment(it)?;
        let place = left.place.to(right.place);
        let node = ExprNode::Binary(",", Box::new(left), Box::new(right));
        left = Expr { node, place };
    }
    Ok(left)
}

pub(super) fn assignment(it: &mut Parser<'_>) -> Parsed<Expr> {
    if it.sees("{") {
        return braces(it);
    }
    let left = choose(it)?;
    for (mark, operator) in ASSIGN {
        if it.take(mark) {
            let right = it.assignment()?;
            let place = left.place.to(right.place);
            let node = ExprNode::Assign(operator, Box::new(left), Box::new(right));
            return Ok(Expr { node, place });
        }
    }
    Ok(left)
}

fn braces(it: &mut Parser<'_>) -> Parsed<Expr> {
    let start = it.expect("{", HELP)?;
    let mut all = Vec::new();
    let (links, mut most) = (it.links, it.links);
    while !it.take("}") {
        it.links = links;
        all.push(it.assignment()?);
        most = most.max(it.links);
        if !it.take(",") && !it.sees("}") {
            return Err(unexpected(
                it.peek(0),
                it.place(),
                "`,` or `}`",
                "a list is `{a, b, c}`",
            ));
        }
    }
    it.links = most;
    Ok(Expr {
        node: ExprNode::Braces(all),
        place: start.to(it.before()),
    })
}

fn choose(it: &mut Parser<'_>) -> Parsed<Expr> {
    let condition = binary(it, 0)?;
    if !it.take("?") {
        return Ok(condition);
    }
    let yes = it.assignment()?;
    it.expect(":", "a choice is `condition ? yes : no`")?;
    let no = it.assignment()?;
    let place = condition.place.to(no.place);
    let node = ExprNode::Choose(Box::new(condition), Box::new(yes), Box::new(no));
    Ok(Expr { node, place })
}

fn binary(it: &mut Parser<'_>, level: usize) -> Parsed<Expr> {
    let Some(marks) = LEVELS.get(level) else {
        return it.deeper(unary);
    };
    let mut left = binary(it, level + 1)?;
    while let Some(mark) = marks.iter().find(|mark| it.sees(mark)) {
        // On a line of its own an operator would go on with the one before, as in C++.
        it.link()?;
        it.at += 1;
        let right = binary(it, level + 1)?;
        let place = left.place.to(right.place);
        let node = ExprNode::Binary(mark, Box::new(left), Box::new(right));
        left = Expr { node, place };
    }
    Ok(left)
}

fn unary(it: &mut Parser<'_>) -> Parsed<Expr> {
    let start = it.place();
    for (mark, by) in [("++", 1), ("--", -1)] {
        if it.take(mark) {
            let of = Box::new(it.deeper(unary)?);
            let place = start.to(of.place);
            return Ok(Expr {
                node: ExprNode::Step(of, by, true),
                place,
            });
        }
    }
    for mark in ["-", "!", "~", "+", "&", "*"] {
        if it.take(mark) {
            let of = Box::new(it.deeper(unary)?);
            let place = start.to(of.place);
            return Ok(Expr {
                node: ExprNode::Unary(mark, of),
                place,
            });
        }
    }
    if it.sees("(")
        && let Some(converted) = cast(it)?
    {
        return Ok(converted);
    }
    let value = primary(it)?;
    postfix(it, value)
}

/// `(type) value`, if it is that.
fn cast(it: &mut Parser<'_>) -> Parsed<Option<Expr>> {
    let (at, start) = (it.at, it.place());
    it.at += 1;
    let first = it.word(0);
    let known = kind_of(first) != Kind::Any || matches!(first, "const" | "unsigned" | "void");
    if (known || !first.is_empty())
        && let Some(kind) = it.read_kind()
        && it.take(")")
    {
        let value = it.peek(0).is_some_and(|t| {
            !t.first
                && (!matches!(t.kind, TokenKind::Mark(_))
                    || (known && (t.is("(") || t.is("-") || t.is("&"))))
        });
        if value {
            let of = Box::new(it.deeper(unary)?);
            let place = start.to(of.place);
            let node = ExprNode::Convert(kind, of);
            return Ok(Some(Expr { node, place }));
        }
    }
    it.at = at;
    Ok(None)
}

fn primary(it: &mut Parser<'_>) -> Parsed<Expr> {
    let place = it.place();
    let Some(token) = it.peek(0) else {
        return Err(unexpected(None, place, "a value", HELP));
    };
    let node = match &token.kind {
        TokenKind::Whole(value) => ExprNode::Whole(*value),
        TokenKind::Real(value) => ExprNode::Real(*value),
        TokenKind::Text(text) => {
            it.at += 1;
            let mut all = text.to_string();
            while let Some(TokenKind::Text(more)) = it.peek(0).map(|t| &t.kind) {
                all.push_str(more);
                it.at += 1;
            }
            return Ok(Expr {
                node: ExprNode::Text(all.into()),
                place,
            });
        }
        TokenKind::Name(_) => return named(it),
        TokenKind::Mark("(") => {
            it.at += 1;
            if it.sees("{") {
                let body = it.block()?;
                it.expect(")", "close the parenthesis")?;
                return Ok(Expr {
                    node: ExprNode::Block(body),
                    place: place.to(it.before()),
                });
            }
            let inner = it.expression()?;
            let end = it.expect(")", "close the parenthesis")?;
            return Ok(Expr {
                node: inner.node,
                place: place.to(end),
            });
        }
        TokenKind::Mark("[") => return lambda(it),
        TokenKind::Mark("{") => return braces(it),
        TokenKind::Mark("::") => {
            it.at += 1;
            let mut value = named(it)?;
            if let ExprNode::Name(name) = &value.node {
                value.node = ExprNode::Name(format!("::{name}").into());
            }
            return Ok(value);
        }
        TokenKind::Mark(_) => return Err(unexpected(Some(token), place, "a value", HELP)),
    };
    it.at += 1;
    Ok(Expr { node, place })
}

/// A name, without the spaces that it is in; `type(value)`; `static_cast<type>(value)`.
fn named(it: &mut Parser<'_>) -> Parsed<Expr> {
    let place = it.place();
    let mut name = it.name(HELP)?;
    if name.ends_with("_cast") && it.sees("<") {
        it.at += 1;
        let kind = it.read_kind().unwrap_or(Kind::Any);
        it.expect(">", "write `static_cast<int>(value)`")?;
        it.expect("(", "write `static_cast<int>(value)`")?;
        let of = Box::new(it.expression()?);
        it.expect(")", "close the parenthesis")?;
        return Ok(Expr {
            node: ExprNode::Convert(kind, of),
            place: place.to(it.before()),
        });
    }
    let (mut std, mut full) = (false, name.to_string());
    while it.sees("::") && !it.word(1).is_empty() {
        std |= &*name == "std";
        it.at += 1;
        name = it.name(HELP)?;
        full = format!("{full}::{name}");
    }
    if std {
        it.angles();
    }
    let kind = kind_of(&name);
    if kind != Kind::Any && it.sees("(") {
        it.at += 1;
        let of = Box::new(it.expression()?);
        it.expect(")", "close the parenthesis")?;
        return Ok(Expr {
            node: ExprNode::Convert(kind, of),
            place: place.to(it.before()),
        });
    }
    if &*name == "sizeof" && it.take("(") {
        let mut depth = 1;
        while depth > 0 {
            let Some(token) = it.peek(0) else { break };
            depth += i32::from(token.is("(")) - i32::from(token.is(")"));
            it.at += 1;
        }
        return Ok(Expr {
            node: ExprNode::Name("sizeof".into()),
            place: place.to(it.before()),
        });
    }
    let node = match &*name {
        "true" => ExprNode::Whole(1),
        "false" | "NULL" | "nullptr" => ExprNode::Whole(0),
        _ => ExprNode::Name(full.into()),
    };
    Ok(Expr {
        node,
        place: place.to(it.before()),
    })
}

fn lambda(it: &mut Parser<'_>) -> Parsed<Expr> {
    const SHAPE: &str = "a lambda is `[&](type parameter) { … }`";
    let place = it.place();
    it.at += 1;
    while it.peek(0).is_some() && !it.take("]") {
        it.at += 1;
    }
    let parameters = if it.take("(") {
        it.parameters()?
    } else {
        Vec::new()
    };
    while it.peek(0).is_some() && !it.sees("{") {
        if it.sees(";") {
            return Err(unexpected(it.peek(0), it.place(), "`{`", SHAPE));
        }
        it.at += 1;
    }
    let body = it.block()?;
    let place = place.to(it.before());
    let function = Function {
        name: "".into(),
        space: "".into(),
        parameters,
        body,
        hidden: false,
        qualified: false,
        place,
    };
    Ok(Expr {
        node: ExprNode::Lambda(Rc::new(function)),
        place,
    })
}

fn postfix(it: &mut Parser<'_>, mut value: Expr) -> Parsed<Expr> {
    loop {
        let start = value.place;
        let node = if it.sees("(") {
            it.at += 1;
            let mut given = Vec::new();
            it.link()?;
            let (links, mut most) = (it.links, it.links);
            while !it.take(")") {
                it.links = links;
                given.push(it.assignment()?);
                most = most.max(it.links);
                if !it.take(",") && !it.sees(")") {
                    let help = "a call is `name(argument, argument)`";
                    return Err(unexpected(it.peek(0), it.place(), "`,` or `)`", help));
                }
            }
            it.links = most;
            ExprNode::Call(Box::new(value), given)
        } else if it.sees("[") {
            it.link()?;
            it.at += 1;
            let at = it.expression()?;
            it.expect("]", "an element is `name[index]`")?;
            ExprNode::Index(Box::new(value), Box::new(at))
        } else if it.sees(".") || it.sees("->") {
            it.link()?;
            it.at += 1;
            let name = it.name("a member is `object.name`")?;
            ExprNode::Member(Box::new(value), name)
        } else if it.sees("++") && !it.peek(0).is_some_and(|t| t.first) {
            it.link()?;
            it.at += 1;
            ExprNode::Step(Box::new(value), 1, false)
        } else if it.sees("--") && !it.peek(0).is_some_and(|t| t.first) {
            it.link()?;
            it.at += 1;
            ExprNode::Step(Box::new(value), -1, false)
        } else {
            return Ok(value);
        };
        let place = start.to(it.before());
        value = Expr { node, place };
    }
}
