//! Expressions of C++.

use super::{Parsed, Parser};
use crate::{
    config::{Fault, Place},
    program::vendor::{
        lexer::token::{Token, TokenKind, unescaped},
        syntax::tree::{Expr, ExprNode, FILLED, Kind, LIMIT, TemplateArgument},
    },
};

const HELP: &str = "an expression is a name, a number, a call, or a combination of them";

/// Operators, from those that bind least.
pub(in crate::program::vendor) const LEVELS: [&[&str]; 10] = [
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
/// A text of these bytes. What stands behind a 0 in it is no part of a text, and other bytes than those
/// of UTF-8 are numbers: neither is followed.
fn characters(mut all: Vec<u8>, place: Place) -> Result<String, Fault> {
    while all.last() == Some(&0) {
        all.pop();
    }
    let text = String::from_utf8(all).ok().filter(|it| !it.contains('\0'));
    text.ok_or_else(|| {
        Fault::error(
            place,
            "a string with a 0 inside, or with bytes that are not UTF-8",
            "this text",
        )
        .help("give an array of numbers: {0xff, 0x80}")
    })
}

pub(super) fn unexpected(found: Option<&Token>, place: Place, expected: &str, help: &str) -> Fault {
    let what = match found.map(|t| &t.kind) {
        None => "the end of the file".to_owned(),
        Some(TokenKind::Name(name)) => format!("`{name}`"),
        Some(TokenKind::Whole(value) | TokenKind::Wide(value, _)) => format!("the number {value}"),
        Some(TokenKind::Character(_)) => "a character".to_owned(),
        Some(TokenKind::Real(value) | TokenKind::Single(value)) => format!("the number {value}"),
        Some(TokenKind::Text(_)) => "text in quotes".to_owned(),
        Some(TokenKind::Punctuator(operator)) => format!("`{operator}`"),
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
    for (operator, binary) in ASSIGN {
        if it.take(operator) {
            let right = it.assignment()?;
            let place = left.place.to(right.place);
            let node = ExprNode::Assign(binary, Box::new(left), Box::new(right));
            return Ok(Expr { node, place });
        }
    }
    Ok(left)
}

fn braces(it: &mut Parser<'_>) -> Parsed<Expr> {
    let start = it.expect("{", HELP)?;
    if let Some(node) = it.designated()? {
        let place = start.to(it.before());
        return Ok(Expr { node, place });
    }
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

/// What an object is made of, in braces or in parentheses.
fn given(it: &mut Parser<'_>) -> Parsed<Vec<Expr>> {
    if it.sees("{") {
        return Ok(given_in(braces(it)?));
    }
    if !it.sees("(") {
        let help = "an object is `std::pair<int, int>(1, 2)`";
        return Err(unexpected(it.peek(0), it.place(), "`(` or `{`", help));
    }
    arguments(it, "an object is `std::pair<int, int>(1, 2)`")
}

/// What an object is made of, in braces.
fn given_in(it: Expr) -> Vec<Expr> {
    match it.node {
        ExprNode::Braces(given) => given,
        _ => vec![it],
    }
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

/// A value without comparisons, as it may stand in `<…>`.
pub(super) fn sum(it: &mut Parser<'_>) -> Parsed<Expr> {
    binary(it, 8)
}

fn binary(it: &mut Parser<'_>, level: usize) -> Parsed<Expr> {
    let Some(operators) = LEVELS.get(level) else {
        return it.deeper(unary);
    };
    let mut left = binary(it, level + 1)?;
    while let Some(operator) = operators.iter().find(|operator| it.sees(operator)) {
        // On a line of its own an operator would go on with the one before, as in C++.
        it.link()?;
        it.at += 1;
        let right = binary(it, level + 1)?;
        let place = left.place.to(right.place);
        let node = ExprNode::Binary(operator, Box::new(left), Box::new(right));
        left = Expr { node, place };
    }
    Ok(left)
}

fn unary(it: &mut Parser<'_>) -> Parsed<Expr> {
    let start = it.place();
    for (operator, by) in [("++", 1), ("--", -1)] {
        if it.take(operator) {
            let of = Box::new(it.deeper(unary)?);
            let place = start.to(of.place);
            return Ok(Expr {
                node: ExprNode::Step(of, by, true),
                place,
            });
        }
    }
    for operator in ["-", "!", "~", "+", "&", "*"] {
        if it.take(operator) {
            let of = Box::new(it.deeper(unary)?);
            let place = start.to(of.place);
            return Ok(Expr {
                node: ExprNode::Unary(operator, of),
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

/// Punctuators that a converted value may begin with.
const BEFORE: [&str; 9] = ["(", "-", "&", "~", "!", "*", "+", "++", "--"];

/// `(type) value`, if it is that.
fn cast(it: &mut Parser<'_>) -> Parsed<Option<Expr>> {
    let (at, start) = (it.at, it.place());
    it.at += 1;
    let first = it.word(0);
    let known = it.kind_named(first) != Kind::Any || matches!(first, "const" | "unsigned" | "void");
    if (known || !first.is_empty())
        && let Some(of) = it.read_cast()
        && (it.take(")") || it.array_pointer())
    {
        let known = known || it.enumeration_kind(&of.class()).is_some();
        // `(name *)` is a type whatever the name.
        let pointer = it.at >= 2 && it.tokens_before(2).is("*");
        let value = it.peek(0).is_some_and(|t| {
            !t.first
                && (!matches!(t.kind, TokenKind::Punctuator(_))
                    || ((known || pointer) && BEFORE.iter().any(|operator| t.is(operator))))
        });
        if value {
            let value = Box::new(it.deeper(unary)?);
            let place = start.to(value.place);
            let node = it.converted(&of, value);
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
        TokenKind::Character(code) => {
            let node = ExprNode::Whole(*code);
            ExprNode::Convert(Kind::CHARACTER, Box::new(Expr { node, place }))
        }
        TokenKind::Wide(value, width) => ExprNode::Wide(*value, *width),
        TokenKind::Real(value) => ExprNode::Real(*value),
        TokenKind::Single(value) => {
            let node = ExprNode::Real(*value);
            ExprNode::Convert(Kind::Float, Box::new(Expr { node, place }))
        }
        TokenKind::Text(text) => {
            it.at += 1;
            let mut all = unescaped(text);
            while let Some(TokenKind::Text(more)) = it.peek(0).map(|t| &t.kind) {
                all.extend(unescaped(more));
                it.at += 1;
            }
            let text = characters(all, place)?;
            return Ok(Expr {
                node: ExprNode::Text(text.into()),
                place,
            });
        }
        TokenKind::Name(_) => return named(it),
        TokenKind::Punctuator("(") => {
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
        TokenKind::Punctuator("[") => return it.lambda(),
        TokenKind::Punctuator("{") => return braces(it),
        TokenKind::Punctuator("::") => {
            it.at += 1;
            let mut value = named(it)?;
            of_file(&mut value);
            return Ok(value);
        }
        TokenKind::Punctuator(_) => return Err(unexpected(Some(token), place, "a value", HELP)),
    };
    it.at += 1;
    Ok(Expr { node, place })
}

/// `::name`, `::name<…>`: a name of the file.
fn of_file(it: &mut Expr) {
    match &mut it.node {
        ExprNode::Name(name) => *name = format!("::{name}").into(),
        ExprNode::Template(_, callee) => of_file(callee),
        _ => {}
    }
}

/// `static_cast<type>(value)`, from the `<` on.
fn named_cast(it: &mut Parser<'_>, name: &str, place: Place) -> Parsed<Expr> {
    it.at += 1;
    let of = it.read_cast().unwrap_or_default();
    it.expect(">", "write `static_cast<int>(value)`")?;
    it.expect("(", "write `static_cast<int>(value)`")?;
    let value = Box::new(it.expression()?);
    it.expect(")", "close the parenthesis")?;
    if name == "dynamic_cast" && of.pointer {
        let node = ExprNode::Text(of.class());
        let class = Expr { node, place };
        return Ok(Expr::made(name, vec![class, *value], place.to(it.before())));
    }
    Ok(Expr {
        node: it.converted(&of, value),
        place: place.to(it.before()),
    })
}

/// A name, with the spaces that are written before it; `type(value)`; `static_cast<type>(value)`.
fn named(it: &mut Parser<'_>) -> Parsed<Expr> {
    let place = it.place();
    let mut name = it.name(HELP)?;
    if name.ends_with("_cast") && it.sees("<") {
        return named_cast(it, &name, place);
    }
    if it.sees("::")
        && let Some(own) = it.enumeration_named(&name)
    {
        name = own;
    }
    let (mut std, mut full) = (false, name.to_string());
    while it.sees("::") && !it.word(1).is_empty() {
        std |= &*name == "std";
        it.at += 1;
        name = it.name(HELP)?;
        full = format!("{full}::{name}");
    }
    if let Some(class) = it.container(&name) {
        let given = given(it)?;
        return Ok(Expr::made(&class, given, place.to(it.before())));
    }
    let array = matches!(&*name, "vector" | "deque");
    let get = std && &*name == "get";
    if &*name == "numeric_limits" && it.sees("<") {
        return limit(it, place);
    }
    if (std || array) && !get {
        if std && matches!(&*name, "min" | "max" | "clamp") && it.sees("<") {
            return chosen(it, &full, place);
        }
        if array && let Some(made) = temporary(it, &name, place)? {
            return Ok(made);
        }
        let start = it.at;
        let angles = it.angles();
        if array && (std || angles) && it.sees("(") {
            let node = ExprNode::Name(FILLED.into());
            return Ok(Expr { node, place });
        }
        if !std {
            it.at = start;
        }
    }
    let plain = it.kind_named(&name);
    let kind = match it.enumeration_kind(&name) {
        Some(kind) if plain == Kind::Any => kind,
        _ => plain,
    };
    if kind != Kind::Any && (it.sees("(") || it.sees("{")) {
        let made = number(it, kind, place)?;
        // An enumeration is no plain number.
        return Ok(if plain == Kind::Any {
            Expr {
                place: made.place,
                node: ExprNode::Convert(Kind::Any, Box::new(made)),
            }
        } else {
            made
        });
    }
    match &*name {
        "sizeof" => return size_of(it, place),
        "new" => return allocation(it, place),
        _ => {}
    }
    if it.variadic.contains(&name) && (it.sees("(") || it.sees("<")) {
        let message = format!("`{name}` is a variadic template, which is not supported");
        let help = "write a function for each number of arguments that it is called with";
        return Err(Fault::error(place, message, "this call").help(help));
    }
    if (get || it.templates.contains(&name)) && it.sees("<") {
        let given = template_arguments(it)?;
        let callee = Expr {
            node: ExprNode::Name(full.into()),
            place,
        };
        return Ok(Expr {
            node: ExprNode::Template(given, Box::new(callee)),
            place: place.to(it.before()),
        });
    }
    let text = std && &*name == "string";
    if (text || it.classes.contains(&name)) && it.sees("{") {
        let of = braces(it)?;
        let given = if text { vec![of] } else { given_in(of) };
        return Ok(Expr::made(&full, given, place.to(it.before())));
    }
    let node = match &*name {
        "true" | "false" => {
            let node = ExprNode::Whole(i64::from(&*name == "true"));
            ExprNode::Convert(Kind::Flag, Box::new(Expr { node, place }))
        }
        "NULL" | "nullptr" => ExprNode::Whole(0),
        "__func__" | "__FUNCTION__" if !it.body_of.is_empty() => ExprNode::Text(it.body_of.clone()),
        _ => ExprNode::Name(full.into()),
    };
    Ok(Expr {
        node,
        place: place.to(it.before()),
    })
}

/// `std::numeric_limits<type>::max()`, from the `<` on.
fn limit(it: &mut Parser<'_>, place: Place) -> Parsed<Expr> {
    const SHAPE: &str = "write `std::numeric_limits<int>::max()`";
    let [TemplateArgument::Type(kind)] = template_arguments(it)?[..] else {
        return Err(unexpected(
            it.peek(0),
            it.place(),
            "a type of numbers",
            SHAPE,
        ));
    };
    it.expect("::", SHAPE)?;
    let node = ExprNode::Text(it.name(SHAPE)?);
    if it.sees("(") {
        arguments(it, SHAPE)?;
    }
    let place = place.to(it.before());
    let zero = Box::new(Expr {
        node: ExprNode::Whole(0),
        place,
    });
    let of = Expr {
        node: ExprNode::Convert(kind, zero),
        place,
    };
    Ok(Expr::made(LIMIT, vec![Expr { node, place }, of], place))
}

/// `std::vector<type>{…}`, `std::vector<type>(length)`, where the type is one of numbers, from the
/// `<` on; nothing, and no step ahead, elsewhere.
fn temporary(it: &mut Parser<'_>, name: &str, place: Place) -> Parsed<Option<Expr>> {
    let (start, half) = (it.at, it.half);
    let elements = if it.sees("<") {
        it.elements(name)
    } else {
        None
    };
    if elements.is_none() && it.at != start {
        (it.at, it.half) = (start, half);
        return Ok(None);
    }
    let kind = match elements {
        Some((kind, _, lengths)) if lengths.len() == 1 => kind,
        _ => Kind::Any,
    };
    let made = if it.sees("{") {
        braces(it)?
    } else if it.sees("(") && kind != Kind::Any {
        let given = arguments(it, "an array is `std::vector<int>(length, value)`")?;
        Expr::made(FILLED, given, place.to(it.before()))
    } else {
        (it.at, it.half) = (start, half);
        return Ok(None);
    };
    Ok(Some(Expr {
        place: made.place,
        node: ExprNode::Convert(kind, Box::new(made)),
    }))
}

/// `type(value)`, `type{value}`: a number, from the parenthesis or the brace on.
fn number(it: &mut Parser<'_>, kind: Kind, place: Place) -> Parsed<Expr> {
    let of = if it.sees("{") {
        let of = braces(it)?;
        let node = match of.node {
            ExprNode::Braces(all) => all.into_iter().next(),
            _ => None,
        };
        node.unwrap_or(Expr {
            node: ExprNode::Whole(0),
            place: place.to(it.before()),
        })
    } else {
        it.at += 1;
        let of = it.expression()?;
        it.expect(")", "close the parenthesis")?;
        of
    };
    Ok(Expr {
        node: ExprNode::Convert(kind, Box::new(of)),
        place: place.to(it.before()),
    })
}

/// `std::min<type>(a, b)` and its kin: of values that are converted to the type.
fn chosen(it: &mut Parser<'_>, name: &str, place: Place) -> Parsed<Expr> {
    const SHAPE: &str = "write `std::min<int>(a, b)`";
    let kind = match &template_arguments(it)?[..] {
        [TemplateArgument::Type(kind)] => *kind,
        _ => Kind::Any,
    };
    if !it.sees("(") {
        return Err(unexpected(it.peek(0), it.place(), "`(`", SHAPE));
    }
    let convert = |of: Expr| Expr {
        place: of.place,
        node: ExprNode::Convert(kind, Box::new(of)),
    };
    let given = arguments(it, SHAPE)?.into_iter().map(|of| match of.node {
        ExprNode::Braces(all) => Expr {
            node: ExprNode::Braces(all.into_iter().map(convert).collect()),
            place: of.place,
        },
        ExprNode::Lambda(_) => of,
        _ => convert(of),
    });
    let given = given.collect();
    Ok(convert(Expr::made(name, given, place.to(it.before()))))
}

/// `sizeof(type)`, `sizeof value`.
fn size_of(it: &mut Parser<'_>, place: Place) -> Parsed<Expr> {
    let start = it.at;
    let open = it.take("(");
    let plain = it.kind_named(it.word(0)) != Kind::Any
        || matches!(it.word(0), "unsigned" | "signed" | "const");
    if open
        && let Some(found) = it.read_type()
        && let enumeration = it.enumeration_kind(&found.class())
        && (plain || enumeration.is_some())
        && it.take(")")
    {
        let kind = match (found.pointer, found.kind) {
            (true, _) => Kind::Bits(64, false),
            (false, Kind::Any) => enumeration.unwrap_or(Kind::Any),
            (false, kind) => kind,
        };
        let place = place.to(it.before());
        let zero = Box::new(Expr {
            node: ExprNode::Whole(0),
            place,
        });
        let node = ExprNode::Convert(kind, zero);
        return Ok(Expr {
            node: ExprNode::SizeOf(Box::new(Expr { node, place })),
            place,
        });
    }
    it.at = start;
    let of = Box::new(it.deeper(unary)?);
    Ok(Expr {
        place: place.to(of.place),
        node: ExprNode::SizeOf(of),
    })
}

/// `new type`, `new type[length]`, `new type(values)`.
fn allocation(it: &mut Parser<'_>, place: Place) -> Parsed<Expr> {
    const SHAPE: &str = "memory is allocated with `new type[length]`";
    let Some(of) = it.read_type() else {
        return Err(unexpected(it.peek(0), it.place(), "a type", SHAPE));
    };
    let mut declared = of.declares("buffer".into(), place);
    if it.take("[") {
        declared.lengths.insert(0, Some(it.expression()?));
        it.expect("]", SHAPE)?;
    }
    let makes = it.makes(&declared);
    if it.sees("{") {
        declared.value = Some(braces(it)?);
    } else if it.sees("(") {
        let given = arguments(it, SHAPE)?;
        declared.value = if makes {
            Some(Expr::made(&declared.of, given, place))
        } else {
            given.into_iter().next()
        };
    } else if makes {
        declared.value = Some(Expr::made(&declared.of, Vec::new(), place));
    }
    Ok(Expr {
        node: ExprNode::New(Box::new(declared)),
        place: place.to(it.before()),
    })
}

/// What a template is given, in `<…>`.
pub(super) fn template_arguments(it: &mut Parser<'_>) -> Parsed<Vec<TemplateArgument>> {
    it.at += 1;
    let mut all = Vec::new();
    while !it.close_angle() {
        all.push(it.template_argument()?);
        if !it.take(",") && !it.sees(">") && !it.sees(">>") {
            let help = "a template is called by `name<value>(argument)`";
            return Err(unexpected(it.peek(0), it.place(), "`,` or `>`", help));
        }
    }
    Ok(all)
}

/// `(value, value)`; `help` says what is written so.
pub(super) fn arguments(it: &mut Parser<'_>, help: &str) -> Parsed<Vec<Expr>> {
    it.at += 1;
    let mut given = Vec::new();
    it.link()?;
    let (links, mut most) = (it.links, it.links);
    while !it.take(")") {
        it.links = links;
        given.push(it.assignment()?);
        most = most.max(it.links);
        if !it.take(",") && !it.sees(")") {
            return Err(unexpected(it.peek(0), it.place(), "`,` or `)`", help));
        }
    }
    it.links = most;
    Ok(given)
}

fn postfix(it: &mut Parser<'_>, mut value: Expr) -> Parsed<Expr> {
    loop {
        let start = value.place;
        let node = if it.sees("(") {
            let given = arguments(it, "a call is `name(argument, argument)`")?;
            match value.node {
                ExprNode::Template(types, callee) => {
                    let place = start.to(it.before());
                    let node = ExprNode::Call(callee, given);
                    ExprNode::Template(types, Box::new(Expr { node, place }))
                }
                _ => ExprNode::Call(Box::new(value), given),
            }
        } else if it.sees("{")
            && let ExprNode::Name(class) = &value.node
            && it.constructs(class)
        {
            let given = given_in(braces(it)?);
            Expr::made(class, given, start.to(it.before())).node
        } else if it.sees("[") {
            it.link()?;
            it.at += 1;
            let at = it.expression()?;
            it.expect("]", "an element is `name[index]`")?;
            ExprNode::Index(Box::new(value), Box::new(at))
        } else if it.sees(".") || it.sees("->") {
            it.link()?;
            it.at += 1;
            let mut name = it.name("a member is `object.name`")?;
            while it.take("::") {
                // `object.Base::name`
                name = format!("{name}::{}", it.name("a member is `object.Base::name`")?).into();
            }
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
