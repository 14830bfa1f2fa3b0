//! Single entries of a TOML text, each with its place: words, numbers, small tables, and what
//! is said when one is of another kind.

use std::ops::Range;

use toml::{
    Spanned,
    de::{DeString, DeTable, DeValue},
};

use crate::config::{Fault, Place, suggestion_or};

/// What was read, or what is wrong with it.
pub(super) type Read<T> = Result<T, Fault>;

/// The entries of a small table.
pub(super) struct Parts<'a> {
    name: &'a str,
    left: Vec<(&'a str, &'a Spanned<DeValue<'a>>)>,
    place: Place,
}

impl<'a> Parts<'a> {
    /// Only these keys.
    pub fn of(name: &'a str, table: &'a DeTable<'a>, known: &[&str], place: Place) -> Read<Self> {
        for key in table.keys() {
            if !known.contains(&key.get_ref().as_ref()) {
                return Err(unknown(key, known, &format!("in `{name}`")));
            }
        }
        Ok(Self {
            name,
            left: table
                .iter()
                .map(|(k, v)| (k.get_ref().as_ref(), v))
                .collect(),
            place,
        })
    }

    /// What stands there.
    pub fn take(&mut self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        let found = self.left.iter().find(|(name, _)| *name == key);
        found.map(|(_, value)| *value)
    }

    /// A number.
    pub fn number(&mut self, key: &str, default: Option<f64>) -> Read<f64> {
        match (self.take(key), default) {
            (Some(given), _) => number(key, given),
            (None, Some(default)) => Ok(default),
            (None, None) => Err(Fault::error(
                self.place,
                format!("`{}` has no `{key}`", self.name),
                "here",
            )
            .help(format!("add {key} = a number"))),
        }
    }
}

/// A key that nothing has.
pub(super) fn unknown(key: &Spanned<DeString<'_>>, known: &[&str], place: &str) -> Fault {
    let name = key.get_ref().as_ref();
    let help = suggestion_or(
        name,
        known.iter().copied(),
        &format!("known are {}", known.join(", ")),
    );
    Fault::error(
        at(key.span()),
        format!("unknown key `{name}` {place}"),
        "not known here",
    )
    .help(help)
}

/// One of a few words.
pub(super) fn one_of<'a>(name: &str, word: &str, words: &[&'a str], place: Place) -> Read<&'a str> {
    let found = words.iter().find(|known| **known == word);
    found.copied().ok_or_else(|| {
        let otherwise = format!("give one of {}", words.join(", "));
        Fault::error(place, format!("`{name}` cannot be \"{word}\""), "here").help(suggestion_or(
            word,
            words.iter().copied(),
            &otherwise,
        ))
    })
}

/// A text.
pub(super) fn word<'a>(name: &str, written: &'a Spanned<DeValue<'_>>) -> Read<&'a str> {
    match written.get_ref() {
        DeValue::String(word) => Ok(word),
        _ => Err(kind(name, written, "a word in quotes")),
    }
}

/// A finite number.
pub(super) fn number(name: &str, written: &Spanned<DeValue<'_>>) -> Read<f64> {
    let parsed: Option<f64> = match written.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .map(|number| number as f64),
        _ => None,
    };
    parsed
        .filter(|number| number.is_finite())
        .ok_or_else(|| kind(name, written, "a finite number"))
}

/// A whole number.
pub(super) fn whole(name: &str, written: &Spanned<DeValue<'_>>) -> Read<u64> {
    let parsed = match written.get_ref() {
        DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix()).ok(),
        _ => None,
    };
    parsed.ok_or_else(|| kind(name, written, "a whole number, not below zero"))
}

/// Not below `least`; not `least` itself where it must be above it.
pub(super) fn in_range(name: &str, number: f64, least: f64, above: bool, place: Place) -> Read<()> {
    if number > least || (!above && number == least) {
        return Ok(());
    }
    let want = if above {
        format!("give a number above {least}")
    } else {
        format!("give {least} or more")
    };
    Err(Fault::error(place, format!("`{name}` is {number}"), "here").help(want))
}

/// A whole number of a range.
pub(super) fn whole_in_range(
    name: &str,
    number: u64,
    range: std::ops::RangeInclusive<u64>,
    place: Place,
) -> Read<()> {
    if range.contains(&number) {
        return Ok(());
    }
    let help = format!("give a whole number of at least {}", range.start());
    Err(Fault::error(place, format!("`{name}` is {number}"), "here").help(help))
}

/// Something of another kind than is wanted.
pub(super) fn kind(name: &str, written: &Spanned<DeValue<'_>>, want: &str) -> Fault {
    let got = match written.get_ref() {
        DeValue::String(_) => "a word",
        DeValue::Integer(_) | DeValue::Float(_) => "another number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    };
    Fault::error(
        at(written.span()),
        format!("`{name}` takes {want}, this is {got}"),
        "here",
    )
    .help(format!("give {want}"))
}

/// A place of the TOML reader.
pub(super) fn at(span: Range<usize>) -> Place {
    span.into()
}
