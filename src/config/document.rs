//! A text as TOML: values, each with its place.

use toml::{
    Spanned,
    de::{DeString, DeTable, DeValue},
};

use super::{Fault, Place, Read};

/// A text, read as TOML.
#[derive(Debug)]
pub struct Document<'a> {
    root: Spanned<DeValue<'a>>,
}

impl<'a> Document<'a> {
    /// Reads a text.
    ///
    /// # Errors
    /// When it is no TOML.
    pub fn parse(text: &'a str) -> Read<Self> {
        match DeTable::parse(text) {
            Ok(table) => Ok(Self {
                root: Spanned::new(0..0, DeValue::Table(table.into_inner())),
            }),
            Err(error) => Err(not_toml(&error)),
        }
    }

    /// Reads a text that is one value, without a key.
    ///
    /// # Errors
    /// When it is no TOML.
    pub fn value(text: &'a str) -> Read<Self> {
        let root = DeValue::parse(text).map_err(|error| not_toml(&error))?;
        Ok(Self { root })
    }

    /// The value that holds all others.
    #[must_use]
    pub const fn root(&'a self) -> Node<'a> {
        Node { value: &self.root }
    }
}

fn not_toml(error: &toml::de::Error) -> Fault {
    let place = error.span().map_or(Place::new(0, 0), Place::from);
    let message = format!("not TOML: {}", error.message().trim());
    let help = if message.contains("duplicate key") {
        "leave one of the two out: a table has a key once"
    } else {
        "write key = value; words go in quotes, as in name = \"word\""
    };
    Fault::error(place, message, "here").help(help)
}

/// A value with its place.
#[derive(Clone, Copy, Debug)]
pub struct Node<'a> {
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Node<'a> {
    /// This value.
    #[must_use]
    pub const fn new(value: &'a Spanned<DeValue<'a>>) -> Self {
        Self { value }
    }

    /// Where it stands.
    #[must_use]
    pub fn place(self) -> Place {
        self.value.span().into()
    }

    /// What kind of value it is, in words.
    #[must_use]
    pub fn found(self) -> &'static str {
        match self.value.get_ref() {
            DeValue::String(_) => "a text",
            DeValue::Float(_) if self.as_number().is_none() => {
                "infinite: beyond the largest number of 64 bits"
            }
            DeValue::Integer(_) if self.as_number().is_none() => {
                "a whole number beyond 64 bits; write it with a point or an exponent"
            }
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        }
    }

    /// The text, if it is one.
    #[must_use]
    pub fn as_text(self) -> Option<&'a str> {
        self.value.get_ref().as_str()
    }

    /// `true` or `false`, if it is one of them.
    #[must_use]
    pub fn as_flag(self) -> Option<bool> {
        self.value.get_ref().as_bool()
    }

    /// The number, if it is one that can be held.
    #[must_use]
    pub fn as_number(self) -> Option<f64> {
        match self.value.get_ref() {
            DeValue::Float(float) => {
                let number: f64 = float.as_str().parse().ok()?;
                // Digits that say more than the largest number are no number.
                let beyond = number.is_infinite() && !float.as_str().contains("inf");
                (!beyond).then_some(number)
            }
            DeValue::Integer(integer) => {
                let (digits, radix) = (integer.as_str(), integer.radix());
                let signed = i64::from_str_radix(digits, radix).map(|n| n as f64);
                let any = signed.or_else(|_| u64::from_str_radix(digits, radix).map(|n| n as f64));
                any.ok()
            }
            _ => None,
        }
    }

    /// The whole number, if it is one that is not below zero.
    #[must_use]
    pub fn as_whole(self) -> Option<u64> {
        let integer = self.value.get_ref().as_integer()?;
        u64::from_str_radix(integer.as_str(), integer.radix()).ok()
    }

    /// The values of the list, if it is one.
    #[must_use]
    pub fn as_list(self) -> Option<Vec<Self>> {
        let list = self.value.get_ref().as_array()?;
        Some(list.iter().map(|value| Self { value }).collect())
    }

    /// The numbers, row by row, if it is a list of lists of numbers.
    #[must_use]
    pub fn as_rows(self) -> Option<Vec<Vec<f64>>> {
        let row = |row: Self| row.as_list()?.into_iter().map(Self::as_number).collect();
        self.as_list()?.into_iter().map(row).collect()
    }

    /// Keys and values of the table, if it is one, in the order of the text.
    #[must_use]
    pub fn as_table(self) -> Option<Vec<(Name<'a>, Self)>> {
        let table = self.value.get_ref().as_table()?;
        let entry = |(key, value): (&'a Spanned<DeString<'a>>, _)| {
            let name = Name {
                text: key.get_ref(),
                place: key.span().into(),
            };
            (name, Self { value })
        };
        Some(table.iter().map(entry).collect())
    }

    /// What this key has, if it is a table that has it.
    #[must_use]
    pub fn get(self, key: &str) -> Option<Self> {
        let value = self.value.get_ref().as_table()?.get(key)?;
        Some(Self { value })
    }
}

/// A key as it is written.
#[derive(Clone, Copy, Debug)]
pub struct Name<'a> {
    /// The key.
    pub text: &'a str,
    /// Where it stands.
    pub place: Place,
}
