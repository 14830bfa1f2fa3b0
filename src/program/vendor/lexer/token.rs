//! Tokens of C++: names, numbers, text, punctuators. Comments are passed over.

use std::sync::Arc;

use crate::{
    config::{Fault, Place},
    limit::FAULTS,
    program::vendor::syntax::tree::Width,
};

/// One token.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Token {
    /// What it is.
    pub kind: TokenKind,
    /// Where it stands.
    pub place: Place,
    /// Whether it is the first of its line.
    pub first: bool,
}

/// What a token is.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) enum TokenKind {
    Name(Arc<str>),
    Whole(i64),
    /// The code of a character.
    Character(i64),
    /// A whole number that is no `int`.
    Wide(i64, Width),
    Real(f64),
    /// A real number of 32 bits, as it is written: `0.1f`.
    Single(f64),
    /// Text between quotes, without them.
    Text(Arc<str>),
    Punctuator(&'static str),
}

impl Token {
    pub(in crate::program::vendor) fn is(&self, punctuator: &str) -> bool {
        matches!(self.kind, TokenKind::Punctuator(m) if m == punctuator)
    }

    pub(in crate::program::vendor) fn name(&self) -> Option<&Arc<str>> {
        match &self.kind {
            TokenKind::Name(name) => Some(name),
            _ => None,
        }
    }
}

/// Longer punctuators before those that they begin with.
const PUNCTUATORS: [&str; 49] = [
    "<<=", ">>=", "...", "->*", "::", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=",
    "<<", ">>", "<=", ">=", "==", "!=", "&&", "||", "->", "##", "(", ")", "{", "}", "[", "]", ";",
    ",", "=", "+", "-", "*", "/", "%", "<", ">", "!", "~", "&", "|", "^", "?", ":", ".",
];

/// Cuts a text into tokens whose places begin at `base`.
pub(super) fn tokens(text: &str, base: usize) -> (Vec<Token>, Vec<Fault>) {
    let mut lexer = Lexer {
        text,
        at: 0,
        first: true,
    };
    let (mut tokens, mut faults) = (Vec::new(), Vec::new());
    while lexer.blanks(&mut faults, base) {
        let (start, first) = (lexer.at, lexer.first);
        let kind = lexer.token();
        lexer.first = false;
        let place = Place::new(base + start, base + lexer.at);
        match kind {
            Ok(kind) => tokens.push(Token { kind, place, first }),
            Err(message) => {
                faults.push(
                    Fault::error(place, message, "here")
                        .help("vendor C++ is read here: statements, functions, `#define`"),
                );
                if faults.len() > FAULTS {
                    break;
                }
            }
        }
    }
    (tokens, faults)
}

struct Lexer<'a> {
    text: &'a str,
    at: usize,
    /// Whether a line has begun since the last token.
    first: bool,
}

impl<'a> Lexer<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// Passes over blanks and comments; whether anything is left.
    fn blanks(&mut self, faults: &mut Vec<Fault>, base: usize) -> bool {
        loop {
            let rest = self.rest();
            if let Some(after) = rest.strip_prefix("\\") {
                // A line that goes on.
                if after.starts_with('\n') || after.starts_with("\r\n") {
                    self.at += rest.find('\n').unwrap_or(0) + 1;
                    continue;
                }
            }
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
                continue;
            }
            if rest.starts_with("/*") {
                let Some(end) = rest.find("*/") else {
                    let place = Place::new(base + self.at, base + self.at + 2);
                    faults.push(
                        Fault::error(place, "a comment without an end", "begins here")
                            .help("close it with `*/`"),
                    );
                    self.at = self.text.len();
                    return false;
                };
                self.at += end + 2;
                continue;
            }
            match rest.chars().next() {
                None => return false,
                Some('\n') => self.first = true,
                Some(c) if c.is_whitespace() || c == '\u{feff}' => {}
                Some(_) => return true,
            }
            self.at += rest.chars().next().map_or(0, char::len_utf8);
        }
    }

    fn token(&mut self) -> Result<TokenKind, String> {
        let rest = self.rest();
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let first = rest.chars().next().unwrap_or(' ');
        if rest.starts_with("R\"") {
            return self.raw();
        }
        if first.is_ascii_alphabetic() || first == '_' {
            let end = rest.find(|c| !letter(c)).unwrap_or(rest.len());
            self.at += end;
            return Ok(TokenKind::Name(rest[..end].into()));
        }
        let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        if digit(Some(first)) || (first == '.' && digit(rest.chars().nth(1))) {
            return self.number();
        }
        if first == '"' || first == '\'' {
            return self.quoted(first);
        }
        if first == '#' && !rest.starts_with("##") {
            self.at += 1;
            return Ok(TokenKind::Punctuator("#"));
        }
        if let Some(punctuator) = PUNCTUATORS
            .iter()
            .find(|punctuator| rest.starts_with(**punctuator))
        {
            self.at += punctuator.len();
            return Ok(TokenKind::Punctuator(punctuator));
        }
        self.at += first.len_utf8();
        Err(format!("`{}` has no meaning here", first.escape_debug()))
    }

    fn raw(&mut self) -> Result<TokenKind, String> {
        let rest = self.rest();
        let open = rest.find('(').unwrap_or(rest.len());
        let end = format!("){}\"", rest.get(2..open).unwrap_or_default());
        let body = rest.get(open + 1..).unwrap_or_default();
        let Some(length) = body.find(&end) else {
            self.at = self.text.len();
            return Err("quotation mark without an end".to_owned());
        };
        self.at += open + 1 + length + end.len();
        // Where all others have their escapes, it has none.
        Ok(TokenKind::Text(body[..length].replace('\\', "\\\\").into()))
    }

    fn quoted(&mut self, quote: char) -> Result<TokenKind, String> {
        let rest = self.rest();
        let mut escaped = false;
        for (i, c) in rest.char_indices().skip(1) {
            if c == '\n' {
                break;
            }
            if c == quote && !escaped {
                self.at += i + 1;
                let inner = &rest[1..i];
                if quote == '"' {
                    return Ok(TokenKind::Text(inner.into()));
                }
                let code = unescaped(inner).last().copied().unwrap_or(b' ');
                return Ok(TokenKind::Character(code.into()));
            }
            escaped = c == '\\' && !escaped;
        }
        self.at += rest.find('\n').unwrap_or(rest.len());
        Err("quotation mark without an end".to_owned())
    }

    fn number(&mut self) -> Result<TokenKind, String> {
        let rest = self.rest();
        let mut end = 0;
        let mut before = ' ';
        for c in rest.chars() {
            let sign = (c == '+' || c == '-') && matches!(before, 'e' | 'E') && !hexadecimal(rest);
            if !(c.is_ascii_alphanumeric() || c == '.' || c == '\'' || sign) {
                break;
            }
            before = c;
            end += 1;
        }
        let whole = &rest[..end];
        self.at += end;
        let digits = whole.replace('\'', "").to_ascii_lowercase();
        let wrong = || format!("`{whole}` is not a number");
        for (prefix, radix) in [("0x", 16), ("0b", 2)] {
            if let Some(digits) = digits.strip_prefix(prefix) {
                return whole_number(digits, radix, false).ok_or_else(wrong);
            }
        }
        if digits.contains(['.', 'e']) || digits.ends_with('f') {
            let single = digits.ends_with('f');
            let digits = digits.trim_end_matches(['f', 'l']);
            let value: f64 = digits.parse().map_err(|_| wrong())?;
            return Ok(if single {
                TokenKind::Single(value)
            } else {
                TokenKind::Real(value)
            });
        }
        let octal = digits.len() > 1 && digits.starts_with('0');
        whole_number(&digits, if octal { 8 } else { 10 }, !octal).ok_or_else(wrong)
    }
}

/// A whole number with its suffix: of the first type that holds it, as in C++. A decimal number
/// takes a sign where its suffix does not forbid it.
fn whole_number(text: &str, radix: u32, decimal: bool) -> Option<TokenKind> {
    let digits = text.trim_end_matches(['u', 'l', 'z']);
    let suffix = &text[digits.len()..];
    let unsigned = suffix.contains('u');
    let long = suffix.contains(['l', 'z']);
    let value = u64::from_str_radix(digits, radix).ok()?;
    let signed = i64::try_from(value).ok();
    let width = if !unsigned && !long && i32::try_from(value).is_ok() {
        return Some(TokenKind::Whole(signed?));
    } else if !long && (unsigned || !decimal) && u32::try_from(value).is_ok() {
        Width::Unsigned
    } else if !unsigned && signed.is_some() {
        Width::Long
    } else if unsigned || !decimal {
        Width::UnsignedLong
    } else {
        return None;
    };
    Some(TokenKind::Wide(value as i64, width))
}

/// The bytes of a text in quotes: `\n` is the end of a line, `\xff` one byte.
pub(in crate::program::vendor) fn unescaped(text: &str) -> Vec<u8> {
    let mut out = Vec::new();
    let push = |c: char, out: &mut Vec<u8>| {
        out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
    };
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        let (radix, first) = match c {
            '\\' => match rest.next() {
                Some('x') => (16, None),
                Some(digit @ '0'..='7') => (8, Some(digit)),
                Some(other) => {
                    push(escaped(other), &mut out);
                    continue;
                }
                None => continue,
            },
            c => {
                push(c, &mut out);
                continue;
            }
        };
        // Two digits of 16, or three of 8.
        let most = if radix == 16 { 2 } else { 3 };
        let mut digits: String = first.into_iter().collect();
        let all = rest.as_str().chars();
        digits.extend(
            all.take_while(|c| c.is_digit(radix))
                .take(most - digits.len()),
        );
        let read = digits.len() - usize::from(first.is_some());
        rest.by_ref().take(read).for_each(drop);
        let code = u32::from_str_radix(&digits, radix).ok();
        out.extend(code.map(|code| code as u8));
    }
    out
}

const fn escaped(c: char) -> char {
    match c {
        'n' => '\n',
        't' => '\t',
        'r' => '\r',
        'a' => '\x07',
        'b' => '\x08',
        'f' => '\x0c',
        'v' => '\x0b',
        c => c,
    }
}

fn hexadecimal(text: &str) -> bool {
    text.starts_with("0x") || text.starts_with("0X")
}
