//! From tokens to statements. It recovers after a fault, so that all faults are told.

use std::{
    collections::{BTreeMap, BTreeSet},
    rc::Rc,
};

use super::{
    expression::{self, unexpected},
    token::{Kind as TokenKind, Token},
    tree::{
        Captures, Declared, Expr, ExprNode, Function, Kind, Parameter, Stmt, StmtNode, Struct,
        TemplateArgument, TemplateParameter, Word,
    },
};
use crate::{
    config::{Fault, Place, enough},
    limit::{CHAIN, NESTING},
};

/// Parses all of a text.
pub(super) fn parse(tokens: &[Token], end: usize) -> (Vec<Stmt>, Vec<Fault>) {
    let mut parser = Parser {
        tokens,
        at: 0,
        end,
        depth: 0,
        links: 0,
        space: String::new(),
        faults: Vec::new(),
        pending: Vec::new(),
        shared: Vec::new(),
        aliases: BTreeMap::new(),
        templates: BTreeSet::new(),
        template: Vec::new(),
        begun: BTreeMap::new(),
        half: false,
        in_class: false,
    };
    let statements = parser.statements(false);
    (statements, parser.faults)
}

pub(super) struct Parser<'a> {
    tokens: &'a [Token],
    pub at: usize,
    end: usize,
    depth: usize,
    /// How many operators and `else if`s stand one behind the other, at most: what walks the
    /// tree goes so deep.
    pub links: usize,
    /// The namespace.
    space: String,
    faults: Vec<Fault>,
    /// Statements that come before the one that is read.
    pending: Vec<Stmt>,
    /// Constants of the class that is read.
    shared: Vec<Stmt>,
    /// Types that have another name.
    aliases: BTreeMap<Word, Type>,
    /// Names of functions that are templates.
    pub templates: BTreeSet<Word>,
    /// The parameters of the template that is read.
    template: Vec<TemplateParameter>,
    /// How many kernels begin at a place: all those of a macro do at its call.
    begun: BTreeMap<usize, i64>,
    /// Whether the first half of a `>>` closed something.
    half: bool,
    /// Whether what is read belongs to a class itself.
    in_class: bool,
}

pub(super) type Parsed<T> = Result<T, Fault>;

/// Words of a type that say nothing about its value.
const QUALIFIERS: [&str; 14] = [
    "const",
    "static",
    "volatile",
    "inline",
    "constexpr",
    "extern",
    "register",
    "mutable",
    "struct",
    "typename",
    "virtual",
    "explicit",
    "friend",
    "thread_local",
];

/// Words that begin no declaration.
const RESERVED: [&str; 14] = [
    "if", "for", "while", "do", "switch", "case", "default", "break", "continue", "return", "else",
    "goto", "new", "delete",
];

/// A type, as far as it matters.
#[allow(clippy::struct_excessive_bools)] // What was said, each on its own.
#[derive(Clone)]
pub(super) struct Type {
    pub kind: Kind,
    constant: bool,
    lasting: bool,
    outside: bool,
    pub pointer: bool,
    reference: bool,
    /// Whether it is an array of the language's library, and its lengths.
    library: bool,
    lengths: Vec<Option<Expr>>,
    name: Word,
}

impl Default for Type {
    fn default() -> Self {
        Self {
            kind: Kind::Any,
            constant: false,
            lasting: false,
            outside: false,
            pointer: false,
            reference: false,
            library: false,
            lengths: Vec::new(),
            name: "".into(),
        }
    }
}

impl Type {
    /// A variable of this type, without a value.
    pub(super) fn declares(&self, name: Word, place: Place) -> Declared {
        Declared {
            name,
            kind: if self.pointer { Kind::Any } else { self.kind },
            of: self.name.clone(),
            lengths: self.lengths.clone(),
            value: None,
            reference: self.reference,
            pointer: self.pointer,
            library: self.library && !self.pointer,
            outside: self.outside,
            constant: self.constant,
            lasting: self.lasting,
            place,
        }
    }

    /// A value that is converted to it.
    pub(super) fn converts(&self, value: Box<Expr>) -> ExprNode {
        match self.kind {
            Kind::Any | Kind::Analog | Kind::Digital => ExprNode::Convert(self.value_kind(), value),
            kind if self.pointer => ExprNode::Recast(kind, value),
            _ => ExprNode::Convert(self.value_kind(), value),
        }
    }

    /// What a number of this type becomes.
    fn value_kind(&self) -> Kind {
        if self.pointer || self.library {
            Kind::Any
        } else {
            self.kind
        }
    }
}

impl<'a> Parser<'a> {
    pub(super) fn peek(&self, ahead: usize) -> Option<&'a Token> {
        self.tokens.get(self.at + ahead)
    }

    pub(super) fn sees(&self, mark: &str) -> bool {
        self.peek(0).is_some_and(|t| t.is(mark))
    }

    pub(super) fn word(&self, ahead: usize) -> &'a str {
        self.peek(ahead).and_then(Token::name).map_or("", |n| n)
    }

    pub(super) fn take(&mut self, mark: &str) -> bool {
        let seen = self.sees(mark);
        self.at += usize::from(seen);
        seen
    }

    fn take_word(&mut self, word: &str) -> bool {
        let seen = self.word(0) == word;
        self.at += usize::from(seen);
        seen
    }

    pub(super) fn place(&self) -> Place {
        let end = Place::new(self.end, self.end);
        self.peek(0).map_or(end, |t| t.place)
    }

    pub(super) fn before(&self) -> Place {
        let before = self.at.checked_sub(1).and_then(|at| self.tokens.get(at));
        before.map_or(Place::default(), |t| t.place)
    }

    /// How many kernels began here before this one, if any did.
    pub(super) fn begun_before(&mut self, place: Place) -> Option<i64> {
        let count = self.begun.entry(place.start).or_default();
        *count += 1;
        Some(*count - 1).filter(|before| *before > 0)
    }

    /// The token so many before the one that comes next.
    pub(super) fn tokens_before(&self, back: usize) -> &'a Token {
        &self.tokens[self.at - back]
    }

    pub(super) fn expect(&mut self, mark: &str, help: &str) -> Parsed<Place> {
        let place = self.place();
        if self.take(mark) {
            return Ok(place);
        }
        Err(unexpected(self.peek(0), place, &format!("`{mark}`"), help))
    }

    pub(super) fn name(&mut self, help: &str) -> Parsed<Word> {
        let name = self.peek(0).and_then(Token::name).cloned();
        match name {
            Some(name) => {
                self.at += 1;
                Ok(name)
            }
            None => Err(unexpected(self.peek(0), self.place(), "a name", help)),
        }
    }

    pub(super) fn deeper<T>(&mut self, inner: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        // Blocks of kernels inside loops inside functions go deeper than programs do.
        if self.depth == 4 * NESTING {
            let place = self.place();
            return Err(Fault::error(
                place,
                format!("more than {} levels inside each other", 4 * NESTING),
                "too deep",
            )
            .help("take it apart"));
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }

    /// One more operator or `else if` behind others.
    pub(super) fn link(&mut self) -> Parsed<()> {
        self.links += 1;
        if self.links <= CHAIN {
            return Ok(());
        }
        Err(Fault::error(
            self.place(),
            format!("more than {CHAIN} operators, calls or `else if`s one behind the other"),
            "too many",
        )
        .help("take it apart: give names to parts of it, or use a loop"))
    }

    /// Statements up to the end, or up to the brace that closes a block.
    pub(super) fn statements(&mut self, block: bool) -> Vec<Stmt> {
        let mut all = Vec::new();
        let (links, mut most) = (self.links, self.links);
        while self.peek(0).is_some() && !enough(&self.faults) {
            most = most.max(self.links);
            self.links = links;
            if self.sees("}") {
                if block {
                    break;
                }
                let place = self.place();
                self.faults.push(
                    Fault::error(place, "this `}` closes nothing", "no block is open")
                        .help("remove it"),
                );
                self.at += 1;
                continue;
            }
            let start = self.at;
            match self.deeper(Self::statement) {
                Ok(statement) => {
                    all.append(&mut self.pending);
                    if statement.node != StmtNode::Nothing {
                        all.push(statement);
                    }
                }
                Err(fault) => {
                    self.faults.push(fault);
                    self.recover(start);
                }
            }
        }
        self.links = most.max(self.links);
        all
    }

    /// Behind the next `;` or block.
    fn recover(&mut self, start: usize) {
        self.at = self.at.max(start + 1);
        while let Some(token) = self.peek(0) {
            if token.is("}") || token.first {
                return;
            }
            self.at += 1;
            if token.is(";") {
                return;
            }
        }
    }

    pub(super) fn block(&mut self) -> Parsed<Vec<Stmt>> {
        let open = self.expect("{", "a block is `{ statements }`")?;
        let statements = self.statements(true);
        if !self.take("}") {
            return Err(Fault::error(open, "this block has no end", "opened here")
                .help("close it with `}`"));
        }
        Ok(statements)
    }

    /// A statement, or what a file holds outside of functions.
    fn statement(&mut self) -> Parsed<Stmt> {
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
        if self.sees("{") {
            return Ok(StmtNode::Block(self.block()?));
        }
        if self.take(";") {
            return Ok(StmtNode::Nothing);
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
                let node = StmtNode::Switch(on, self.block()?);
                Ok(self.behind(first, node))
            }
            "case" => {
                self.at += 1;
                let value = self.expression()?;
                self.expect(":", "a case is `case value:`")?;
                Ok(StmtNode::Case(Some(value)))
            }
            "default" => {
                self.at += 1;
                self.expect(":", "a case is `default:`")?;
                Ok(StmtNode::Case(None))
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
                let template = self.template_parameters()?;
                let outer = std::mem::replace(&mut self.template, template);
                let node = self.statement_node();
                self.template = outer;
                node
            }
            "namespace" => self.namespace(),
            "enum" => self.enumeration(),
            "class" | "struct" | "union" if self.is_definition() => self.class(false),
            "extern" if matches!(self.peek(1).map(|t| &t.kind), Some(TokenKind::Text(_))) => {
                self.at += 2;
                if self.sees("{") {
                    return Ok(StmtNode::Block(self.block()?));
                }
                self.statement_node()
            }
            _ if self.is_constructor() => {
                while self.sees("::") || self.sees("~") || self.peek(1).is_some_and(|t| t.is("::"))
                {
                    self.at += 1;
                }
                let class = self.word(0);
                let member = self.member(class);
                Ok(StmtNode::Class(member.into_iter().collect()))
            }
            "init" | "frame" | "repeat" if self.peek(1).is_some_and(|t| t.is("{")) => {
                Err(Fault::error(
                    self.place(),
                    format!("`{}` is no C++", self.word(0)),
                    "this block",
                )
                .help("in C++ write `while (1) { … }` for the frames, `for` for a repetition"))
            }
            _ => {
                if let Some(node) = self.declaration()? {
                    Ok(node)
                } else {
                    let value = self.expression()?;
                    self.end_statement()?;
                    Ok(StmtNode::Expr(value))
                }
            }
        }
    }

    fn namespace(&mut self) -> Parsed<StmtNode> {
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
        let body = self.block();
        let space = std::mem::replace(&mut self.space, outer);
        Ok(StmtNode::Namespace(space.into(), body?))
    }

    fn jump(&mut self, node: StmtNode) -> Parsed<StmtNode> {
        self.at += 1;
        self.end_statement()?;
        Ok(node)
    }

    /// `;`, or the end of the line in text that has none.
    fn end_statement(&mut self) -> Parsed<()> {
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
        self.expect("(", "the condition stands in parentheses")?;
        let value = self.expression()?;
        self.expect(")", "close the parenthesis")?;
        Ok(value)
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
    fn behind(&self, first: Option<Stmt>, node: StmtNode) -> StmtNode {
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
        let start = self.at;
        if let Some(it) = self.declared_type()
            && self.peek(1).is_some_and(|t| t.is(":"))
        {
            let place = self.place();
            let name = self.name("the name of the element")?;
            let element = Box::new(it.declares(name, place));
            self.at += 1;
            let list = self.expression()?;
            self.expect(")", "a loop is `for (auto x : list) { … }`")?;
            return Ok(Some(StmtNode::Each(element, list, self.boxed()?)));
        }
        self.at = start;
        Ok(None)
    }

    fn enumeration(&mut self) -> Parsed<StmtNode> {
        self.at += 1;
        // The names of an `enum class` are only its own.
        let scoped = self.take_word("class") || self.take_word("struct");
        let space = Some(self.word(0)).filter(|it| scoped && !it.is_empty());
        while self.peek(0).is_some() && !self.sees("{") && !self.sees(";") {
            self.at += 1;
        }
        let mut all: Vec<Declared> = Vec::new();
        if self.take("{") {
            while !self.take("}") {
                let place = self.place();
                let name = self.name("the name of a constant")?;
                let name = space.map_or(name.clone(), |space| format!("{space}::{name}").into());
                let whole = |value| Expr {
                    node: ExprNode::Whole(value),
                    place,
                };
                let value = if self.take("=") {
                    self.assignment()?
                } else {
                    match all.last() {
                        None => whole(0),
                        Some(before) => {
                            let node = ExprNode::Name(before.name.clone());
                            let before = Box::new(Expr { node, place });
                            let node = ExprNode::Binary("+", before, Box::new(whole(1)));
                            Expr { node, place }
                        }
                    }
                };
                all.push(Declared {
                    name,
                    kind: Kind::INT,
                    of: "".into(),
                    lengths: Vec::new(),
                    value: Some(value),
                    reference: false,
                    pointer: false,
                    library: false,
                    outside: false,
                    constant: true,
                    lasting: false,
                    place,
                });
                if !self.take(",") && !self.sees("}") {
                    let place = self.place();
                    return Err(unexpected(
                        self.peek(0),
                        place,
                        "`,` or `}`",
                        "write `enum { A, B };`",
                    ));
                }
            }
        }
        self.skip_past(";");
        Ok(StmtNode::Declare(all))
    }

    /// Whether the function that makes or ends an object of a class is stated here.
    fn is_constructor(&mut self) -> bool {
        let start = self.at;
        let mut names = Vec::new();
        while !self.word(0).is_empty() {
            names.push(self.word(0));
            self.at += 1;
            if !self.take("::") {
                break;
            }
            if self.take("~") {
                names.push("~");
            }
        }
        let named = match &names[..] {
            [.., class, name] => class == name || *class == "~",
            _ => false,
        };
        let found = named && self.sees("(") && {
            self.skip_group();
            self.sees("{") || self.sees(":")
        };
        self.at = start;
        found
    }

    /// Whether a class is stated here, with its members.
    fn is_definition(&self) -> bool {
        let rest = self.tokens.get(self.at..).unwrap_or_default();
        let mark = rest
            .iter()
            .find(|t| t.is("{") || t.is(";") || t.is("(") || t.is("="));
        mark.is_some_and(|t| t.is("{"))
    }

    /// `typedef type name;`
    fn typedef(&mut self) -> Parsed<StmtNode> {
        self.at += 1;
        if matches!(self.word(0), "class" | "struct" | "union") && self.is_definition() {
            return self.class(true);
        }
        let start = self.at;
        if self.read_type().is_some()
            && let Some(name) = self.peek(0).and_then(Token::name).cloned()
        {
            self.at = start;
            self.alias(name);
        }
        self.skip_past(";");
        Ok(StmtNode::Nothing)
    }

    /// A type that stands here has this name from now on.
    fn alias(&mut self, name: Word) {
        if let Some(mut it) = self.read_type() {
            // Of a `typedef` the name stands between the two.
            self.take_word(&name);
            if let Ok(lengths) = self.read_lengths() {
                it.lengths.splice(0..0, lengths);
            }
            self.aliases.insert(name, it);
        }
    }

    /// A class. Where its members are data and plain functions its objects are known, else they are
    /// taken for unknown.
    fn class(&mut self, named_behind: bool) -> Parsed<StmtNode> {
        let place = self.place();
        let union = self.word(0) == "union";
        self.at += 1;
        let mut name: Word = match self.peek(0).and_then(Token::name) {
            Some(name) => name.clone(),
            None => format!("the class of {}", place.start).into(),
        };
        while self.peek(0).is_some() && !self.sees("{") && !self.sees(":") {
            self.at += 1;
        }
        let plain = !union && self.sees("{") && self.template.is_empty();
        while self.peek(0).is_some() && !self.sees("{") {
            self.at += 1;
        }
        let (data, functions) = self.class_body(&name, plain);
        let shared = std::mem::take(&mut self.shared);
        self.pending.extend(shared);
        if named_behind && let Some(behind) = self.peek(0).and_then(Token::name) {
            name = behind.clone();
        }
        let node = data.map_or(StmtNode::Nothing, |members| {
            StmtNode::Struct(Rc::new(Struct {
                name: name.clone(),
                members,
                functions: functions.clone(),
            }))
        });
        let place = place.to(self.before());
        let functions = Stmt {
            node: StmtNode::Class(functions),
            place,
        };
        if named_behind || self.word(0).is_empty() {
            self.skip_past(";");
            self.pending.push(functions);
            return Ok(node);
        }
        // Objects that are declared with their class.
        let all = self.declarators(&Type {
            name,
            ..Type::default()
        })?;
        self.end_statement()?;
        self.pending.extend([functions, Stmt { node, place }]);
        Ok(StmtNode::Declare(all))
    }

    /// What stands between the braces of a class: its data, where nothing else matters when an
    /// object is made, and its functions with bodies.
    fn class_body(
        &mut self,
        class: &str,
        plain: bool,
    ) -> (Option<Vec<Declared>>, Vec<Rc<Function>>) {
        let start = self.at;
        self.skip_group();
        let end = std::mem::replace(&mut self.at, start + 1);
        let (mut data, mut functions) = (Vec::new(), Vec::new());
        let mut plain = plain;
        while plain && self.at + 1 < end {
            match self.plain_member(class) {
                Some(StmtNode::Declare(more)) => data.extend(more),
                Some(StmtNode::Function(function)) => functions.push(function),
                Some(_) => {}
                None => plain = false,
            }
        }
        while self.at + 1 < end {
            if !self.word(0).is_empty()
                && let Some(member) = self.member(class)
            {
                functions.push(member);
            } else {
                self.at += 1;
            }
        }
        self.at = end;
        let plain = plain && data.iter().all(|it: &Declared| !it.reference);
        (plain.then_some(data), functions)
    }

    /// A member of a class that is data or a plain function; nothing where it is more than that.
    fn plain_member(&mut self, class: &str) -> Option<StmtNode> {
        if matches!(self.word(0), "public" | "private" | "protected") {
            self.at += 2;
            return Some(StmtNode::Nothing);
        }
        if self.take(";") {
            return Some(StmtNode::Nothing);
        }
        let rest = self.tokens.get(self.at..).unwrap_or_default();
        let mut head = rest.iter().take_while(|t| !t.is("{") && !t.is(";"));
        let operator = head.any(|t| t.name().is_some_and(|it| &**it == "operator"));
        if operator {
            return None;
        }
        let (told, shared) = (self.faults.len(), self.word(0) == "static");
        self.in_class = true;
        let place = self.place();
        let node = self.declaration();
        self.in_class = false;
        let clean = self.faults.len() == told;
        self.faults.truncate(told);
        if shared {
            // A constant of the class; what else is shared by its objects is not run.
            let fixed = |it: &Declared| it.constant && it.value.is_some();
            let Ok(Some(StmtNode::Declare(mut all))) = node else {
                return None;
            };
            if !clean || !all.iter().all(fixed) {
                return None;
            }
            for it in &mut all {
                it.name = format!("{class}::{}", it.name).into();
                it.lasting = false;
            }
            let node = StmtNode::Declare(all);
            self.shared.push(Stmt { node, place });
            return Some(StmtNode::Nothing);
        }
        match node {
            Ok(Some(
                node @ (StmtNode::Declare(_) | StmtNode::Function(_) | StmtNode::Prototype(_)),
            )) if clean => Some(node),
            _ => None,
        }
    }

    /// A function of a class, if the place is at its name and it has a body. Classes are not run:
    /// what does not parse in the body is no fault as long as nobody calls it.
    fn member(&mut self, class: &str) -> Option<Rc<Function>> {
        let (start, place) = (self.at, self.place());
        let name = self.peek(0)?.name()?.clone();
        self.at += 1;
        if &*name == "operator" {
            while self.peek(0).is_some_and(|t| !t.is("(") && !t.is(";")) {
                self.at += 1;
            }
        }
        let called = self.sees("(") && !RESERVED.contains(&&*name);
        while self.sees("(") {
            self.skip_group();
        }
        self.skip_to_body();
        if !called || !self.sees("{") {
            self.at = start;
            return None;
        }
        let body = self.member_body(&name);
        let hidden = *name == *class || &*name == "operator";
        Some(Rc::new(Function {
            name,
            space: "".into(),
            parameters: Vec::new(),
            body,
            hidden,
            qualified: false,
            place,
            returns: Kind::Any,
            template: Vec::new(),
            captures: Captures::default(),
            held: Vec::new(),
        }))
    }

    /// A body in braces; one that does not parse calls something unknown.
    fn member_body(&mut self, name: &Word) -> Vec<Stmt> {
        let (start, place, faults) = (self.at, self.place(), self.faults.len());
        self.skip_group();
        let end = std::mem::replace(&mut self.at, start);
        let body = self.block().unwrap_or_default();
        let understood = self.faults.len() == faults && self.at == end;
        self.faults.truncate(faults);
        self.at = end;
        if understood {
            return body;
        }
        let callee = ExprNode::Name(format!("{UNREAD}{name}").into());
        let callee = Expr {
            node: callee,
            place,
        };
        let node = ExprNode::Call(Box::new(callee), Vec::new());
        vec![Stmt {
            node: StmtNode::Expr(Expr { node, place }),
            place,
        }]
    }

    /// From behind the parameters of a function of a class to its body, if it has one: over
    /// `const`, `-> type`, and what a constructor sets.
    fn skip_to_body(&mut self) {
        if self.take(":") {
            while self.peek(0).is_some() && !self.sees("{") && !self.sees(";") {
                while !self.word(0).is_empty() || self.sees("::") {
                    self.at += 1;
                    self.angles();
                }
                self.skip_group();
                if !self.take(",") {
                    return;
                }
            }
            return;
        }
        while !self.word(0).is_empty()
            || ["->", "::", "*", "&", "<", ">"]
                .iter()
                .any(|mark| self.sees(mark))
        {
            self.at += 1;
        }
        if self.sees(":") {
            self.skip_to_body();
        }
    }

    /// What stands in `template <…>`.
    fn template_parameters(&mut self) -> Parsed<Vec<TemplateParameter>> {
        let start = self.at;
        if let Some(all) = self.read_template()? {
            return Ok(all);
        }
        self.at = start;
        self.angles();
        Ok(Vec::new())
    }

    fn read_template(&mut self) -> Parsed<Option<Vec<TemplateParameter>>> {
        let mut all: Vec<TemplateParameter> = Vec::new();
        self.take("<");
        while !self.take(">") {
            let is_type = matches!(self.word(0), "typename" | "class");
            if is_type {
                self.at += 1;
            } else if self.read_type().is_none() {
                return Ok(None);
            }
            let Some(name) = self.peek(0).and_then(Token::name).cloned() else {
                return Ok(None);
            };
            self.at += 1;
            let default = if self.take("=") {
                Some(self.template_argument()?)
            } else {
                None
            };
            all.push(TemplateParameter {
                name,
                is_type,
                default,
            });
            if !self.take(",") && !self.sees(">") {
                return Ok(None);
            }
        }
        Ok(Some(all))
    }

    /// A type or a value in `<…>`.
    pub(super) fn template_argument(&mut self) -> Parsed<TemplateArgument> {
        let start = self.at;
        let known = self.kind_named(self.word(0)) != Kind::Any
            || matches!(self.word(0), "const" | "unsigned" | "signed" | "std");
        if known && let Some(it) = self.read_type() {
            return Ok(TemplateArgument::Type(it.value_kind()));
        }
        self.at = start;
        Ok(TemplateArgument::Value(self.deeper(expression::sum)?))
    }

    /// What closes `<`; a `>>` closes two.
    pub(super) fn close_angle(&mut self) -> bool {
        if self.sees(">>") {
            self.at += usize::from(self.half);
            self.half = !self.half;
            return true;
        }
        self.take(">")
    }

    /// What a number of the type of this name becomes.
    pub(super) fn kind_named(&self, name: &str) -> Kind {
        let at = self
            .template
            .iter()
            .position(|it| &*it.name == name && it.is_type);
        if let Some(at) = at {
            return Kind::Parameter(at);
        }
        self.aliases
            .get(name)
            .map_or_else(|| kind_of(name), Type::value_kind)
    }

    fn skip_past(&mut self, mark: &str) {
        while let Some(token) = self.peek(0) {
            if token.is("{") {
                self.skip_group();
                continue;
            }
            self.at += 1;
            if token.is(mark) {
                return;
            }
        }
    }

    /// From an opening mark behind the one that closes it.
    fn skip_group(&mut self) {
        let mut depth = 0_usize;
        while let Some(token) = self.peek(0) {
            self.at += 1;
            if token.is("(") || token.is("[") || token.is("{") {
                depth += 1;
            } else if token.is(")") || token.is("]") || token.is("}") {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return;
                }
            }
        }
    }

    /// `<…>`, if it stands here and is closed.
    pub(super) fn angles(&mut self) -> bool {
        if !self.sees("<") {
            return false;
        }
        let start = self.at;
        let mut depth = 0_i32;
        while let Some(token) = self.peek(0) {
            self.at += 1;
            match token.kind {
                TokenKind::Mark("<") => depth += 1,
                TokenKind::Mark(">") => depth -= 1,
                TokenKind::Mark(">>") => depth -= 2,
                TokenKind::Mark("(" | ")" | "[" | "]" | "," | "::" | "*" | "&")
                | TokenKind::Name(_)
                | TokenKind::Whole(_) => {}
                _ => break,
            }
            if depth <= 0 {
                return true;
            }
        }
        self.at = start;
        false
    }

    /// A type with a name behind it, if that stands here; the place is then at the name.
    fn declared_type(&mut self) -> Option<Type> {
        let start = self.at;
        let found = self.read_type().filter(|_| {
            let name = self.word(0);
            !name.is_empty() && !RESERVED.contains(&name)
        });
        if found.is_none() {
            self.at = start;
        }
        found
    }

    /// A type, if one stands here.
    pub(super) fn read_kind(&mut self) -> Option<Kind> {
        self.read_cast().map(|it| it.value_kind())
    }

    /// The type that something is converted to, if one stands here.
    pub(super) fn read_cast(&mut self) -> Option<Type> {
        let start = self.at;
        let found = self.read_type();
        if found.is_none() {
            self.at = start;
        }
        found
    }

    pub(super) fn read_type(&mut self) -> Option<Type> {
        let mut it = Type::default();
        let (mut unsigned, mut named) = (None, false);
        loop {
            let word = self.word(0);
            if QUALIFIERS.contains(&word) {
                it.constant |= matches!(word, "const" | "constexpr");
                it.lasting |= word == "static";
                it.outside |= word == "extern";
                self.at += 1;
                continue;
            }
            if matches!(word, "unsigned" | "signed") {
                unsigned = Some(word == "unsigned");
                if !named {
                    it.kind = Kind::INT;
                }
                named = true;
                self.at += 1;
                continue;
            }
            let length = matches!(it.kind, Kind::Bits(..));
            if matches!(word, "int" | "long" | "short" | "char" | "double") && (!named || length) {
                it.kind = match (word, it.kind) {
                    ("double", _) => Kind::Real,
                    ("short", _) => Kind::Bits(16, true),
                    ("char", _) => Kind::Bits(8, true),
                    ("long", _) => Kind::Bits(64, true),
                    (_, Kind::Bits(bits, _)) => Kind::Bits(bits, true),
                    _ => Kind::INT,
                };
                named = true;
                self.at += 1;
                continue;
            }
            if named || word.is_empty() || RESERVED.contains(&word) {
                break;
            }
            named = true;
            self.type_name(&mut it);
            while self.sees("::") && !self.word(1).is_empty() {
                self.at += 1;
                self.type_name(&mut it);
            }
        }
        if let (Some(true), Kind::Bits(bits, _)) = (unsigned, it.kind) {
            it.kind = Kind::Bits(bits, false);
        }
        loop {
            if self.take("*") {
                it.pointer = true;
            } else if self.take("&") || self.take("&&") {
                it.reference = true;
            } else if QUALIFIERS.contains(&self.word(0)) {
                it.constant |= self.word(0) == "const";
                self.at += 1;
            } else {
                break;
            }
        }
        named.then_some(it)
    }

    /// The name of a type, with what stands in `<…>` behind it.
    fn type_name(&mut self, it: &mut Type) {
        let Some(name) = self.peek(0).and_then(Token::name).cloned() else {
            return;
        };
        self.at += 1;
        if let (Some(alias), false) = (self.aliases.get(&name), self.sees("<")) {
            let (constant, lasting) = (it.constant, it.lasting);
            *it = alias.clone();
            it.constant |= constant;
            it.lasting |= lasting;
            return;
        }
        it.kind = self.kind_named(&name);
        if matches!(&*name, "array" | "vector" | "deque") && self.sees("<") {
            let start = self.at;
            if let Some((kind, of, lengths)) = self.elements(&name) {
                (it.kind, it.name, it.lengths, it.library) = (kind, of, lengths, true);
                return;
            }
            (self.at, self.half) = (start, false);
        }
        it.name = name;
        self.angles();
    }

    /// The elements of `array<type, length>` or `vector<type>`.
    fn elements(&mut self, of: &str) -> Option<(Kind, Word, Vec<Option<Expr>>)> {
        self.at += 1;
        let inner = self.read_type()?;
        let mut lengths = vec![None];
        if of == "array" {
            if !self.take(",") {
                return None;
            }
            lengths[0] = Some(self.deeper(expression::sum).ok()?);
        }
        lengths.extend(inner.lengths.iter().cloned());
        let kind = if inner.pointer { Kind::Any } else { inner.kind };
        self.close_angle().then_some((kind, inner.name, lengths))
    }

    /// A declaration, if one stands here.
    fn declaration(&mut self) -> Parsed<Option<StmtNode>> {
        let start = self.at;
        if let Some(node) = self.function_pointer()? {
            return Ok(Some(node));
        }
        let Some(first) = self.declared_type() else {
            return Ok(None);
        };
        let (mut name_at, mut name_place) = (self.at, self.place());
        let mut name = self.name("the name of what is declared")?;
        // A function of a class.
        let mut qualified = Vec::new();
        while self.sees("::") && !self.word(1).is_empty() {
            qualified.push(self.word_before());
            self.at += 1;
            (name_at, name_place) = (self.at, self.place());
            name = self.name("a name")?;
        }
        let next = self.peek(0);
        let fits = next.is_none_or(|t| {
            t.first
                || ["=", ";", ",", "[", "(", "{", ":"]
                    .iter()
                    .any(|mark| t.is(mark))
        });
        // Two names side by side that are no declaration: something is missing between them.
        if !fits
            || (next.is_none_or(|t| t.first && !t.is("{") && !t.is("=") && !t.is("("))
                && start + 1 == self.at)
        {
            self.at = start;
            return Ok(None);
        }
        if self.sees("(")
            && let Some(node) = self.function(&name, name_place, first.value_kind(), &qualified)?
        {
            return Ok(Some(node));
        }
        self.at = name_at;
        let all = self.declarators(&first)?;
        self.end_statement()?;
        Ok(Some(StmtNode::Declare(all)))
    }

    /// The variables of a declaration, behind its type.
    fn declarators(&mut self, first: &Type) -> Parsed<Vec<Declared>> {
        let mut all = Vec::new();
        let mut of = first.clone();
        loop {
            let place = self.place();
            let name = self.name("the name of what is declared")?;
            let lengths = self.read_lengths()?;
            let mut declared = of.declares(name, place);
            declared.lengths.splice(0..0, lengths);
            if self.take("=") || self.sees("{") {
                declared.value = Some(self.assignment()?);
            } else if self.sees("(") {
                self.constructed(&mut declared)?;
            }
            declared.place = place.to(self.before());
            all.push(declared);
            if !self.take(",") {
                return Ok(all);
            }
            // A `*` belongs to its own name.
            (of.pointer, of.reference) = (false, false);
            loop {
                if self.take("*") {
                    of.pointer = true;
                } else if self.take("&") {
                    of.reference = true;
                } else {
                    break;
                }
            }
        }
    }

    /// `(*)[…])`, the rest of the type of a pointer to an array, if that stands here.
    pub(super) fn array_pointer(&mut self) -> bool {
        let start = self.at;
        if self.take("(") && self.take("*") && self.take(")") && self.sees("[") {
            while self.sees("[") {
                self.skip_group();
            }
            if self.take(")") {
                return true;
            }
        }
        self.at = start;
        false
    }

    /// The name in `(*name)(…)`, behind the type that the function gives back: a pointer to a
    /// function, or an array of them. In `(*name)[…]` it is one to an array, in `(&name)[…]` another
    /// name of one.
    fn pointer_name(&mut self) -> Option<(Word, Pointed)> {
        let start = self.at;
        let open = self.take("(");
        let reference = open && self.take("&");
        let open = reference || open && self.take("*");
        let name = self.peek(0).and_then(Token::name).cloned();
        self.at += 1;
        let array = self.sees("[");
        if array {
            self.skip_group();
        }
        let closed = open && self.take(")");
        let pointed = if closed && reference {
            (!array && self.sees("[")).then_some(Pointed::Reference)
        } else if closed && self.sees("(") {
            self.skip_group();
            if array {
                Some(Pointed::Functions)
            } else {
                Some(Pointed::Function)
            }
        } else if closed && !array && self.sees("[") {
            while self.sees("[") {
                self.skip_group();
            }
            let ends = ["=", ",", ")"].iter().any(|mark| self.sees(mark));
            ends.then_some(Pointed::Array)
        } else {
            None
        };
        if pointed.is_none() {
            self.at = start;
        }
        name.zip(pointed)
    }

    /// The lengths of an array, in brackets behind its name.
    fn read_lengths(&mut self) -> Parsed<Vec<Option<Expr>>> {
        let mut lengths = Vec::new();
        while self.take("[") {
            let length = if self.sees("]") {
                None
            } else {
                Some(self.expression()?)
            };
            self.expect("]", "an array is `type name[length];`")?;
            lengths.push(length);
        }
        Ok(lengths)
    }

    /// Over the lengths of an array.
    fn skip_lengths(&mut self) {
        while self.sees("[") {
            self.skip_group();
        }
    }

    /// `type (*name)(types) = function;` or `type (*name)[length] = &array;`, if that stands here.
    fn function_pointer(&mut self) -> Parsed<Option<StmtNode>> {
        let (start, place) = (self.at, self.place());
        let typed = !RESERVED.contains(&self.word(0)) && self.read_type().is_some();
        let Some((name, pointed)) = typed.then(|| self.pointer_name()).flatten() else {
            self.at = start;
            return Ok(None);
        };
        if pointed == Pointed::Reference {
            self.skip_lengths();
        }
        let mut value = if self.take("=") {
            Some(self.assignment()?)
        } else {
            None
        };
        // Of a pointer to a whole array, `&array`, `*name` is the array: the first of these.
        let whole = |it: &Expr| match &it.node {
            ExprNode::Unary("&", of) => matches!(of.node, ExprNode::Name(_)),
            node => matches!(node, ExprNode::Convert(..)),
        };
        let whole = pointed == Pointed::Array && value.as_ref().is_some_and(whole);
        if whole {
            value = value.map(|it| Expr {
                place: it.place,
                node: ExprNode::Braces(vec![it]),
            });
        }
        let declared = Declared {
            name,
            kind: Kind::Any,
            of: "".into(),
            lengths: if whole || pointed == Pointed::Functions {
                vec![None]
            } else {
                Vec::new()
            },
            value,
            reference: pointed == Pointed::Reference,
            pointer: pointed != Pointed::Reference,
            outside: false,
            library: false,
            constant: false,
            lasting: false,
            place: place.to(self.before()),
        };
        self.end_statement()?;
        Ok(Some(StmtNode::Declare(vec![declared])))
    }

    /// `name(value)`: a value for numbers, something of its own for objects.
    fn constructed(&mut self, it: &mut Declared) -> Parsed<()> {
        let place = self.place();
        self.at += 1;
        let mut given = Vec::new();
        while !self.take(")") {
            given.push(self.assignment()?);
            if !self.take(",") && !self.sees(")") {
                return Err(unexpected(
                    self.peek(0),
                    self.place(),
                    "`,` or `)`",
                    "write `type name(value);`",
                ));
            }
        }
        let number = it.kind != Kind::Any || matches!(&*it.of, "scamp5_kernel" | "auto");
        it.value = match (it.library, given.len()) {
            (true, 1) => {
                it.lengths = vec![given.pop()];
                None
            }
            (true, 2) => {
                let node = ExprNode::Name(FILLED.into());
                let callee = Box::new(Expr { node, place });
                let node = ExprNode::Call(callee, given);
                Some(Expr { node, place })
            }
            _ if number || it.pointer => given.into_iter().next(),
            // An object of the language's library: its name stands for it.
            _ => {
                let node = ExprNode::Text(it.of.clone());
                Some(Expr { node, place })
            }
        };
        Ok(())
    }

    /// A function with its body, or a prototype, if one of them stands here.
    fn function(
        &mut self,
        name: &Word,
        place: Place,
        returns: Kind,
        qualified: &[&str],
    ) -> Parsed<Option<StmtNode>> {
        let space: Word = within(&self.space, qualified).into();
        let qualified = !qualified.is_empty();
        let start = self.at;
        self.skip_group();
        while QUALIFIERS.contains(&self.word(0)) || self.word(0) == "override" {
            self.at += 1;
        }
        let (body, prototype) = (self.sees("{") || self.sees(":"), self.sees(";"));
        self.at = start;
        if !(body || prototype && self.looks_like_parameters()) {
            return Ok(None);
        }
        self.at += 1;
        let parameters = self.parameters()?;
        while QUALIFIERS.contains(&self.word(0)) || self.word(0) == "override" {
            self.at += 1;
        }
        if !self.template.is_empty() {
            self.templates.insert(name.clone());
        }
        let mut it = Function {
            name: name.clone(),
            space,
            parameters,
            body: Vec::new(),
            hidden: false,
            qualified,
            place,
            returns,
            template: self.template.clone(),
            captures: Captures::default(),
            held: Vec::new(),
        };
        if self.take(";") {
            return Ok(Some(StmtNode::Prototype(Rc::new(it))));
        }
        while self.peek(0).is_some() && !self.sees("{") {
            self.at += 1;
        }
        it.body = if std::mem::take(&mut self.in_class) {
            self.member_body(name)
        } else {
            self.block()?
        };
        Ok(Some(StmtNode::Function(Rc::new(it))))
    }

    /// Whether what stands in parentheses here are parameters rather than values.
    fn looks_like_parameters(&mut self) -> bool {
        let start = self.at;
        self.at += 1;
        let empty = self.sees(")");
        let typed = self.read_type().is_some();
        let named = typed
            && (!self.word(0).is_empty()
                || kind_of(self.word_before()) != Kind::Any
                || self.word_before() == "void"
                || self.tokens[self.at - 1].name().is_none());
        self.at = start;
        empty || named
    }

    fn word_before(&self) -> &'a str {
        let before = self.at.checked_sub(1).and_then(|at| self.tokens.get(at));
        before.and_then(Token::name).map_or("", |n| n)
    }

    /// Parameters up to `)`.
    pub(super) fn parameters(&mut self) -> Parsed<Vec<Parameter>> {
        const HELP: &str = "a function is `type name(type parameter) { … }`";
        let mut all = Vec::new();
        while !self.take(")") {
            if self.take("...") {
                continue;
            }
            let Some(it) = self.read_type() else {
                return Err(unexpected(self.peek(0), self.place(), "a type", HELP));
            };
            let function = self.pointer_name();
            let alias = function
                .as_ref()
                .is_some_and(|it| it.1 == Pointed::Reference);
            let called = function.is_some() && !alias;
            let mut array = { &function }
                .as_ref()
                .is_some_and(|it| it.1 != Pointed::Function)
                || !it.library && !it.lengths.is_empty();
            let name = match (function, self.peek(0).and_then(Token::name)) {
                (Some((name, _)), _) => name,
                (None, Some(name)) => {
                    self.at += 1;
                    name.clone()
                }
                (None, None) => "".into(),
            };
            let extent = alias.then(|| self.word(1)).filter(|it| !it.is_empty());
            while self.take("[") {
                array = true;
                while self.peek(0).is_some() && !self.take("]") {
                    self.at += 1;
                }
            }
            let default = if self.take("=") {
                Some(self.assignment()?)
            } else {
                None
            };
            let single_void = &*it.name == "void" && name.is_empty() && !it.pointer;
            if !single_void {
                all.push(Parameter {
                    name,
                    kind: if array || called {
                        Kind::Any
                    } else {
                        it.value_kind()
                    },
                    of: if called { "".into() } else { it.name },
                    reference: it.reference && !it.constant && !called || alias,
                    pointer: it.pointer && !called || array,
                    extent: extent.map(Into::into),
                    default,
                });
            }
            if !self.take(",") && !self.sees(")") {
                return Err(unexpected(self.peek(0), self.place(), "`,` or `)`", HELP));
            }
        }
        Ok(all)
    }

    pub(super) fn expression(&mut self) -> Parsed<Expr> {
        self.deeper(expression::comma)
    }

    pub(super) fn assignment(&mut self) -> Parsed<Expr> {
        self.deeper(expression::assignment)
    }
}

/// What the name begins with of what a function of a class calls whose body is not understood.
pub(super) const UNREAD: &str = "the body of ";

/// The call that makes an array of a length, filled with a value.
pub(super) const FILLED: &str = "a filled vector";

/// What a pointer in parentheses leads to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pointed {
    Function,
    /// There is an array of such pointers.
    Functions,
    Array,
    /// It is another name of an array.
    Reference,
}

/// A namespace inside of another.
fn within(outer: &str, names: &[&str]) -> String {
    let outer = Some(outer).filter(|it| !it.is_empty());
    let all: Vec<&str> = outer.into_iter().chain(names.iter().copied()).collect();
    all.join("::")
}

/// What a number of this type becomes.
pub(super) fn kind_of(name: &str) -> Kind {
    match name {
        "bool" => Kind::Flag,
        "float" => Kind::Float,
        "double" => Kind::Real,
        "int8_t" | "char" => Kind::Bits(8, true),
        "uint8_t" => Kind::Bits(8, false),
        "int16_t" | "short" => Kind::Bits(16, true),
        "uint16_t" => Kind::Bits(16, false),
        "int" | "int32_t" | "signed" => Kind::INT,
        "uint32_t" | "unsigned" => Kind::Bits(32, false),
        "long" | "int64_t" | "ptrdiff_t" => Kind::Bits(64, true),
        "size_t" | "uint64_t" => Kind::Bits(64, false),
        "areg_t" => Kind::Analog,
        "dreg_t" => Kind::Digital,
        _ => Kind::Any,
    }
}
