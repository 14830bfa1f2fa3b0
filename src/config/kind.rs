//! What a key takes.

use super::{Range, Table};

/// What a key takes.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// Any text.
    Text,
    /// A text that is not empty.
    Name,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A text with a grammar of its own.
    Spelled(&'static Spelling),
    /// `true` or `false`.
    Flag,
    /// A number, with or without a decimal point.
    Number(Range),
    /// A whole number.
    Whole {
        /// The least.
        least: u64,
        /// The most.
        most: u64,
    },
    /// A list.
    List {
        /// What each of it is.
        of: &'static Self,
        /// The least number of them.
        least: usize,
        /// The most.
        most: usize,
    },
    /// A table with these keys.
    Table(&'static Table),
    /// A table whose keys are names that the writer chooses.
    Map(&'static Self),
    /// One of several ways to write it.
    Either {
        /// The ways.
        ways: &'static [Self],
        /// All of them in words.
        expected: &'static str,
    },
    /// Tables that differ by the word that one of their keys has.
    Cases {
        /// That key.
        tag: &'static str,
        /// Its words, and the keys beside it.
        cases: &'static [(&'static str, &'static Table)],
    },
}

/// A text with a grammar of its own.
#[derive(Debug)]
pub struct Spelling {
    /// What it is, in words.
    pub what: &'static str,
    /// A regular expression that every such text matches; empty where there is none.
    pub pattern: &'static str,
    /// Whether a text is one.
    pub holds: fn(&str) -> bool,
}

impl Kind {
    /// Any finite number but 0.
    pub const NONZERO: Self = Self::Either {
        ways: &[
            Self::Number(Range::POSITIVE),
            Self::Number(Range {
                most: 0.0,
                below: true,
                ..Range::FINITE
            }),
        ],
        expected: "a number other than 0",
    };

    /// A list of any length.
    #[must_use]
    pub const fn list(of: &'static Self) -> Self {
        Self::List {
            of,
            least: 0,
            most: usize::MAX,
        }
    }

    /// Whether it takes this text.
    #[must_use]
    pub fn holds_text(&self, text: &str) -> bool {
        match self {
            Self::Text => true,
            Self::Name => !text.is_empty(),
            Self::Choice(words) => words.contains(&text),
            Self::Spelled(spelling) => (spelling.holds)(text),
            Self::Either { ways, .. } => ways.iter().any(|way| way.holds_text(text)),
            _ => false,
        }
    }

    /// What it takes, in words.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Text => "a text in quotes".to_owned(),
            Self::Name => "a text in quotes that is not empty".to_owned(),
            Self::Choice(words) => listed(words.iter().copied()),
            Self::Spelled(spelling) => spelling.what.to_owned(),
            Self::Flag => "true or false".to_owned(),
            Self::Number(range) => range.words(),
            Self::Whole { least, most } if *most >= i64::MAX as u64 => {
                format!("a whole number of at least {least}, written without a point")
            }
            Self::Whole { least, most } => format!("a whole number from {least} to {most}"),
            Self::List { .. } => "a list".to_owned(),
            Self::Table(table) => format!("a table with {}", listed(table.names())),
            Self::Map(_) => "a table".to_owned(),
            Self::Either { expected, .. } => (*expected).to_owned(),
            Self::Cases { tag, .. } => format!("a table with `{tag}`"),
        }
    }
}

/// "`a`", "`a` or `b`", "one of `a`, `b`, `c`".
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.as_slice() {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [one, other] => format!("{one} or {other}"),
        all => format!("one of {}", all.join(", ")),
    }
}
