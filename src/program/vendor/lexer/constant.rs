//! Whole-number constants of `#if`.

use super::token::{Token, TokenKind};
use crate::program::vendor::syntax::parser::expression::LEVELS;

/// The value of an expression; names are 0. `None` where it is no expression.
pub(super) fn value(tokens: &[Token]) -> Option<i64> {
    let mut at = At { tokens, depth: 0 };
    let value = at.binary(0)?;
    at.tokens.is_empty().then_some(value)
}

struct At<'a> {
    tokens: &'a [Token],
    depth: usize,
}

impl At<'_> {
    fn take(&mut self, operators: &[&'static str]) -> Option<&'static str> {
        let operator = *operators
            .iter()
            .find(|operator| self.tokens.first().is_some_and(|t| t.is(operator)))?;
        self.tokens = &self.tokens[1..];
        Some(operator)
    }

    fn binary(&mut self, level: usize) -> Option<i64> {
        let Some(operators) = LEVELS.get(level) else {
            return self.unary();
        };
        let mut left = self.binary(level + 1)?;
        while let Some(operator) = self.take(operators) {
            let right = self.binary(level + 1)?;
            left = apply(operator, left, right)?;
        }
        Some(left)
    }

    fn unary(&mut self) -> Option<i64> {
        self.depth += 1;
        if self.depth > 64 {
            return None;
        }
        if let Some(operator) = self.take(&["!", "-", "+", "~"]) {
            let value = self.unary()?;
            return Some(match operator {
                "!" => i64::from(value == 0),
                "-" => value.wrapping_neg(),
                "~" => !value,
                _ => value,
            });
        }
        if self.take(&["("]).is_some() {
            let value = self.binary(0)?;
            self.take(&[")"])?;
            return Some(value);
        }
        let (first, rest) = self.tokens.split_first()?;
        self.tokens = rest;
        match &first.kind {
            TokenKind::Whole(value) | TokenKind::Character(value) | TokenKind::Wide(value, _) => {
                Some(*value)
            }
            TokenKind::Name(name) => Some(i64::from(&**name == "true")),
            _ => None,
        }
    }
}

/// Arithmetic on whole numbers as C++ has it; `None` where it has none.
pub(in crate::program::vendor) fn apply(operator: &str, left: i64, right: i64) -> Option<i64> {
    Some(match operator {
        "||" => i64::from(left != 0 || right != 0),
        "&&" => i64::from(left != 0 && right != 0),
        "|" => left | right,
        "^" => left ^ right,
        "&" => left & right,
        "==" => i64::from(left == right),
        "!=" => i64::from(left != right),
        "<=" => i64::from(left <= right),
        ">=" => i64::from(left >= right),
        "<" => i64::from(left < right),
        ">" => i64::from(left > right),
        "<<" => left.checked_shl(u32::try_from(right).ok()?)?,
        ">>" => left.checked_shr(u32::try_from(right).ok()?)?,
        "+" => left.wrapping_add(right),
        "-" => left.wrapping_sub(right),
        "*" => left.wrapping_mul(right),
        "/" => left.checked_div(right)?,
        "%" => left.checked_rem(right)?,
        _ => return None,
    })
}
