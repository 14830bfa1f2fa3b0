//! Templates: their parameters, and what stands in `<…>`.

use super::super::{
    expression::{self},
    token::{Kind as TokenKind, Token},
    tree::{Kind, TemplateArgument, TemplateParameter},
};
use super::{Parsed, Parser};

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
