//! Functions that a text declares and does not define: their bodies may lie beside it, under their
//! names, as the vendor's tools build all files of a folder.

use std::{collections::BTreeSet, sync::Arc};

use super::token::{Token, TokenKind, tokens};
use crate::config::Place;

/// The functions that a text declares outside of braces, and does not define.
pub(super) fn undefined(text: &str) -> Vec<(Arc<str>, Place)> {
    let (all, _) = tokens(text, 0);
    let (mut found, mut defined) = (Vec::new(), BTreeSet::new());
    let mut depth = 0_usize;
    for (at, token) in all.iter().enumerate() {
        match token.kind {
            TokenKind::Punctuator("{") => depth += 1,
            TokenKind::Punctuator("}") => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > 0 || !token.is("(") {
            continue;
        }
        let [.., before, name] = &all[..at] else {
            continue;
        };
        // A type stands before the name, on its line.
        let typed = !name.first && (before.name().is_some() || before.is("*") || before.is("&"));
        let (Some(word), true) = (name.name(), typed) else {
            continue;
        };
        match behind(&all[at..]) {
            Some(end) if end.is(";") => found.push((Arc::clone(word), name.place)),
            Some(end) if end.is("{") => {
                defined.insert(Arc::clone(word));
            }
            _ => {}
        }
    }
    found.retain(|(name, _)| !defined.contains(name));
    found
}

/// Whether a text has a `main` of its own: it is another program.
pub(super) fn is_program(text: &str) -> bool {
    let (all, _) = tokens(text, 0);
    let main = |pair: &[Token]| pair[0].name().is_some_and(|it| &**it == "main") && pair[1].is("(");
    all.windows(2).any(main)
}

/// What stands behind the parenthesis that these tokens begin with.
fn behind(tokens: &[Token]) -> Option<&Token> {
    let mut depth = 0_usize;
    for (at, token) in tokens.iter().enumerate() {
        if token.is("(") {
            depth += 1;
        } else if token.is(")") {
            depth -= 1;
            if depth == 0 {
                return tokens.get(at + 1);
            }
        }
    }
    None
}
