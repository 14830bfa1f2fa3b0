//! From tokens to statements. It recovers after a fault, so that all faults are told.

mod base_class;
mod class;
mod constructor;
mod container;
mod declaration;
mod designated;
pub(in crate::program::vendor) mod expression;
mod function;
mod initial;
mod kernel;
mod lambda;
mod member_initialiser;
mod operator;
mod statement;
mod template;
mod types;

use std::collections::{BTreeMap, BTreeSet};

pub(in crate::program::vendor) use self::class::{REFERS, UNREAD, ended};
pub(super) use self::types::Type;
use self::{expression::unexpected, member_initialiser::MemberInitialisers};
use super::tree::{Expr, Kind, Stmt, StmtNode, TemplateParameter, Word};
use crate::{
    config::{Fault, Place, enough},
    limit::{CHAIN, NESTING},
    program::vendor::lexer::token::Token,
};

/// Expressions, statements and types that are tried for each token, before a text has too many
/// ways to be read.
const TRIES: usize = 64;

/// What a text says.
pub(in crate::program::vendor) struct Said {
    pub statements: Vec<Stmt>,
    pub faults: Vec<Fault>,
    /// Words alone that end with their lines: statements without parentheses.
    pub words: Vec<Fault>,
    /// Enumerations, with the type of their numbers.
    pub enumerations: BTreeMap<Word, Kind>,
}

/// Parses all of a text.
pub(in crate::program::vendor) fn parse(tokens: &[Token], end: usize) -> Said {
    let mut parser = Parser {
        tokens,
        at: 0,
        end,
        depth: 0,
        tries: 0,
        lost: None,
        over: Over::No,
        links: 0,
        space: String::new(),
        faults: Vec::new(),
        words: Vec::new(),
        body_of: "".into(),
        pending: Vec::new(),
        shared: Vec::new(),
        aliases: BTreeMap::new(),
        enumerations: BTreeMap::new(),
        templates: BTreeSet::new(),
        variadic: BTreeSet::new(),
        variables: BTreeSet::new(),
        template: Vec::new(),
        begun: BTreeMap::new(),
        half: false,
        in_class: false,
        constructed: BTreeSet::new(),
        announced: BTreeMap::new(),
        classes: BTreeSet::new(),
        inside: None,
        base: None,
        special: false,
        library: Vec::new(),
        inner: 0,
    };
    let statements = parser.statements(Until::End);
    if let Some(place) = parser.lost {
        // What was tried may have been given up in silence.
        parser.faults = vec![too_many_ways(place)];
    }
    Said {
        statements,
        faults: parser.faults,
        words: parser.words,
        enumerations: parser.enumerations,
    }
}

pub(super) struct Parser<'a> {
    tokens: &'a [Token],
    pub at: usize,
    end: usize,
    depth: usize,
    tries: usize,
    /// Where no more was tried.
    lost: Option<Place>,
    over: Over,
    /// How many operators and `else if`s stand one behind the other, at most: what walks the
    /// tree goes so deep.
    pub links: usize,
    /// The namespace.
    space: String,
    faults: Vec<Fault>,
    /// Words alone that end with their lines.
    words: Vec<Fault>,
    /// The function whose body is read.
    pub body_of: Word,
    /// Statements that come before the one that is read.
    pending: Vec<Stmt>,
    /// Constants of the class that is read.
    shared: Vec<Stmt>,
    /// Types that have another name.
    aliases: BTreeMap<Word, Type>,
    /// Enumerations, with the type of their numbers.
    enumerations: BTreeMap<Word, Kind>,
    /// Names of functions that are templates.
    pub templates: BTreeSet<Word>,
    /// Those that take any number of types.
    pub variadic: BTreeSet<Word>,
    /// Names of variables that are no constants.
    pub variables: BTreeSet<Word>,
    /// The parameters of the template that is read.
    template: Vec<TemplateParameter>,
    /// How many kernels begin at a place: all those of a macro do at its call.
    begun: BTreeMap<usize, usize>,
    /// Whether the first half of a `>>` closed something.
    pub half: bool,
    /// Whether what is read belongs to a class itself.
    in_class: bool,
    /// Classes whose constructors are run.
    constructed: BTreeSet<Word>,
    /// Classes with constructors that stand behind them.
    announced: BTreeMap<Word, MemberInitialisers>,
    /// Classes whose objects are known.
    pub classes: BTreeSet<Word>,
    /// The class whose members are read, with its namespaces.
    inside: Option<Word>,
    /// The class that the class which is read is made from.
    base: Option<Word>,
    /// Whether `template <>` stands before what is read.
    special: bool,
    /// Classes of the language's library, of types that were given, which are to be defined.
    library: Vec<Stmt>,
    /// How many blocks of functions are open.
    inner: usize,
}

/// Whether the text goes beyond a limit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Over {
    No,
    /// In what was tried, maybe in vain.
    At(Place),
    /// It was told, and nothing more is read.
    Told,
}

/// Where a list of statements ends.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Until {
    /// With the text.
    End,
    /// At the brace that closes their block.
    Brace,
    /// At the end of their kernel.
    Kernel,
}

pub(super) type Parsed<T> = Result<T, Fault>;

impl<'a> Parser<'a> {
    pub(super) fn peek(&self, ahead: usize) -> Option<&'a Token> {
        self.tokens.get(self.at + ahead)
    }

    pub(super) fn sees(&self, punctuator: &str) -> bool {
        self.peek(0).is_some_and(|t| t.is(punctuator))
    }

    pub(super) fn word(&self, ahead: usize) -> &'a str {
        self.peek(ahead).and_then(Token::name).map_or("", |n| n)
    }

    pub(super) fn take(&mut self, punctuator: &str) -> bool {
        let seen = self.sees(punctuator);
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

    /// What stands between two places.
    pub(super) fn between(&self, from: usize, to: usize) -> std::slice::Iter<'a, Token> {
        self.tokens.get(from..to).unwrap_or_default().iter()
    }

    /// The token so many before the one that comes next.
    pub(super) fn tokens_before(&self, back: usize) -> &'a Token {
        &self.tokens[self.at - back]
    }

    pub(super) fn expect(&mut self, punctuator: &str, help: &str) -> Parsed<Place> {
        let place = self.place();
        if self.take(punctuator) {
            return Ok(place);
        }
        Err(unexpected(
            self.peek(0),
            place,
            &format!("`{punctuator}`"),
            help,
        ))
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
            self.over = Over::At(place);
            return Err(Fault::error(
                place,
                format!("more than {} levels inside each other", 4 * NESTING),
                "too deep",
            )
            .help("take it apart"));
        }
        self.tries += 1;
        if self.tries > TRIES * (self.tokens.len() + NESTING) {
            let place = self.lost.unwrap_or(self.place());
            self.lost = Some(place);
            return Err(too_many_ways(place));
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
        self.over = Over::At(self.place());
        Err(Fault::error(
            self.place(),
            format!("more than {CHAIN} operators, calls or `else if`s in a row"),
            "too many",
        )
        .help("split it up: give names to parts of it, or use a loop"))
    }

    /// Statements up to where they end.
    fn statements(&mut self, until: Until) -> Vec<Stmt> {
        let mut all = Vec::new();
        let (links, mut most) = (self.links, self.links);
        while self.peek(0).is_some() && !enough(&self.faults) && self.over != Over::Told {
            most = most.max(self.links);
            self.links = links;
            if self.sees("}") {
                if until != Until::End {
                    break;
                }
                // Behind a fault it may well close what was not understood.
                if self.faults.is_empty() {
                    let place = self.place();
                    self.faults.push(
                        Fault::error(place, "unmatched `}`", "no block is open").help("remove it"),
                    );
                }
                self.at += 1;
                continue;
            }
            if until == Until::Kernel && (self.ends_kernel() || self.begins_kernel()) {
                break;
            }
            let start = self.at;
            match self.deeper(Self::statement) {
                Ok(statement) => {
                    if self.inner == 0 {
                        all.append(&mut self.library);
                    }
                    all.append(&mut self.pending);
                    if statement.node != StmtNode::Nothing {
                        all.push(statement);
                    }
                }
                // What follows from a limit is no fault.
                Err(_) if self.over == Over::Told => {}
                Err(fault) => {
                    if matches!(self.over, Over::At(it) if it.start == fault.place.start) {
                        self.over = Over::Told;
                    }
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
        self.inner += 1;
        let all = self.open_block();
        self.inner -= 1;
        all
    }

    /// The body of a function.
    fn body(&mut self, name: &Word) -> Parsed<Vec<Stmt>> {
        let outer = std::mem::replace(&mut self.body_of, name.clone());
        let body = self.block();
        self.body_of = outer;
        body
    }

    /// A block of a file, rather than of a function.
    fn open_block(&mut self) -> Parsed<Vec<Stmt>> {
        let open = self.expect("{", "a block is `{ statements }`")?;
        let statements = self.statements(Until::Brace);
        self.declared_twice(&statements);
        if !self.take("}") {
            return Err(Fault::error(open, "this block has no end", "opened here")
                .help("close it with `}`"));
        }
        Ok(statements)
    }

    /// Tells of variables that a block declares a second time.
    fn declared_twice(&mut self, statements: &[Stmt]) {
        let declared = statements.iter().filter_map(|it| match &it.node {
            StmtNode::Declare(all) => Some(all),
            _ => None,
        });
        let mut known = BTreeSet::new();
        for it in declared.flatten().filter(|it| !it.outside) {
            if !known.insert(&it.name) {
                let message = format!("`{}` is declared twice in this block", it.name);
                let fault = Fault::error(it.place, message, "declared again");
                let help = "assign to the first, or give this one another name";
                self.faults.push(fault.help(help));
            }
        }
    }

    fn skip_past(&mut self, punctuator: &str) {
        while let Some(token) = self.peek(0) {
            if token.is("{") {
                self.skip_group();
                continue;
            }
            self.at += 1;
            if token.is(punctuator) {
                return;
            }
        }
    }

    /// From an opening punctuator behind the one that closes it.
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

    pub(super) fn expression(&mut self) -> Parsed<Expr> {
        self.deeper(expression::comma)
    }

    pub(super) fn assignment(&mut self) -> Parsed<Expr> {
        self.deeper(expression::assignment)
    }
}

/// Of a text whose beginnings each fit several things, inside each other.
fn too_many_ways(place: Place) -> Fault {
    let message = "this is too ambiguous to parse".to_owned();
    Fault::error(place, message, "parsing stopped here")
        .help("split it up: give names to the types and values in it")
}

/// A namespace inside of another.
fn within(outer: &str, names: &[&str]) -> String {
    let outer = Some(outer).filter(|it| !it.is_empty());
    let all: Vec<&str> = outer.into_iter().chain(names.iter().copied()).collect();
    all.join("::")
}
