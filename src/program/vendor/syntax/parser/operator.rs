//! Names of operators that a file defines.

use super::Parser;
use crate::program::vendor::{lexer::token::TokenKind, syntax::tree::Word};

/// Operators that can be defined, but for `()` and `[]`.
const OPERATORS: [&str; 30] = [
    "+", "-", "*", "/", "%", "&", "|", "^", "~", "!", "<", ">", "<=", ">=", "==", "!=", "<<", ">>",
    "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>=", "++", "--",
];

impl Parser<'_> {
    /// What stands behind `operator`, up to the parameters; nothing where it is not supported.
    pub(super) fn operator_name(&mut self) -> Option<Word> {
        let TokenKind::Punctuator(first) = self.peek(0)?.kind else {
            return None;
        };
        let closed = |close: &str| self.peek(1).is_some_and(|t| t.is(close));
        let (name, length) = match first {
            "(" if closed(")") => ("()", 2),
            "[" if closed("]") => ("[]", 2),
            "=" => ("=", 1),
            first if OPERATORS.contains(&first) => (first, 1),
            _ => return None,
        };
        let called = self.peek(length).is_some_and(|t| t.is("("));
        self.at += if called { length } else { 0 };
        called.then(|| format!("operator{name}").into())
    }
}
