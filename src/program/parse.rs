//! Parsing text to a tree. It recovers after a fault, so that all faults of a file are reported.

use super::syntax::{Comment, Item, Node, Syntax};
use crate::{
    config::{Fault, Place},
    isa::text::{Cursor, Token, TokenKind, lex},
    limit::FAULTS,
};

/// The tree of a text, and what is wrong with the text. Lines of settings and expectation
/// come with the byte at which they begin.
pub(super) struct Parsed {
    pub syntax: Syntax,
    pub header_at: Vec<usize>,
    pub footer_at: Vec<usize>,
    pub faults: Vec<Fault>,
}

/// Parses a text.
pub(super) fn parse(text: &str) -> Parsed {
    let (tokens, mut faults) = lex(text);
    let (comments, tokens): (Vec<Token>, Vec<Token>) = tokens
        .into_iter()
        .partition(|t| matches!(t.kind, TokenKind::Line(_) | TokenKind::Block(_)));
    let first = tokens.first().map_or(text.len(), |t| t.place.start);
    let last = tokens.last().map_or(0, |t| t.place.end);
    let (mut syntax, mut plain) = (Syntax::default(), Vec::new());
    let (mut header_at, mut footer_at) = (Vec::new(), Vec::new());
    for token in comments {
        let Place { start, .. } = token.place;
        match &token.kind {
            TokenKind::Line(line) if line.starts_with('!') => {
                syntax.header.push(line[1..].to_owned());
                header_at.push(start + 3);
                if start > first {
                    faults.push(
                        Fault::error(token.place, "settings stand at the top", "this line")
                            .help("move the `//!` lines above the first statement"),
                    );
                }
            }
            TokenKind::Line(line) if line.starts_with('=') => {
                syntax.footer.push(line[1..].to_owned());
                footer_at.push(start + 3);
                if start < last {
                    faults.push(
                        Fault::error(
                            token.place,
                            "the expectation stands at the bottom",
                            "this line",
                        )
                        .help("move the `//=` lines below the last statement"),
                    );
                }
            }
            _ => plain.push(token),
        }
    }
    let mut parser = Parser {
        cursor: Cursor::new(&tokens, text.len()),
        comments: &plain,
        text,
        faults,
        end: 0,
    };
    syntax.items = parser.items(Level::Top);
    Parsed {
        syntax,
        header_at,
        footer_at,
        faults: parser.faults,
    }
}

/// Where an item stands, which decides what it may be.
#[derive(Clone, Copy, PartialEq)]
enum Level {
    Top,
    Block,
}

struct Parser<'a> {
    cursor: Cursor<'a>,
    /// Comments not yet attached to an item.
    comments: &'a [Token],
    text: &'a str,
    faults: Vec<Fault>,
    /// Where the item before ended.
    end: usize,
}

impl Parser<'_> {
    fn items(&mut self, level: Level) -> Vec<Item> {
        let mut items: Vec<Item> = Vec::new();
        loop {
            self.comments_before(self.cursor.place().start, &mut items);
            if self.cursor.peek().is_none() || self.faults.len() > FAULTS {
                return items;
            }
            if self.cursor.sees("}") {
                if level == Level::Block {
                    return items;
                }
                let place = self.cursor.place();
                self.faults.push(
                    Fault::error(place, "this `}` closes nothing", "no block is open")
                        .help("remove it"),
                );
                self.cursor.advance();
                continue;
            }
            let start = self.cursor.place().start;
            let blank = !items.is_empty() && self.blank_before(start);
            match self.node(level) {
                Ok(node) => {
                    let place = Place::new(start, self.cursor.before().end);
                    let item = self.item(node, place, blank);
                    items.push(item);
                }
                Err(fault) => {
                    self.faults.push(fault);
                    self.cursor.recover();
                    // Tokens that cannot begin an item are skipped.
                    if self.cursor.place().start == start {
                        self.cursor.advance();
                    }
                }
            }
        }
    }

    /// Whether a blank line lies between the last thing and this place.
    fn blank_before(&self, start: usize) -> bool {
        let between = self.text.get(self.end..start).unwrap_or_default();
        between.matches('\n').count() > 1
    }

    fn item(&mut self, node: Node, place: Place, blank_before: bool) -> Item {
        // A comment inside a statement ends before the statement does.
        self.end = self.end.max(place.end);
        let is_comment = matches!(node, Node::Comment(_));
        Item {
            node,
            blank_before,
            trailing: if is_comment { None } else { self.trailing() },
            place,
        }
    }

    /// The comment behind the last thing on the same line.
    fn trailing(&mut self) -> Option<Comment> {
        let (token, rest) = self.comments.split_first()?;
        let between = self.text.get(self.end..token.place.start)?;
        if between.contains('\n') || token.place.start > self.cursor.place().start {
            return None;
        }
        self.comments = rest;
        self.end = token.place.end;
        Some(comment(token))
    }

    /// Comments up to a place become items.
    fn comments_before(&mut self, place: usize, items: &mut Vec<Item>) {
        while let Some((token, rest)) = self.comments.split_first() {
            if token.place.start >= place && self.cursor.peek().is_some() {
                return;
            }
            self.comments = rest;
            let blank = !items.is_empty() && self.blank_before(token.place.start);
            let item = self.item(Node::Comment(comment(token)), token.place, blank);
            items.push(item);
        }
    }

    fn node(&mut self, level: Level) -> Result<Node, Fault> {
        let second = self.cursor.peek_second().map(|t| &t.kind);
        let block = second == Some(&TokenKind::Mark("{"));
        if self.cursor.sees_word("const") {
            return self.constant(level);
        }
        if self.cursor.sees_word("repeat") {
            self.cursor.advance();
            let times = self.cursor.expression()?;
            let body = self.block()?;
            return Ok(Node::Repeat { times, body });
        }
        for (word, make) in [("init", Node::Init as fn(_) -> _), ("frame", Node::Frame)] {
            if self.cursor.sees_word(word) && block {
                let place = self.cursor.place();
                self.cursor.advance();
                if level != Level::Top {
                    self.faults.push(
                        Fault::error(place, format!("`{word}` inside a block"), "this block")
                            .help("`init` and `frame` stand at the top level"),
                    );
                }
                return Ok(make(self.block()?));
            }
        }
        self.cursor.statement().map(Node::Statement)
    }

    fn constant(&mut self, level: Level) -> Result<Node, Fault> {
        const HELP: &str = "a constant is `const name = value;`";
        let place = self.cursor.place();
        self.cursor.advance();
        if level != Level::Top {
            self.faults.push(
                Fault::error(place, "a constant inside a block", "this one")
                    .help("constants stand at the top level"),
            );
        }
        let (name, name_place) = self.cursor.name("the name of a constant", HELP)?;
        self.cursor.expect("=", HELP)?;
        let value = self.cursor.expression()?;
        self.cursor.expect(";", HELP)?;
        Ok(Node::Const {
            name,
            name_place,
            value,
        })
    }

    fn block(&mut self) -> Result<Vec<Item>, Fault> {
        let start = self.cursor.expect("{", "a block is `{ statements }`")?;
        self.end = start.end;
        let items = self.nested()?;
        if !self.cursor.take("}") {
            return Err(Fault::error(start, "this block has no end", "opened here")
                .help("close it with `}`"));
        }
        Ok(items)
    }

    fn nested(&mut self) -> Result<Vec<Item>, Fault> {
        self.cursor.enter()?;
        let items = self.items(Level::Block);
        self.cursor.leave();
        Ok(items)
    }
}

fn comment(token: &Token) -> Comment {
    match &token.kind {
        TokenKind::Line(text) => Comment::Line(text.clone()),
        TokenKind::Block(text) => Comment::Block(text.clone()),
        // Only comments are kept in the list of comments.
        _ => Comment::Line(String::new()),
    }
}
