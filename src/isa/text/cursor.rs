//! A cursor over tokens: what is expected, what is found instead, and how to go on after a fault.

use crate::config::{Fault, Place};
use crate::limit::NESTING;

use super::{Argument, Expression, Operator, Statement, Term, Token, TokenKind};

/// A place in a list of tokens.
#[derive(Debug)]
pub struct Cursor<'a> {
    tokens: &'a [Token],
    at: usize,
    depth: usize,
    end: usize,
}

impl<'a> Cursor<'a> {
    /// At the first of these tokens of a text of `length` bytes.
    #[must_use]
    pub const fn new(tokens: &'a [Token], length: usize) -> Self {
        Self {
            tokens,
            at: 0,
            depth: 0,
            end: length,
        }
    }

    /// The token here.
    #[must_use]
    pub fn peek(&self) -> Option<&'a Token> {
        self.tokens.get(self.at)
    }

    /// The token after this one.
    #[must_use]
    pub fn peek_second(&self) -> Option<&'a Token> {
        self.tokens.get(self.at + 1)
    }

    /// Where the token here stands; the end of the text after the last.
    #[must_use]
    pub fn place(&self) -> Place {
        self.peek()
            .map_or(Place::new(self.end, self.end), |t| t.place)
    }

    /// Where the token before this one ended.
    #[must_use]
    pub fn before(&self) -> Place {
        self.at
            .checked_sub(1)
            .and_then(|at| self.tokens.get(at))
            .map_or(Place::new(0, 0), |t| t.place)
    }

    /// Goes to the next token.
    pub const fn advance(&mut self) {
        self.at += 1;
    }

    /// Whether this mark stands here.
    #[must_use]
    pub fn sees(&self, mark: &str) -> bool {
        matches!(self.peek(), Some(Token { kind: TokenKind::Mark(m), .. }) if *m == mark)
    }

    /// Whether this word stands here.
    #[must_use]
    pub fn sees_word(&self, word: &str) -> bool {
        matches!(self.peek(), Some(Token { kind: TokenKind::Name(n), .. }) if n == word)
    }

    /// Takes this mark if it stands here.
    pub fn take(&mut self, mark: &str) -> bool {
        let seen = self.sees(mark);
        self.at += usize::from(seen);
        seen
    }

    /// Takes this word if it stands here.
    pub fn take_word(&mut self, word: &str) -> bool {
        let seen = self.sees_word(word);
        self.at += usize::from(seen);
        seen
    }

    /// Takes this mark.
    ///
    /// # Errors
    /// When something else stands here.
    pub fn expect(&mut self, mark: &str, help: &str) -> Result<Place, Fault> {
        let place = self.place();
        if self.take(mark) {
            return Ok(place);
        }
        Err(self.unexpected(&format!("`{mark}`"), help))
    }

    /// Takes a name.
    ///
    /// # Errors
    /// When something else stands here.
    pub fn name(&mut self, expected: &str, help: &str) -> Result<(String, Place), Fault> {
        if let Some(Token {
            kind: TokenKind::Name(name),
            place,
        }) = self.peek()
        {
            self.at += 1;
            return Ok((name.clone(), *place));
        }
        Err(self.unexpected(expected, help))
    }

    /// The fault that something else was expected here.
    #[must_use]
    pub fn unexpected(&self, expected: &str, help: &str) -> Fault {
        match self.peek() {
            // A semicolon that is missing is missing behind the last word, not before the next.
            Some(_) if expected == "`;`" => {
                let end = self.before().end;
                Fault::error(
                    Place::new(end, end),
                    "expected `;` here",
                    "a statement ends with `;`",
                )
            }
            Some(token) => Fault::error(
                token.place,
                format!("expected {expected}, found {}", describe(&token.kind)),
                format!("expected {expected}"),
            ),
            None => Fault::error(
                self.place(),
                format!("expected {expected}, found the end of the file"),
                format!("expected {expected}"),
            ),
        }
        .help(help)
    }

    /// Parses one nesting level deeper.
    ///
    /// # Errors
    /// When that is too deep.
    pub fn deeper<T>(
        &mut self,
        inner: impl FnOnce(&mut Self) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        self.enter()?;
        let result = inner(self);
        self.leave();
        result
    }

    /// Enters a nesting level; [`Cursor::leave`] leaves it.
    ///
    /// # Errors
    /// When that is too deep.
    pub fn enter(&mut self) -> Result<(), Fault> {
        if self.depth == NESTING {
            return Err(Fault::error(
                self.place(),
                format!("more than {NESTING} levels inside each other"),
                "too deep",
            )
            .help("take it apart"));
        }
        self.depth += 1;
        Ok(())
    }

    /// One level up.
    pub const fn leave(&mut self) {
        self.depth -= 1;
    }

    /// Recovers after a fault: moves behind the next `;`, or to the next brace or what looks like a
    /// statement.
    pub fn recover(&mut self) {
        while let Some(token) = self.peek() {
            let second = self.peek_second().map(|t| &t.kind);
            match token.kind {
                TokenKind::Name(_) if second == Some(&TokenKind::Mark("(")) => return,
                TokenKind::Mark(";") => {
                    self.at += 1;
                    return;
                }
                TokenKind::Mark("{" | "}") => return,
                _ => self.at += 1,
            }
        }
    }

    /// `name(argument, argument);`
    ///
    /// # Errors
    /// What was expected instead of what stands here.
    pub fn statement(&mut self) -> Result<Statement, Fault> {
        const SHAPE: &str = "a statement is `name(argument, argument);`";
        let (name, name_place) = self.name("a statement", SHAPE)?;
        self.expect("(", SHAPE)?;
        let mut arguments = Vec::new();
        if !self.take(")") {
            loop {
                arguments.push(self.argument()?);
                if self.take(")") {
                    break;
                }
                if !self.take(",") {
                    return Err(self.unexpected("`,` or `)`", SHAPE));
                }
            }
        }
        let end = self.expect(";", SHAPE)?;
        Ok(Statement {
            name,
            name_place,
            arguments,
            place: name_place.to(end),
            origin: None,
        })
    }

    fn argument(&mut self) -> Result<Argument, Fault> {
        let start = self.place();
        if !self.take("{") {
            return Ok(Argument::One(self.expression()?));
        }
        let mut items = Vec::new();
        if !self.take("}") {
            loop {
                items.push(self.expression()?);
                if self.take("}") {
                    break;
                }
                if !self.take(",") {
                    return Err(self.unexpected("`,` or `}`", "write `bus({A, B}, {C, D});`"));
                }
            }
        }
        Ok(Argument::Group {
            items,
            place: start.to(self.before()),
        })
    }

    /// A sum of products.
    ///
    /// # Errors
    /// What was expected instead of what stands here.
    pub fn expression(&mut self) -> Result<Expression, Fault> {
        self.binary(
            &[("+", Operator::Add), ("-", Operator::Subtract)],
            |cursor| {
                cursor.binary(
                    &[
                        ("*", Operator::Multiply),
                        ("/", Operator::Divide),
                        ("%", Operator::Remainder),
                    ],
                    Self::term,
                )
            },
        )
    }

    fn binary(
        &mut self,
        operators: &[(&str, Operator)],
        mut operand: impl FnMut(&mut Self) -> Result<Expression, Fault>,
    ) -> Result<Expression, Fault> {
        let mut left = operand(self)?;
        let mut length = 0;
        while let Some(&(_, operator)) = operators.iter().find(|(mark, _)| self.sees(mark)) {
            // A long sum is a deep tree, so its length is limited like nesting.
            length += 1;
            if length > NESTING {
                return Err(self.unexpected("a shorter sum", "take it apart"));
            }
            self.advance();
            let right = operand(self)?;
            let place = left.place.to(right.place);
            let term = Term::Binary {
                operator,
                left: Box::new(left),
                right: Box::new(right),
            };
            left = Expression { term, place };
        }
        Ok(left)
    }

    fn term(&mut self) -> Result<Expression, Fault> {
        const HELP: &str = "a value is a register, a direction, a number or a constant";
        let Some(token) = self.peek() else {
            return Err(self.unexpected("a value", HELP));
        };
        let place = token.place;
        match &token.kind {
            TokenKind::Number(value) => {
                self.advance();
                Ok(Expression {
                    term: Term::Number(*value),
                    place,
                })
            }
            TokenKind::Name(name) => {
                self.advance();
                self.after_name(name.clone(), place)
            }
            TokenKind::Mark("-") => {
                self.advance();
                let inner = self.deeper(Self::term)?;
                let place = place.to(inner.place);
                Ok(Expression {
                    term: Term::Negate(Box::new(inner)),
                    place,
                })
            }
            TokenKind::Mark("(") => {
                self.advance();
                let inner = self.deeper(Self::expression)?;
                let end = self.expect(")", "close the parenthesis")?;
                Ok(Expression {
                    term: inner.term,
                    place: place.to(end),
                })
            }
            _ => Err(self.unexpected("a value", HELP)),
        }
    }

    fn after_name(&mut self, name: String, place: Place) -> Result<Expression, Fault> {
        const HELP: &str = "write `X[dir]`, `X[-dir]` or `R[dir]`";
        if !self.take("[") {
            return Ok(Expression {
                term: Term::Name(name),
                place,
            });
        }
        let opposite = self.take("-");
        let (direction, _) = self.name("the name of a direction", HELP)?;
        let end = self.expect("]", HELP)?;
        let term = Term::Of {
            base: name,
            opposite,
            direction,
        };
        Ok(Expression {
            term,
            place: place.to(end),
        })
    }
}

fn describe(kind: &TokenKind) -> String {
    match kind {
        TokenKind::Name(name) => format!("`{name}`"),
        TokenKind::Number(value) => format!("the number {value}"),
        TokenKind::Quoted(_) => "text in quotes".to_owned(),
        TokenKind::Mark(mark) => format!("`{mark}`"),
        TokenKind::Line(_) | TokenKind::Block(_) => "a comment".to_owned(),
    }
}
