//! Statements: blocks, choices and loops.

use super::{Parsed, Parser, expression::unexpected, within};
use crate::{
    config::{Fault, Place},
    program::vendor::{
        lexer::token::{Token, TokenKind},
        syntax::tree::{Expr, ExprNode, Kernel, Stmt, StmtNode},
    },
};

impl Parser<'_> {
    /// A statement, or what a file holds outside of functions.
    pub(super) fn statement(&mut self) -> Parsed<Stmt> {
        let start = self.place();
        let node = self.statement_node()?;
        Ok(Stmt {
            node,
            place: start.to(self.before()),
        })
    }

    fn boxed(&mut self) -> Parsed<Box<Stmt>> {
        Ok(Box::new(self.deeper(Self::statement)?))
    }

    #[allow(clippy::too_many_lines)] // One arm for each kind of statement.
    fn statement_node(&mut self) -> Parsed<StmtNode> {
        if self.labels() && (self.sees("}") || self.ends_kernel()) {
            return Ok(StmtNode::Nothing);
        }
        if self.sees("{") {
            return Ok(StmtNode::Block(self.block()?));
        }
        if self.take(";") {
            return Ok(StmtNode::Nothing);
        }
        if self.begins_kernel() {
            return self.kernel();
        }
        if self.ends_kernel() {
            return Err(self.stray_end());
        }
        match self.word(0) {
            "if" => self.if_statement(),
            "for" => self.for_statement(),
            "while" => {
                self.at += 1;
                let condition = self.parenthesised()?;
                Ok(StmtNode::While(condition, self.boxed()?))
            }
            "do" => {
                self.at += 1;
                let body = self.boxed()?;
                if !self.take_word("while") {
                    let place = self.place();
                    let help = "a loop is `do { … } while (…);`";
                    return Err(unexpected(self.peek(0), place, "`while`", help));
                }
                let condition = self.parenthesised()?;
                self.end_statement()?;
                Ok(StmtNode::DoWhile(body, condition))
            }
            "switch" => {
                self.at += 1;
                let (first, on) = self.headed()?;
                let body = self.block()?;
                if let Some(place) = body.iter().find_map(inner_case) {
                    let message =
                        "a `case` inside a nested statement of its `switch` is not supported";
                    let fault = Fault::error(place, message, "this case");
                    self.faults
                        .push(fault.help("put it between the other cases"));
                }
                Ok(self.behind(first, StmtNode::Switch(on, body)))
            }
            "case" => {
                self.at += 1;
                let mut value = self.expression()?;
                if self.take("...") {
                    let (place, last) = (value.place, self.expression()?);
                    let node = ExprNode::Braces(vec![value, last]);
                    value = Expr { node, place };
                }
                self.expect(":", "a case is `case value:`")?;
                Ok(StmtNode::Case(Some(value)))
            }
            "default" => {
                self.at += 1;
                self.expect(":", "a case is `default:`")?;
                Ok(StmtNode::Case(None))
            }
            "goto" => Err(
                Fault::error(self.place(), "`goto` is not supported", "this jump")
                    .help("write a loop with `break` or `continue`, or an `if`, in its place"),
            ),
            "try" | "throw" | "co_await" | "co_yield" | "co_return" => {
                self.not_followed();
                Ok(StmtNode::Nothing)
            }
            "break" => self.jump(StmtNode::Break),
            "continue" => self.jump(StmtNode::Continue),
            "return" => {
                self.at += 1;
                let value = if self.sees(";") {
                    None
                } else {
                    Some(self.expression()?)
                };
                self.end_statement()?;
                Ok(StmtNode::Return(value))
            }
            "typedef" => self.typedef(),
            "using" => {
                self.at += 1;
                let name = self.peek(0).and_then(Token::name).cloned();
                if let (Some(name), true) = (name, self.peek(1).is_some_and(|t| t.is("="))) {
                    self.at += 2;
                    self.alias(name);
                }
                self.skip_past(";");
                Ok(StmtNode::Nothing)
            }
            "delete" => {
                self.at += 1;
                if self.take("[") {
                    self.take("]");
                }
                self.expression()?;
                self.end_statement()?;
                Ok(StmtNode::Nothing)
            }
            "template" => {
                self.at += 1;
                if self.variadic_function() {
                    return Ok(StmtNode::Nothing);
                }
                let special = self.peek(1).is_some_and(|t| t.is(">"));
                let template = self.template_parameters()?;
                let outer = std::mem::replace(&mut self.template, template);
                let around = std::mem::replace(&mut self.special, special);
                let node = self.statement_node();
                self.special = around;
                self.template = outer;
                node
            }
            "namespace" => self.namespace(),
            "inline" if self.word(1) == "namespace" => {
                self.at += 1;
                self.namespace()
            }
            // It is defined elsewhere.
            "class" | "struct" | "union" | "enum" if self.is_announced() => {
                self.skip_past(";");
                Ok(StmtNode::Nothing)
            }
            _ if self.is_definition() => self.defined_type(),
            "extern" if matches!(self.peek(1).map(|t| &t.kind), Some(TokenKind::Text(_))) => {
                self.at += 2;
                if self.sees("{") {
                    return Ok(StmtNode::Block(self.open_block()?));
                }
                self.statement_node()
            }
            _ if self.is_constructor() => self.behind_class(),
            "init" | "frame" | "repeat" if self.peek(1).is_some_and(|t| t.is("{")) => {
                Err(Fault::error(
                    self.place(),
                    format!("`{}` is not C++", self.word(0)),
                    "this block",
                )
                .help("in C++ write `while (1) { … }` for the frames, `for` for a repetition"))
            }
            _ => {
                if let Some(node) = self.declaration()? {
                    Ok(node)
                } else {
                    let value = self.expression()?;
                    if matches!(value.node, ExprNode::Name(_)) {
                        self.bare_word();
                    }
                    self.end_statement()?;
                    Ok(StmtNode::Expr(value))
                }
            }
        }
    }

    /// Over labels, which only a `goto` is for; whether there are any. Behind them the statement
    /// stands that they belong to.
    fn labels(&mut self) -> bool {
        let start = self.at;
        while !matches!(self.word(0), "" | "default" | "case")
            && self.peek(1).is_some_and(|t| t.is(":"))
        {
            self.at += 2;
        }
        self.at > start
    }

    /// Tells of a word alone that ends with its line, if one stands before this.
    fn bare_word(&mut self) {
        let ends = self.sees("}") || self.peek(0).is_none_or(|t| t.first);
        if self.sees(";") || !ends {
            return;
        }
        let end = self.before().end;
        let (help, found) = ("a statement is `name(argument, argument)`", self.peek(0));
        let fault = unexpected(found, Place::new(end, end), "`(`", help);
        // What is tried twice is told once.
        if self.words.iter().all(|it| it.place.start != end) {
            self.words.push(fault);
        }
    }

    pub(super) fn namespace(&mut self) -> Parsed<StmtNode> {
        self.at += 1;
        let mut names = Vec::new();
        while self.peek(0).is_some() && !self.sees("{") && !self.sees(";") {
            names.extend(Some(self.word(0)).filter(|it| !it.is_empty()));
            self.at += 1;
        }
        if self.take(";") {
            return Ok(StmtNode::Nothing);
        }
        let outer = self.space.clone();
        self.space = within(&outer, &names);
        let body = self.open_block();
        let space = std::mem::replace(&mut self.space, outer);
        Ok(StmtNode::Namespace(space.into(), body?))
    }

    fn jump(&mut self, node: StmtNode) -> Parsed<StmtNode> {
        self.at += 1;
        self.end_statement()?;
        Ok(node)
    }

    /// `;`, or the end of the line in text that has none.
    pub(super) fn end_statement(&mut self) -> Parsed<()> {
        if self.take(";") || self.sees("}") || self.peek(0).is_none_or(|t| t.first) {
            return Ok(());
        }
        let end = self.before().end;
        Err(Fault::error(
            Place::new(end, end),
            "expected `;` here",
            "a statement ends with `;` or with its line",
        )
        .help("a statement is `name(argument, argument);`"))
    }

    fn parenthesised(&mut self) -> Parsed<Expr> {
        self.expect("(", "put the condition in parentheses")?;
        let value = self.expression()?;
        self.expect(")", "close the parenthesis")?;
        Ok(value)
    }

    /// Tells of a statement that is not supported, and passes it with its blocks.
    fn not_followed(&mut self) {
        let word = self.word(0).to_owned();
        let (what, help) = match &*word {
            "try" => (
                "block",
                "write its statements without `try`: nothing is thrown here",
            ),
            "throw" => ("statement", "leave it out, or `return`"),
            _ => ("statement", "write a loop that waits for its frames"),
        };
        let message = format!("`{word}` is not supported");
        let fault = Fault::error(self.place(), message, format!("this {what}"));
        self.faults.push(fault.help(help));
        if word != "try" {
            return self.skip_past(";");
        }
        self.at += 1;
        self.skip_group();
        while self.take_word("catch") {
            self.skip_group();
            self.skip_group();
        }
    }

    fn if_statement(&mut self) -> Parsed<StmtNode> {
        // `else if` is no deeper than the `if` before it, but where it declares something.
        let depth = self.depth;
        let node = self.if_chain();
        self.depth = depth;
        node
    }

    fn if_chain(&mut self) -> Parsed<StmtNode> {
        let (mut parts, mut otherwise) = (Vec::new(), None);
        let (links, mut most) = (self.links, self.links);
        loop {
            let start = self.place();
            self.at += 1;
            self.take_word("constexpr");
            self.links = links + parts.len();
            self.link()?;
            let (first, condition) = self.headed()?;
            if first.is_some() {
                self.deeper(|_| Ok(()))?;
                self.depth += 1;
            }
            parts.push((start, first, condition, self.boxed()?));
            most = most.max(self.links);
            if !self.take_word("else") {
                break;
            }
            if self.word(0) != "if" {
                self.links = links + parts.len();
                otherwise = Some(self.boxed()?);
                break;
            }
        }
        self.links = most.max(self.links);
        let end = self.before();
        while let Some((start, first, condition, yes)) = parts.pop() {
            let node = self.behind(first, StmtNode::If(condition, yes, otherwise.take()));
            if parts.is_empty() {
                return Ok(node);
            }
            let place = start.to(end);
            otherwise = Some(Box::new(Stmt { node, place }));
        }
        Ok(StmtNode::Nothing)
    }

    /// A condition in parentheses, and what stands before it: `(first; condition)`, or a variable
    /// that is declared there and is the condition.
    fn headed(&mut self) -> Parsed<(Option<Stmt>, Expr)> {
        let (start, place) = (self.at, self.place());
        self.skip_group();
        let inside = self.tokens.get(start + 1..self.at).unwrap_or_default();
        self.at = start;
        if inside.iter().any(|t| t.is(";")) && !inside.iter().any(|t| t.is("{")) {
            self.at += 1;
            let first = self.statement()?;
            let condition = self.expression()?;
            self.expect(")", "close the parenthesis")?;
            return Ok((Some(first), condition));
        }
        self.at += 1;
        if let Some(it) = self.declared_type()
            && self.peek(1).is_some_and(|t| t.is("=") || t.is("{"))
        {
            let all = self.declarators(&it)?;
            self.expect(")", "close the parenthesis")?;
            let node = ExprNode::Name(all[0].name.clone());
            let node = Expr { node, place };
            let declare = StmtNode::Declare(all);
            return Ok((
                Some(Stmt {
                    node: declare,
                    place,
                }),
                node,
            ));
        }
        self.at = start;
        Ok((None, self.parenthesised()?))
    }

    /// A statement in a block with what stands before it.
    pub(super) fn behind(&self, first: Option<Stmt>, node: StmtNode) -> StmtNode {
        match first {
            None => node,
            Some(first) => {
                let place = first.place.to(self.before());
                StmtNode::Block(vec![first, Stmt { node, place }])
            }
        }
    }

    fn for_statement(&mut self) -> Parsed<StmtNode> {
        const HELP: &str = "a loop is `for (int i = 0; i < 10; i++) { … }`";
        self.at += 1;
        self.expect("(", HELP)?;
        if let Some(node) = self.range_for()? {
            return Ok(node);
        }
        let start = if self.take(";") {
            None
        } else {
            Some(self.boxed()?)
        };
        let condition = if self.sees(";") {
            None
        } else {
            Some(self.expression()?)
        };
        self.expect(";", HELP)?;
        let step = if self.sees(")") {
            None
        } else {
            Some(self.expression()?)
        };
        self.expect(")", HELP)?;
        Ok(StmtNode::For(start, condition, step, self.boxed()?))
    }

    /// `for (type x : list) …`, if it is that.
    fn range_for(&mut self) -> Parsed<Option<StmtNode>> {
        const HELP: &str = "a loop is `for (auto x : list) { … }`";
        let start = self.at;
        if let Some((whole, members)) = self.bound_names()?
            && self.take(":")
        {
            let list = self.expression()?;
            self.expect(")", HELP)?;
            let body = self.boxed()?;
            let place = whole.place.to(self.before());
            let node = StmtNode::Declare(members);
            let node = StmtNode::Block(vec![Stmt { node, place }, *body]);
            let body = Box::new(Stmt { node, place });
            return Ok(Some(StmtNode::Each(Box::new(whole), list, body)));
        }
        self.at = start;
        if let Some(it) = self.declared_type()
            && self.peek(1).is_some_and(|t| t.is(":"))
        {
            let place = self.place();
            let name = self.name("the name of the element")?;
            let element = Box::new(it.declares(name, place));
            self.at += 1;
            let list = self.expression()?;
            self.expect(")", HELP)?;
            return Ok(Some(StmtNode::Each(element, list, self.boxed()?)));
        }
        self.at = start;
        Ok(None)
    }
}

/// A case of the `switch` around it that stands inside this statement.
fn inner_case(it: &Stmt) -> Option<Place> {
    let body = |it: &Stmt| match it.node {
        StmtNode::Case(_) => Some(it.place),
        _ => inner_case(it),
    };
    match &it.node {
        StmtNode::Block(all)
        | StmtNode::Namespace(_, all)
        | StmtNode::Kernel(Kernel { body: all, .. }) => all.iter().find_map(body),
        StmtNode::If(_, yes, no) => body(yes).or_else(|| body(no.as_deref()?)),
        StmtNode::For(_, _, _, of)
        | StmtNode::Each(_, _, of)
        | StmtNode::While(_, of)
        | StmtNode::DoWhile(of, _) => body(of),
        StmtNode::Switch(..)
        | StmtNode::Declare(_)
        | StmtNode::Expr(_)
        | StmtNode::Case(_)
        | StmtNode::Break
        | StmtNode::Continue
        | StmtNode::Return(_)
        | StmtNode::Function(_)
        | StmtNode::Prototype(_)
        | StmtNode::Struct(_)
        | StmtNode::Class(_)
        | StmtNode::Nothing => None,
    }
}
