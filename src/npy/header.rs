//! What stands before the numbers: how many along each axis, of which type, in which order.

use std::io::{self, Read};

/// The first bytes of every file.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// The longest header that is read; `numpy` itself stops at 10 000.
const LONGEST: u64 = 65_535;

/// Numbers start at a multiple of so many bytes.
const ALIGN: usize = 64;

/// Bytes before the text of a header of version 1: magic, version, length.
const PREFIX: usize = MAGIC.len() + 4;

/// What the header of an array of plain numbers says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// The type of the numbers, such as `<f8`.
    pub descr: String,
    /// Whether the first axis runs fastest.
    pub fortran: bool,
    /// Numbers along each axis.
    pub shape: Vec<u64>,
}

/// A header that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum HeaderError {
    /// The stream cannot be read.
    #[error(transparent)]
    System(#[from] io::Error),
    /// There is nothing.
    #[error("it is empty")]
    Empty,
    /// A field is not as it should be.
    #[error("its header's {field} is {got}; expected {want}")]
    Field {
        /// Its name.
        field: &'static str,
        /// What it is.
        got: String,
        /// What it should be.
        want: &'static str,
    },
}

/// A field that is wrong, and what was expected instead.
type Wrong = (&'static str, &'static str);

impl Header {
    /// Reads a header, and how many bytes it has.
    ///
    /// # Errors
    /// When it is none, or not that of an array of plain numbers.
    pub fn read(stream: &mut impl Read) -> Result<(Self, u64), HeaderError> {
        let (text, bytes) = text(stream)?;
        match Self::parse(&text) {
            Ok(header) => Ok((header, bytes)),
            Err((field, want)) => Err(HeaderError::Field {
                field,
                got: shown(text.trim_end()),
                want,
            }),
        }
    }

    /// Reads the Python dictionary of the header: strings, booleans, and one tuple.
    fn parse(text: &str) -> Result<Self, Wrong> {
        const DICTIONARY: Wrong = ("text", "{'descr': …, 'fortran_order': …, 'shape': …}");
        const DESCR: Wrong = ("descr", "a plain type in quotes, such as '<f8'");
        const ORDER: Wrong = ("fortran_order", "True or False");
        const SHAPE: Wrong = ("shape", "whole numbers in brackets, such as (10, 64, 64)");
        let (mut descr, mut fortran, mut shape) = (None, None, None);
        let mut rest = text
            .trim()
            .strip_prefix('{')
            .ok_or(DICTIONARY)?
            .trim_start();
        while !rest.starts_with('}') {
            let (key, after) = quoted(rest).ok_or(DICTIONARY)?;
            rest = after
                .trim_start()
                .strip_prefix(':')
                .ok_or(DICTIONARY)?
                .trim_start();
            match key {
                "descr" => {
                    let (word, after) = quoted(rest).ok_or(DESCR)?;
                    descr = Some(word.to_owned());
                    rest = after;
                }
                "fortran_order" => {
                    let word = ["True", "False"].into_iter().find(|w| rest.starts_with(w));
                    let word = word.ok_or(ORDER)?;
                    fortran = Some(word == "True");
                    rest = &rest[word.len()..];
                }
                "shape" => {
                    let inside = rest.strip_prefix('(').ok_or(SHAPE)?;
                    let (inside, after) = inside.split_once(')').ok_or(SHAPE)?;
                    let words = inside.split(',').map(str::trim);
                    let axes: Result<_, _> =
                        words.filter(|w| !w.is_empty()).map(str::parse).collect();
                    shape = Some(axes.map_err(|_| SHAPE)?);
                    rest = after;
                }
                _ => return Err(DICTIONARY),
            }
            rest = rest.trim_start();
            if let Some(after) = rest.strip_prefix(',') {
                rest = after.trim_start();
            } else if !rest.starts_with('}') {
                return Err(DICTIONARY);
            }
        }
        if !rest[1..].trim().is_empty() {
            return Err(DICTIONARY);
        }
        Ok(Self {
            descr: descr.ok_or(DESCR)?,
            fortran: fortran.ok_or(ORDER)?,
            shape: shape.ok_or(SHAPE)?,
        })
    }
}

/// A header with this dictionary, version 1: at least `room` bytes, so that one that is written
/// last fits where it was left room for.
///
/// # Errors
/// When it is longer than a header of version 1 can say.
pub fn framed(dictionary: &str, room: usize) -> io::Result<Vec<u8>> {
    let whole = (PREFIX + dictionary.len() + 1)
        .max(room)
        .next_multiple_of(ALIGN);
    let length = u16::try_from(whole - PREFIX).map_err(io::Error::other)?;
    let mut bytes = Vec::with_capacity(whole);
    bytes.extend(MAGIC);
    bytes.extend([1, 0]);
    bytes.extend(length.to_le_bytes());
    bytes.extend(dictionary.as_bytes());
    bytes.resize(whole - 1, b' ');
    bytes.push(b'\n');
    Ok(bytes)
}

/// The text of the header, and how many bytes come before the numbers.
fn text(stream: &mut impl Read) -> Result<(String, u64), HeaderError> {
    let bad = |field, got: &[u8], want| HeaderError::Field {
        field,
        got: shown_bytes(got),
        want,
    };
    let mut take = |n: u64| -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        stream.take(n).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let start = take(8)?;
    if start.is_empty() {
        return Err(HeaderError::Empty);
    }
    let wide = match start.strip_prefix(MAGIC) {
        Some([1, 0]) => 2,
        Some([2 | 3, 0]) => 4,
        Some(version) => return Err(bad("version", version, "1.0, 2.0 or 3.0")),
        None => return Err(bad("magic", &start, "\\x93NUMPY and a version")),
    };
    let length = take(wide)?;
    if (length.len() as u64) < wide {
        return Err(bad("length", &length, "the length of the header"));
    }
    let says = length
        .iter()
        .rev()
        .fold(0, |all, byte| all << 8 | u64::from(*byte));
    if says > LONGEST {
        return Err(bad("length", &length, "at most 65535 bytes"));
    }
    let text = take(says)?;
    if (text.len() as u64) < says {
        return Err(bad(
            "text",
            &text,
            "a whole header; the file ends inside it",
        ));
    }
    match String::from_utf8(text) {
        Ok(text) => Ok((text, 8 + wide + says)),
        Err(error) => Err(bad("text", error.as_bytes(), "text")),
    }
}

/// A quoted string at the start of `text`, and what follows it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

/// The beginning of a text, as a message has room for.
fn shown(text: &str) -> String {
    let mut letters = text.chars();
    let begin: String = letters.by_ref().take(200).collect();
    let more = if letters.next().is_some() { " …" } else { "" };
    format!("{begin:?}{more}")
}

fn shown_bytes(bytes: &[u8]) -> String {
    format!("\"{}\"", bytes[..bytes.len().min(200)].escape_ascii())
}
