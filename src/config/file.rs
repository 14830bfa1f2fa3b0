//! A kind of file: its keys, and how a text is read by them.

use super::{Document, Fault, Faults, Kind, Node, Read, check::Check};

/// A kind of file.
#[derive(Clone, Copy, Debug)]
pub struct File {
    /// What it is, in a few words.
    pub title: &'static str,
    /// What it holds: a table, or cases of tables.
    pub kind: Kind,
    /// Where more is said about its keys, for whoever has written one wrong.
    pub see: &'static str,
}

impl File {
    /// Reads a text and builds something of its values; `name` is told in messages.
    ///
    /// # Errors
    /// All that is wrong with the text; or the first thing that `build` finds wrong with values
    /// that are right one by one.
    pub fn read<T>(
        &self,
        name: &str,
        text: &str,
        build: impl FnOnce(Node<'_>) -> Read<T>,
    ) -> Result<T, Faults> {
        let document = self.document(text);
        let document = document.map_err(|faults| Faults::new(name, text, faults))?;
        build(document.root()).map_err(|fault| Faults::one(name, text, fault))
    }

    /// A text whose values are right one by one.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn document<'a>(&self, text: &'a str) -> Result<Document<'a>, Vec<Fault>> {
        let document = Document::parse(text).map_err(|fault| vec![fault])?;
        let mut check = Check {
            see: self.see,
            faults: Vec::new(),
        };
        check.value(&self.kind, document.root(), "", "");
        if check.faults.is_empty() {
            return Ok(document);
        }
        Err(check.faults)
    }
}
