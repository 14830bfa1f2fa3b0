//! The list of quantisers, their names, and how a name is read and written.
//!
//! A new quantiser is a file beside this one, with its [`Entry`], and a line of [`ENTRIES`].

use std::str::FromStr;

use super::{
    digits,
    entry::{Entry, Parameters, Quantiser, Rounding, whole},
    fixed, levels,
};
use crate::config::asked;

/// All quantisers, in the order in which they are listed.
pub const ENTRIES: &[&Entry] = &[
    &levels::BINARY,
    &levels::TERNARY,
    &levels::TERNARY_07,
    &levels::TERNARY_SPLIT,
    &levels::POWERS_OF_TWO,
    &levels::WHOLE,
    &digits::ENTRY,
    &fixed::ENTRY,
];

impl Quantiser {
    /// `binary`
    pub const BINARY: Self = Self::new(&levels::BINARY, [0; 2]);
    /// `ternary`
    pub const TERNARY: Self = Self::new(&levels::TERNARY, [0; 2]);
    /// `ternary-split`
    pub const TERNARY_SPLIT: Self = Self::new(&levels::TERNARY_SPLIT, [0; 2]);

    const fn new(entry: &'static Entry, numbers: [u32; 2]) -> Self {
        Self {
            entry,
            numbers,
            rounding: Rounding::Nearest,
        }
    }
}

/// How all names are written, with commas between, and what their numbers are.
#[must_use]
pub fn known() -> String {
    let each = ENTRIES.iter().map(|entry| match entry.numbers {
        "" => entry.form.to_owned(),
        numbers => format!("{} ({numbers})", entry.form),
    });
    each.collect::<Vec<_>>().join(", ")
}

/// A regular expression that all names match, and hardly another.
#[must_use]
pub fn pattern() -> String {
    let each = ENTRIES.iter().map(|entry| match entry.parameters {
        Parameters::None => format!("{}$", entry.form.replace('.', r"\.")),
        Parameters::One(..) => format!("{}[0-9]+$", entry.stem()),
        Parameters::Fixed => format!("{}[0-9]", entry.stem()),
    });
    format!("^({})", each.collect::<Vec<_>>().join("|"))
}

/// A question, where a name is like none and yet near to one.
fn meant(name: &str, why: &str) -> String {
    let forms = ENTRIES.iter().map(|entry| entry.form);
    let small = name.to_lowercase();
    if small != name && small.parse::<Quantiser>().is_ok() {
        format!("did you mean `{small}`? ")
    } else if why.is_empty() {
        asked(name, forms)
    } else {
        String::new()
    }
}

/// A name that is no quantiser's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{name}` is no quantiser{why}")]
#[diagnostic(help("{}known are {}", meant(name, why), known()))]
pub struct QuantiserNameError {
    /// What was given.
    pub name: String,
    /// What is wrong with it, after a colon; nothing if it is like none.
    pub why: String,
}

impl FromStr for Quantiser {
    type Err = QuantiserNameError;

    fn from_str(name: &str) -> Result<Self, QuantiserNameError> {
        let wrong = |why: String| QuantiserNameError {
            name: name.to_owned(),
            why,
        };
        let mut all = ENTRIES.iter();
        let entry = all.find(|entry| match entry.parameters {
            Parameters::None => entry.form == name,
            Parameters::One(..) | Parameters::Fixed => name.starts_with(entry.stem()),
        });
        let entry = entry.ok_or_else(|| wrong(String::new()))?;
        let rest = &name[entry.stem().len()..];
        let read = match entry.parameters {
            Parameters::None => Ok(([0; 2], Rounding::Nearest)),
            Parameters::One(least, most) => {
                whole(rest, least, most).map(|n| ([n, 0], Rounding::Nearest))
            }
            Parameters::Fixed => fixed::numbers(rest),
        };
        let (numbers, rounding) = read.map_err(|why| wrong(format!(": {why}")))?;
        Ok(Self {
            rounding,
            ..Self::new(entry, numbers)
        })
    }
}
