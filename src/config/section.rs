//! A table that was checked: typed values by the names of their keys.

use super::{Absent, Fault, Key, Kind, Name, Node, Place, Read, Table, choice};

/// A table of a document, and what its keys are.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    node: Node<'a>,
    table: &'static Table,
}

impl<'a> Section<'a> {
    /// This value as a table with these keys.
    #[must_use]
    pub const fn new(node: Node<'a>, table: &'static Table) -> Self {
        Self { node, table }
    }

    /// Where it stands.
    #[must_use]
    pub fn place(&self) -> Place {
        self.node.place()
    }

    /// What a key has, if it is there.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<Node<'a>> {
        debug_assert!(self.table.key(key).is_some(), "`{key}` is not described");
        self.node.get(key)
    }

    /// Where a key's value stands; where the table does, if it is left out.
    #[must_use]
    pub fn place_of(&self, key: &str) -> Place {
        self.get(key).map_or_else(|| self.place(), Node::place)
    }

    /// What a key has.
    ///
    /// # Errors
    /// When it is left out.
    pub fn need(&self, key: &str) -> Read<Node<'a>> {
        self.get(key).ok_or_else(|| {
            let message = format!("missing key `{key}`");
            let fault = Fault::error(self.place(), message, "in this table");
            match self.table.key(key) {
                Some(known) if !known.example.is_empty() => {
                    fault.help(format!("add it, such as {}", known.example))
                }
                Some(known) => fault.help(format!("add it: {}", known.what)),
                None => fault,
            }
        })
    }

    /// What holds when a key is left out, as TOML.
    fn default(&self, key: &str) -> Option<&'static str> {
        match self.table.key(key)?.absent {
            Absent::Is(text) => Some(text),
            Absent::Required | Absent::None => None,
        }
    }

    /// The text of a key, or what holds when it is left out.
    ///
    /// # Errors
    /// When there is none, or it is none.
    pub fn text(&self, key: &str) -> Read<&'a str> {
        if let (None, Some(default)) = (self.get(key), self.default(key)) {
            return Ok(default.trim_matches('"'));
        }
        let node = self.need(key)?;
        node.as_text().ok_or_else(|| other(key, node, "a text"))
    }

    /// What the word of a key stands for: that of `all` which is where the word is in the key's
    /// list of words. None when there is neither a word nor a default.
    ///
    /// # Errors
    /// When the key takes other words.
    pub fn word<T: Copy>(&self, key: &str, all: &[T]) -> Read<Option<T>> {
        let Some(Key {
            kind: Kind::Choice(words),
            ..
        }) = self.table.key(key)
        else {
            return Ok(None);
        };
        if self.get(key).is_none() && self.default(key).is_none() {
            return Ok(None);
        }
        let at = choice(self.text(key)?, words, self.place_of(key), "")?;
        Ok(all.get(at).copied())
    }

    /// As [`Section::word`], where there is one.
    ///
    /// # Errors
    /// When there is none, or it is none of the key's words.
    pub fn needed_word<T: Copy>(&self, key: &str, all: &[T]) -> Read<T> {
        let node = self.need(key)?;
        let word = self.word(key, all)?;
        word.ok_or_else(|| other(key, node, "another word"))
    }

    /// The number of a key, or what holds when it is left out.
    ///
    /// # Errors
    /// When there is none, or it is none.
    pub fn number(&self, key: &str) -> Read<f64> {
        let default = self.default(key).and_then(|text| text.parse().ok());
        if let (None, Some(default)) = (self.get(key), default) {
            return Ok(default);
        }
        let node = self.need(key)?;
        node.as_number().ok_or_else(|| other(key, node, "a number"))
    }

    /// The whole number of a key, or what holds when it is left out.
    ///
    /// # Errors
    /// When there is none, or it is none.
    pub fn whole(&self, key: &str) -> Read<u64> {
        let default = self.default(key).and_then(|text| text.parse().ok());
        if let (None, Some(default)) = (self.get(key), default) {
            return Ok(default);
        }
        let node = self.need(key)?;
        node.as_whole()
            .ok_or_else(|| other(key, node, "a whole number"))
    }

    /// The text of a key that may be left out.
    #[must_use]
    pub fn maybe_text(&self, key: &str) -> Option<String> {
        self.get(key)?.as_text().map(str::to_owned)
    }

    /// The number of a key that may be left out.
    #[must_use]
    pub fn maybe_number(&self, key: &str) -> Option<f64> {
        self.get(key)?.as_number()
    }

    /// The whole number of a key that may be left out.
    #[must_use]
    pub fn maybe_whole(&self, key: &str) -> Option<u64> {
        self.get(key)?.as_whole()
    }

    /// The table of a key, if it has one; its keys are those that the key describes.
    #[must_use]
    pub fn table(&self, key: &str) -> Option<Section<'a>> {
        let node = self.get(key)?;
        let table = match &self.table.key(key)?.kind {
            Kind::Table(table) => Some(*table),
            Kind::Either { ways, .. } => ways.iter().find_map(|way| match way {
                Kind::Table(table) => Some(*table),
                _ => None,
            }),
            _ => None,
        };
        node.as_table()?;
        Some(Self::new(node, table?))
    }

    /// The tables of a key's list; none when it is left out.
    #[must_use]
    pub fn tables(&self, key: &str) -> Vec<Section<'a>> {
        let of = self.table.key(key).map(|key| &key.kind);
        let Some(Kind::List {
            of: Kind::Table(table),
            ..
        }) = of
        else {
            return Vec::new();
        };
        let list = self.list(key).into_iter();
        list.map(|node| Self::new(node, table)).collect()
    }

    /// The names that the writer has chosen in a key's table, and what they have; none when it
    /// is left out.
    #[must_use]
    pub fn entries(&self, key: &str) -> Vec<(Name<'a>, Node<'a>)> {
        let table = self.get(key).and_then(Node::as_table);
        table.unwrap_or_default()
    }

    /// The flag of a key; `false` when it is left out.
    #[must_use]
    pub fn flag(&self, key: &str) -> bool {
        self.get(key).and_then(Node::as_flag).unwrap_or(false)
    }

    /// The values of a key's list; none when it is left out.
    #[must_use]
    pub fn list(&self, key: &str) -> Vec<Node<'a>> {
        self.get(key).and_then(Node::as_list).unwrap_or_default()
    }
}

/// A value of another kind than its key takes: what was checked has none.
fn other(key: &str, node: Node<'_>, want: &str) -> Fault {
    let message = format!("`{key}` takes {want}, this is {}", node.found());
    Fault::error(node.place(), message, "here")
}
