//! From text to macros.

use crate::{
    config::{Fault, suggestion_or},
    isa::{
        Evidence, Signature,
        text::{Cursor, Token, TokenKind, lex},
    },
    limit::{FAULTS, MACRO_STATEMENTS, MACROS},
};

use super::definition::{Distinct, Item, Macro};

/// Reads a file of macros.
///
/// # Errors
/// All faults of the file.
pub fn parse(text: &str) -> Result<Vec<Macro>, Vec<Fault>> {
    let (tokens, mut faults) = lex(text);
    let (comments, tokens): (Vec<Token>, Vec<Token>) = tokens
        .into_iter()
        .partition(|t| matches!(t.kind, TokenKind::Line(_) | TokenKind::Block(_)));
    let mut cursor = Cursor::new(&tokens, text.len());
    let mut macros: Vec<Macro> = Vec::new();
    let mut end = 0;
    while cursor.peek().is_some() {
        let start = cursor.place().start;
        match read(&mut cursor) {
            Ok(mut it) => {
                it.doc = doc(&comments, end, start);
                macros.push(it);
            }
            Err(fault) => {
                faults.push(fault);
                if faults.len() > FAULTS {
                    return Err(faults);
                }
                // The next macro begins with a word of its own.
                while cursor.peek().is_some()
                    && !cursor.sees_word("macro")
                    && !cursor.sees_word("host")
                {
                    cursor.advance();
                }
            }
        }
        end = cursor.before().end;
    }
    let mut statements = 0;
    for (at, it) in macros.iter().enumerate() {
        statements += length(&it.body);
        let place = it.signature.place;
        if at == MACROS || statements > MACRO_STATEMENTS {
            let (what, most) = if at == MACROS {
                ("macros", MACROS)
            } else {
                ("statements", MACRO_STATEMENTS)
            };
            faults.push(
                Fault::error(
                    place,
                    format!("a chip has {most} {what} at most"),
                    "this macro",
                )
                .help("leave out what no program uses"),
            );
            return Err(faults);
        }
        if it.doc.is_empty() {
            faults.push(
                Fault::error(
                    place,
                    format!("`{}` is not explained", it.signature.name),
                    "this macro",
                )
                .help("write what it does in a comment `/// …` above it"),
            );
        }
    }
    if faults.is_empty() {
        Ok(macros)
    } else {
        Err(faults)
    }
}

/// Statements of a body.
fn length(body: &[Item]) -> usize {
    let one = |item: &Item| match item {
        Item::Statement(_) => 1,
        Item::Repeat { body, .. } => length(body),
    };
    body.iter().map(one).sum()
}

/// The `///` comments between two places.
fn doc(comments: &[Token], from: usize, to: usize) -> String {
    let lines = comments.iter().filter_map(|c| match &c.kind {
        TokenKind::Line(text) if (from..to).contains(&c.place.start) => text.strip_prefix('/'),
        _ => None,
    });
    lines.map(str::trim).collect::<Vec<_>>().join("\n")
}

fn read(cursor: &mut Cursor<'_>) -> Result<Macro, Fault> {
    const HELP: &str = "a macro is `macro name(parameters) { statements }`";
    let host = cursor.take_word("host");
    if !cursor.take_word("macro") {
        return Err(cursor.unexpected("`macro`", HELP));
    }
    let signature = Signature::read(cursor)?;
    let mut it = Macro {
        doc: String::new(),
        signature,
        origin: String::new(),
        host,
        gives: Vec::new(),
        whole_flag: false,
        distinct: Vec::new(),
        evidence: None,
        body: Vec::new(),
    };
    while !cursor.sees("{") {
        clause(cursor, &mut it)?;
    }
    it.body = body(cursor)?;
    Ok(it)
}

fn clause(cursor: &mut Cursor<'_>, it: &mut Macro) -> Result<(), Fault> {
    const HELP: &str = "before its body a macro can say `gives R12`, `needs FLAG`, \
                        `distinct y, x \"why\"` and `evidence guess \"source\"`";
    if cursor.take_word("gives") {
        loop {
            it.gives.push(cursor.name("a register", HELP)?.0);
            if !cursor.take(",") {
                break;
            }
        }
    } else if cursor.take_word("needs") {
        let (name, place) = cursor.name("FLAG", HELP)?;
        if name != "FLAG" {
            return Err(Fault::error(place, "only FLAG can be needed", "not FLAG").help(HELP));
        }
        it.whole_flag = true;
    } else if cursor.take_word("distinct") {
        let (first, _) = cursor.name("a parameter", HELP)?;
        cursor.expect(",", HELP)?;
        let (second, _) = cursor.name("a parameter", HELP)?;
        let reason = quoted(cursor, "the reason in quotes", HELP)?;
        it.distinct.push(Distinct {
            first,
            second,
            reason,
        });
    } else if cursor.take_word("evidence") {
        let (name, place) = cursor.name("measured, quoted, modelled or guess", HELP)?;
        let Some(evidence) = Evidence::ALL.into_iter().find(|it| it.word() == name) else {
            let otherwise = "evidence is measured, quoted, modelled or guess";
            return Err(
                Fault::error(place, format!("unknown evidence `{name}`"), "here")
                    .help(suggestion_or(&name, Evidence::WORDS, otherwise)),
            );
        };
        it.evidence = Some((evidence, quoted(cursor, "the source in quotes", HELP)?));
    } else {
        return Err(cursor.unexpected("`{`", HELP));
    }
    Ok(())
}

fn quoted(cursor: &mut Cursor<'_>, expected: &str, help: &str) -> Result<String, Fault> {
    let Some(Token {
        kind: TokenKind::Quoted(text),
        ..
    }) = cursor.peek()
    else {
        return Err(cursor.unexpected(expected, help));
    };
    cursor.advance();
    Ok(text.clone())
}

fn body(cursor: &mut Cursor<'_>) -> Result<Vec<Item>, Fault> {
    cursor.expect("{", "a body is `{ statements }`")?;
    let mut items = Vec::new();
    while !cursor.take("}") {
        if cursor.take_word("repeat") {
            let times = cursor.expression()?;
            let body = cursor.deeper(body)?;
            items.push(Item::Repeat { times, body });
        } else {
            items.push(Item::Statement(cursor.statement()?));
        }
    }
    Ok(items)
}
