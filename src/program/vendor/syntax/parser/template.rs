//! Templates: their parameters, and what stands in `<…>`.

use super::{Parsed, Parser, expression};
use crate::program::vendor::{
    lexer::token::{Token, TokenKind},
    syntax::tree::{Kind, TemplateArgument, TemplateParameter},
};

impl Parser<'_> {
    /// What stands in `template <…>`.
    pub(super) fn template_parameters(&mut self) -> Parsed<Vec<TemplateParameter>> {
        let start = self.at;
        if let Some(all) = self.read_template()? {
            return Ok(all);
        }
        self.at = start;
        self.angles();
        Ok(Vec::new())
    }

    /// Passes a function whose template takes any number of types, if one stands here behind
    /// `template`: a call of it is refused.
    pub(super) fn variadic_function(&mut self) -> bool {
        let start = self.at;
        let mut depth = 0_i32;
        while let Some(token) = self.peek(0) {
            self.at += 1;
            depth += i32::from(token.is("<")) - i32::from(token.is(">"));
            depth -= 2 * i32::from(token.is(">>"));
            if depth <= 0 || token.is("{") || token.is(";") {
                break;
            }
        }
        let mut parameters = self.between(start, self.at);
        if depth > 0 || !parameters.any(|token| token.is("...")) {
            self.at = start;
            return false;
        }
        let behind = self.at;
        let ends = |token: &Token| ["(", "{", ";", "="].iter().any(|it| token.is(it));
        while self.peek(0).is_some_and(|token| !ends(token)) {
            self.at += 1;
        }
        let name = self.between(behind, self.at).last().and_then(Token::name);
        let (Some(name), true) = (name.cloned(), self.sees("(")) else {
            self.at = start;
            return false;
        };
        self.variadic.insert(name);
        while self
            .peek(0)
            .is_some_and(|token| !token.is("{") && !token.is(";"))
        {
            self.at += 1;
        }
        if self.sees("{") {
            self.skip_group();
        } else {
            self.at += 1;
        }
        true
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
    pub(in crate::program::vendor) fn template_argument(&mut self) -> Parsed<TemplateArgument> {
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
    pub(in crate::program::vendor) fn close_angle(&mut self) -> bool {
        if self.sees(">>") {
            self.at += usize::from(self.half);
            self.half = !self.half;
            return true;
        }
        self.take(">")
    }

    /// `<…>`, if it stands here and is closed.
    pub(in crate::program::vendor) fn angles(&mut self) -> bool {
        if !self.sees("<") {
            return false;
        }
        let start = self.at;
        let mut depth = 0_i32;
        while let Some(token) = self.peek(0) {
            self.at += 1;
            match token.kind {
                TokenKind::Punctuator("<") => depth += 1,
                TokenKind::Punctuator(">") => depth -= 1,
                TokenKind::Punctuator(">>") => depth -= 2,
                TokenKind::Punctuator("(" | ")" | "[" | "]" | "," | "::" | "*" | "&")
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
}
