//! Classes of the language's library that are made for the types they are given: pairs, tuples, maps.

use std::rc::Rc;

use super::{Parser, types::Type};
use crate::{
    config::Fault,
    program::vendor::{
        lexer::token::{Token, TokenKind},
        syntax::tree::{Declared, Stmt, StmtNode, Struct, Word},
    },
};

/// Those that are followed.
const CONTAINERS: [&str; 4] = ["pair", "tuple", "map", "unordered_map"];

/// Characters of the name of such a class, with the types that it is given: those of types inside
/// each other double.
const NAME: usize = 4096;

impl Parser<'_> {
    /// The class that `name<types>` is, from the `<` on; nothing, and no step ahead, where it is
    /// none of these.
    pub(in crate::program::vendor) fn container(&mut self, name: &str) -> Option<Word> {
        if !CONTAINERS.contains(&name) || !self.sees("<") {
            return None;
        }
        let (start, half) = (self.at, self.half);
        let found = self.container_of(name);
        if found.is_none() {
            (self.at, self.half) = (start, half);
        }
        found
    }

    fn container_of(&mut self, name: &str) -> Option<Word> {
        let place = self.place();
        self.at += 1;
        let (mut types, mut words) = (Vec::new(), Vec::new());
        loop {
            let start = self.at;
            let it = self.deeper(|it| Ok(it.read_type())).ok()??;
            words.push(self.spelled(start, &it));
            types.push(it);
            if !self.take(",") {
                break;
            }
        }
        if !self.close_angle() || name != "tuple" && types.len() != 2 {
            return None;
        }
        let full: Word = format!("{name}<{}>", words.join(", ")).into();
        if full.len() > NAME {
            let fault = Fault::error(
                place,
                format!("nested types with a name of more than {NAME} characters"),
                "this type",
            );
            let known = |it: &Fault| it.place.start == place.start;
            if !self.faults.iter().any(known) {
                self.faults
                    .push(fault.help("make it a `struct` of its own, with fewer members"));
            }
            return None;
        }
        if !self.classes.insert(full.clone()) {
            return Some(full);
        }
        let members = types.iter().enumerate().map(|(at, of)| {
            let name: Word = match (name, at) {
                ("tuple", at) => at.to_string().into(),
                (_, 0) => "first".into(),
                _ => "second".into(),
            };
            Declared {
                constant: false,
                ..of.declares(name, place)
            }
        });
        let node = StmtNode::Struct(Rc::new(Struct {
            name: full.clone(),
            members: members.collect(),
            functions: Vec::new(),
            base: None,
            space: full.clone(),
            map: name.ends_with("map"),
            unread: None,
            stops: None,
        }));
        self.library.push(Stmt { node, place });
        Some(full)
    }

    /// A type as it was written, without the namespaces between which `::` stands.
    pub(super) fn spelled(&self, start: usize, it: &Type) -> String {
        if it.name.contains('<') {
            let array = if it.library { "vector of " } else { "" };
            return format!("{array}{}", it.name);
        }
        let tokens = self.tokens.get(start..self.at).unwrap_or_default();
        let word = |token: &Token| match &token.kind {
            TokenKind::Name(name) => name.to_string(),
            TokenKind::Whole(value) => value.to_string(),
            TokenKind::Punctuator("::") => ".".to_owned(),
            TokenKind::Punctuator(other) => (*other).to_owned(),
            _ => String::new(),
        };
        let words: Vec<String> = tokens.iter().map(word).collect();
        words.join(" ").replace(" . ", ".")
    }
}
