//! The keys of a table, as data.

use super::Kind;

/// One key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// What it takes.
    pub kind: Kind,
    /// What holds when it is left out.
    pub absent: Absent,
    /// What it is.
    pub what: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// How it may be written, for whoever has left it out; may be empty.
    pub example: &'static str,
}

/// A key that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// It must not be.
    Required,
    /// Then there is none.
    None,
    /// Then it is this, as TOML.
    Is(&'static str),
}

impl Key {
    /// A key that may be left out: then there is none.
    #[must_use]
    pub const fn optional(name: &'static str, kind: Kind, what: &'static str) -> Self {
        Self {
            name,
            kind,
            absent: Absent::None,
            what,
            unit: "",
            example: "",
        }
    }

    /// A key that must be there.
    #[must_use]
    pub const fn required(name: &'static str, kind: Kind, what: &'static str) -> Self {
        Self {
            absent: Absent::Required,
            ..Self::optional(name, kind, what)
        }
    }

    /// A key that has a value, written as TOML, when it is left out.
    #[must_use]
    pub const fn with_default(
        name: &'static str,
        kind: Kind,
        default: &'static str,
        what: &'static str,
    ) -> Self {
        Self {
            absent: Absent::Is(default),
            ..Self::optional(name, kind, what)
        }
    }

    /// The same key with its unit.
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The same key with a line that gives it, such as `us = 1000`.
    #[must_use]
    pub const fn example(self, example: &'static str) -> Self {
        Self { example, ..self }
    }
}

/// What a table holds.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    /// Its keys; there are no others.
    pub keys: &'static [Key],
    /// Exactly one of these is given; empty where the keys do not exclude each other.
    pub one_of: &'static [&'static str],
}

impl Table {
    /// A table of keys that do not exclude each other.
    #[must_use]
    pub const fn new(keys: &'static [Key]) -> Self {
        Self { keys, one_of: &[] }
    }

    /// The key of this name.
    #[must_use]
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The names of all keys.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone {
        self.keys.iter().map(|key| key.name)
    }
}
