//! Words of the text: names, numbers, marks, comments, each with its place.

use winnow::{
    Parser,
    ascii::{digit1, hex_digit1},
    combinator::{alt, opt, preceded},
    stream::{AsChar, Location, Stream},
    token::{any, one_of, take_till, take_while},
};

use crate::config::{Fault, Place};
use crate::limit::FAULTS;

/// One word of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Where it stands.
    pub place: Place,
}

/// What a word is.
#[derive(Clone, Debug, PartialEq)]
pub enum TokenKind {
    /// A name: letter or `_`, then letters, digits, `_`.
    Name(String),
    /// A number, never negative: the sign is a mark of its own.
    Number(f64),
    /// Text between double quotes, without them.
    Quoted(String),
    /// One of `( ) { } [ ] , ; = + - * / % :` or `..`.
    Mark(&'static str),
    /// A comment up to the end of the line, without `//` and without trailing blanks.
    Line(String),
    /// A comment between `/*` and `*/`, without them.
    Block(String),
}

const MARKS: [&str; 16] = [
    "..", "(", ")", "{", "}", "[", "]", ",", ";", "=", "+", "-", "*", "/", "%", ":",
];

type Input<'a> = winnow::LocatingSlice<&'a str>;
type Result<T> = winnow::ModalResult<T>;

/// Cuts a text into tokens; what is no token becomes a fault and is passed over.
#[must_use]
pub fn lex(text: &str) -> (Vec<Token>, Vec<Fault>) {
    let mut input = Input::new(text);
    let (mut tokens, mut faults) = (Vec::new(), Vec::new());
    loop {
        let _: Result<&str> = take_while(0.., is_blank).parse_next(&mut input);
        let start = input.current_token_start();
        if input.is_empty() {
            return (tokens, faults);
        }
        let kind = token(&mut input);
        let place = Place::new(start, input.current_token_start());
        match kind {
            Ok(Ok(kind)) => tokens.push(Token { kind, place }),
            Ok(Err(fault)) => {
                faults.push(Fault { place, ..fault });
                if faults.len() > FAULTS {
                    return (tokens, faults);
                }
                // A number all the same, so that the statement around it is not a fault too.
                if text[start..].starts_with(|c: char| c.is_ascii_digit()) {
                    let kind = TokenKind::Number(0.0);
                    tokens.push(Token { kind, place });
                }
            }
            // `token` takes any character, so it cannot fail before the end of the text.
            Err(_) => return (tokens, faults),
        }
    }
}

/// A byte order mark counts as blank: some editors leave one.
fn is_blank(c: char) -> bool {
    c.is_whitespace() || c == '\u{feff}'
}

fn token(input: &mut Input<'_>) -> Result<std::result::Result<TokenKind, Fault>> {
    alt((comment, quoted, number, name.map(Ok), mark.map(Ok), unknown)).parse_next(input)
}

fn comment(input: &mut Input<'_>) -> Result<std::result::Result<TokenKind, Fault>> {
    let line = preceded("//", take_till(0.., '\n'))
        .map(|text: &str| Ok(TokenKind::Line(text.trim_end().to_owned())));
    alt((line, block)).parse_next(input)
}

fn block(input: &mut Input<'_>) -> Result<std::result::Result<TokenKind, Fault>> {
    "/*".parse_next(input)?;
    let rest: &str = input.as_ref();
    if let Some(end) = rest.find("*/") {
        let text = input.next_slice(end).to_owned();
        "*/".parse_next(input)?;
        return Ok(Ok(TokenKind::Block(text)));
    }
    let _ = input.next_slice(rest.len());
    Ok(Err(Fault::error(
        Place::default(),
        "a comment without an end",
        "begins here",
    )
    .help("close it with `*/`")))
}

fn quoted(input: &mut Input<'_>) -> Result<std::result::Result<TokenKind, Fault>> {
    let text: &str = preceded('"', take_till(0.., ['"', '\n'])).parse_next(input)?;
    if opt('"').parse_next(input)?.is_some() {
        return Ok(Ok(TokenKind::Quoted(text.to_owned())));
    }
    Ok(Err(Fault::error(
        Place::default(),
        "text in quotes without an end",
        "begins here",
    )
    .help("close it with `\"` on the same line")))
}

fn is_letter(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

fn name(input: &mut Input<'_>) -> Result<TokenKind> {
    (
        one_of(|c: char| c.is_ascii_alphabetic() || c == '_'),
        take_while(0.., is_letter),
    )
        .take()
        .map(|text: &str| TokenKind::Name(text.to_owned()))
        .parse_next(input)
}

fn number(input: &mut Input<'_>) -> Result<std::result::Result<TokenKind, Fault>> {
    let exponent = || (one_of(['e', 'E']), opt(one_of(['+', '-'])), digit1);
    // `1..4` is a range, not the number `1.`
    let fraction = || {
        (
            '.',
            winnow::combinator::not('.'),
            take_while(0.., AsChar::is_dec_digit),
        )
    };
    let hexadecimal = preceded(("0", one_of(['x', 'X'])), hex_digit1)
        .map(|digits: &str| u64::from_str_radix(digits, 16).ok().map(|n| n as f64));
    let decimal = alt((
        (digit1, opt(fraction()), opt(exponent())).take(),
        ('.', digit1, opt(exponent())).take(),
    ))
    .map(|text: &str| text.parse::<f64>().ok());
    let value: Option<f64> = alt((hexadecimal, decimal)).parse_next(input)?;
    // `1.5f` and `3u` are the vendor's language as well; `12abc` is a slip.
    let tail: &str = take_while(0.., is_letter).parse_next(input)?;
    Ok(match value {
        Some(value) if value.is_finite() && matches!(tail, "" | "f" | "F" | "u" | "U") => {
            Ok(TokenKind::Number(value))
        }
        _ => Err(Fault::error(
            Place::default(),
            "this is not a number",
            "letters or digits that do not belong here",
        )
        .help("write numbers as 10, 2.5, 1e3 or 0x1f, and begin names with a letter")),
    })
}

fn mark(input: &mut Input<'_>) -> Result<TokenKind> {
    for mark in MARKS {
        if opt(mark).parse_next(input)?.is_some() {
            return Ok(TokenKind::Mark(mark));
        }
    }
    winnow::combinator::fail.parse_next(input)
}

fn unknown(input: &mut Input<'_>) -> Result<std::result::Result<TokenKind, Fault>> {
    any.map(|c: char| {
        Err(Fault::error(
            Place::default(),
            format!("`{}` has no meaning here", c.escape_debug()),
            "this character",
        )
        .help("statements are `name(argument, argument);`, comments `// …` or `/* … */`"))
    })
    .parse_next(input)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<TokenKind> {
        let (tokens, faults) = lex(text);
        assert!(faults.is_empty(), "{faults:?}");
        tokens.into_iter().map(|t| t.kind).collect()
    }

    #[test]
    fn a_statement() {
        assert_eq!(
            kinds("movx(A, B, east); // right"),
            vec![
                TokenKind::Name("movx".into()),
                TokenKind::Mark("("),
                TokenKind::Name("A".into()),
                TokenKind::Mark(","),
                TokenKind::Name("B".into()),
                TokenKind::Mark(","),
                TokenKind::Name("east".into()),
                TokenKind::Mark(")"),
                TokenKind::Mark(";"),
                TokenKind::Line(" right".into()),
            ]
        );
    }

    #[test]
    fn numbers() {
        for (text, value) in [
            ("10", 10.0),
            ("2.5", 2.5),
            (".5", 0.5),
            ("3.", 3.0),
            ("1e3", 1000.0),
            ("1.5f", 1.5),
            ("0x1F", 31.0),
        ] {
            assert_eq!(kinds(text), vec![TokenKind::Number(value)], "{text}");
        }
        assert_eq!(
            kinds("1..4"),
            vec![
                TokenKind::Number(1.0),
                TokenKind::Mark(".."),
                TokenKind::Number(4.0)
            ]
        );
        assert_eq!(kinds("-3").len(), 2);
    }

    #[test]
    fn what_is_no_token_is_a_fault_with_its_place() {
        for (text, start, end) in [
            ("a § b", 2, 4),
            ("12ab", 0, 4),
            ("x /* y", 2, 6),
            ("\"", 0, 1),
        ] {
            let (_, faults) = lex(text);
            assert_eq!(faults.len(), 1, "{text}");
            assert_eq!(
                (faults[0].place.start, faults[0].place.end),
                (start, end),
                "{text}"
            );
        }
    }
}
