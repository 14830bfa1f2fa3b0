//! The list of quantisers, their names, and how a name is read and written.
//!
//! A new quantiser is a file beside this one, with its [`Entry`], and a line of [`ENTRIES`].

use std::{fmt, str::FromStr};

use super::{QuantiseError, Rounding, Sum, digits, fixed, levels};

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

/// The level of each weight, and the scale.
pub type Chosen = (Vec<f64>, f64);

/// What there is to say of a quantiser, and how it works: one or more in each quantiser's file.
#[derive(Debug)]
pub struct Entry {
    /// How its name is written, a capital letter for each number: `po2-N`.
    pub form: &'static str,
    /// What the numbers are, and what else may follow; empty without numbers.
    pub numbers: &'static str,
    /// What numbers a name has.
    pub parameters: Parameters,
    /// The levels, for people.
    pub levels: &'static str,
    /// The scale, for people.
    pub scale: &'static str,
    /// How good it is, for people.
    pub quality: &'static str,
    /// The levels of weights that are not all 0, and the scale; the seed is that of stochastic
    /// rounding.
    pub quantise: fn(Quantiser, &[f64], Sum, u64) -> Result<Chosen, QuantiseError>,
}

impl Entry {
    /// What stands in its names before the numbers.
    fn stem(&self) -> &'static str {
        match self.parameters {
            Parameters::None => self.form,
            Parameters::One(..) | Parameters::Fixed => self
                .form
                .split(|c: char| c.is_ascii_uppercase())
                .next()
                .unwrap_or_default(),
        }
    }
}

/// What numbers the name of a quantiser has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameters {
    /// None.
    None,
    /// A whole number, from the first to the second.
    One(u32, u32),
    /// Bits before and after the point, and a rounding.
    Fixed,
}

/// How a kernel is brought to few values: one of the list, with its numbers.
#[derive(Clone, Copy, Debug)]
pub struct Quantiser {
    pub(super) entry: &'static Entry,
    /// As many as its name has, then 0.
    pub(super) numbers: [u32; 2],
    pub(super) rounding: Rounding,
}

impl PartialEq for Quantiser {
    fn eq(&self, other: &Self) -> bool {
        (self.entry.form, self.numbers, self.rounding)
            == (other.entry.form, other.numbers, other.rounding)
    }
}

impl Eq for Quantiser {}

impl Quantiser {
    /// `binary`
    pub const BINARY: Self = Self::of(&levels::BINARY, [0; 2]);
    /// `ternary`
    pub const TERNARY: Self = Self::of(&levels::TERNARY, [0; 2]);
    /// `ternary-split`
    pub const TERNARY_SPLIT: Self = Self::of(&levels::TERNARY_SPLIT, [0; 2]);

    const fn of(entry: &'static Entry, numbers: [u32; 2]) -> Self {
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

/// A name that is no quantiser's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{name}` is no quantiser{why}")]
#[diagnostic(help("{}", known()))]
pub struct QuantiserNameError {
    /// What was given.
    pub name: String,
    /// What is wrong with it, after a colon; nothing if it is like none.
    pub why: String,
}

impl fmt::Display for Quantiser {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = self.numbers;
        f.write_str(self.entry.stem())?;
        match self.entry.parameters {
            Parameters::None => Ok(()),
            Parameters::One(..) => write!(f, "{first}"),
            Parameters::Fixed => {
                let rounding = match self.rounding {
                    Rounding::Nearest => "",
                    Rounding::Floor => ":floor",
                    Rounding::Stochastic => ":stochastic",
                };
                write!(f, "{first}.{second}{rounding}")
            }
        }
    }
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
            ..Self::of(entry, numbers)
        })
    }
}

/// A whole number within bounds.
pub(super) fn whole(text: &str, least: u32, most: u32) -> Result<u32, String> {
    let number: u32 = text
        .parse()
        .map_err(|_| format!("`{text}` is no whole number"))?;
    if (least..=most).contains(&number) {
        return Ok(number);
    }
    Err(format!("{number} is not within {least} to {most}"))
}
