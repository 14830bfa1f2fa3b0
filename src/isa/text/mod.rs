//! The vendor's way of writing: `name(argument, argument);`.
//!
//! Macros of a chip and programs of a user are the same kind of text, so the tokens, the
//! expressions and the statements live here, below both; places and faults are of [`crate::config`].

mod cursor;
mod expression;
mod lex;

pub use cursor::Cursor;
pub use expression::{Argument, Expression, Operator, Statement, Term};
pub use lex::{Token, TokenKind, lex};
