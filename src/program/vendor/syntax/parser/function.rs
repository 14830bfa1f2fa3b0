//! Functions and their parameters.

use std::rc::Rc;

use super::{
    Parsed, Parser,
    declaration::Pointed,
    expression::unexpected,
    types::{QUALIFIERS, Type, kind_of},
    within,
};
use crate::{
    config::Place,
    program::vendor::{
        lexer::token::{Token, TokenKind},
        syntax::tree::{Expr, ExprNode, Function, Kind, Parameter, StmtNode, Word},
    },
};

impl<'a> Parser<'a> {
    /// A function with its body, or a prototype, if one of them stands here.
    pub(super) fn function(
        &mut self,
        name: &Word,
        place: Place,
        returns: &Type,
        qualified: &[&str],
    ) -> Parsed<Option<StmtNode>> {
        let space: Word = within(&self.space, qualified).into();
        let qualified = !qualified.is_empty();
        let start = self.at;
        self.skip_group();
        self.skip_specifiers();
        self.arrow();
        self.skip_specifiers();
        let (body, prototype) = (
            self.sees("{") || self.sees(":"),
            self.sees(";") || self.no_body(),
        );
        self.at = start;
        if !(body || prototype && self.looks_like_parameters()) {
            return Ok(None);
        }
        self.at += 1;
        let parameters = self.parameters()?;
        let constant = self.word(0) == "const";
        self.skip_specifiers();
        let arrow = self.arrow();
        let returns = arrow.as_ref().unwrap_or(returns);
        if !self.template.is_empty() {
            self.templates.insert(name.clone());
        }
        let (gives, element) = returns.classes();
        let mut it = Function {
            gives,
            element,
            space,
            parameters: parameters.into(),
            qualified,
            returns: returns.value_kind(),
            refers: returns.refers(),
            constant,
            template: self.template.clone(),
            ..Function::new(name.clone(), place)
        };
        self.skip_specifiers();
        if self.no_body() || self.take(";") {
            self.take(";");
            return Ok(Some(StmtNode::Prototype(Rc::new(it))));
        }
        while self.peek(0).is_some() && !self.sees("{") {
            self.at += 1;
        }
        let body = if std::mem::take(&mut self.in_class) {
            self.member_body(name)
        } else {
            self.body(name)?
        };
        it.body = body.into();
        Ok(Some(StmtNode::Function(Rc::new(it))))
    }

    /// Over words behind the parameters that say nothing about what runs.
    fn skip_specifiers(&mut self) {
        let word =
            |it: &str| QUALIFIERS.contains(&it) || matches!(it, "override" | "final" | "noexcept");
        while word(self.word(0)) {
            self.at += 1;
        }
    }

    /// Over `= 0`, `= default` and `= delete`, if one of them stands here.
    pub(super) fn no_body(&mut self) -> bool {
        let zero = |t: &Token| matches!(t.kind, TokenKind::Whole(0));
        let none = matches!(self.word(1), "default" | "delete") || self.peek(1).is_some_and(zero);
        let found = self.sees("=") && none && self.peek(2).is_some_and(|t| t.is(";"));
        self.at += if found { 2 } else { 0 };
        found
    }

    /// `-> type` behind the parameters.
    fn arrow(&mut self) -> Option<Type> {
        if !self.take("->") {
            return None;
        }
        if self.take_word("decltype") {
            // Of the type of what it gives back.
            self.skip_group();
            return Some(Type::default());
        }
        self.read_cast()
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

    pub(super) fn word_before(&self) -> &'a str {
        let before = self.at.checked_sub(1).and_then(|at| self.tokens.get(at));
        before.and_then(Token::name).map_or("", |n| n)
    }

    /// Parameters up to `)`.
    pub(in crate::program::vendor) fn parameters(&mut self) -> Parsed<Vec<Parameter>> {
        const HELP: &str = "a function is `type name(type parameter) { … }`";
        let mut all = Vec::new();
        while !self.take(")") {
            if self.take("...") {
                continue;
            }
            let start = self.at;
            let Some(it) = self.read_type() else {
                return Err(unexpected(self.peek(0), self.place(), "a type", HELP));
            };
            let written = self.spelled(start, &it);
            let says = |word: &&str| {
                !matches!(
                    *word,
                    "const" | "volatile" | "struct" | "class" | "union" | "enum"
                )
            };
            let mut written: String = written.split(' ').filter(says).collect();
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
            let named = |it: &Option<Expr>| match it.as_ref().map(|it| &it.node) {
                Some(ExprNode::Name(name)) => name.clone(),
                _ => "".into(),
            };
            let mut extents: Vec<Word> = Vec::new();
            if it.library {
                extents.extend(it.lengths.iter().map(named));
            }
            while self.take("[") {
                written.push('*');
                array = true;
                if alias {
                    extents.push(self.word(0).into());
                }
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
                    of: if called || it.library {
                        "".into()
                    } else {
                        it.name.clone()
                    },
                    element: if it.library { it.name } else { "".into() },
                    written: written.into(),
                    pointee: it.kind,
                    alias: it.reference,
                    reference: it.reference && !it.constant && !called || alias,
                    pointer: it.pointer && !called || array,
                    extents,
                    default,
                });
            }
            if !self.take(",") && !self.sees(")") {
                return Err(unexpected(self.peek(0), self.place(), "`,` or `)`", HELP));
            }
        }
        Ok(all)
    }
}
