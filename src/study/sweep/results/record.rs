//! A point's file: every column of the study, who computed it, and a checksum of both.

use serde_json::Value as Json;

use super::{
    provenance::Provenance,
    seal::{self, Fields},
};
use crate::study::sweep::tables::table::Row;

/// A point that was computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What came of it.
    pub row: Row,
    /// Who computed it.
    pub provenance: Provenance,
}

/// The key of the provenance, beside the columns.
const PROVENANCE: &str = "provenance";

/// The longest file of a point, in bytes; one takes about 2000.
pub const LONGEST: u64 = crate::limit::POINT_BYTES;

/// Why a file is no record.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Wrong {
    /// It is not as it was written.
    Damaged(String),
    /// It is whole, and of a build whose numbers may differ.
    Other(Box<Provenance>),
}

impl Record {
    /// Whether it came to an end: it is done, or it cannot be. What failed may yet be computed.
    #[must_use]
    pub fn is_final(&self) -> bool {
        !is_failed(&self.row)
    }

    /// The text of its file.
    pub(super) fn text(&self, index: usize, columns: &[String]) -> String {
        let mut fields: Fields = columns
            .iter()
            .map(|name| {
                (
                    name.clone(),
                    self.row.get(name).cloned().unwrap_or_default(),
                )
            })
            .collect();
        fields.insert("index".to_owned(), index.into());
        let provenance = serde_json::to_value(&self.provenance).unwrap_or_default();
        fields.insert(PROVENANCE.to_owned(), provenance);
        let text = serde_json::to_string(&seal::sealed(fields)).unwrap_or_default();
        text + "\n"
    }

    /// Reads the file of a point.
    pub(super) fn read(
        bytes: &[u8],
        (index, id): (usize, &str),
        columns: &[String],
    ) -> Result<Self, Wrong> {
        let damaged = |why: &str| Wrong::Damaged(why.to_owned());
        let fields = seal::parse(bytes).map_err(Wrong::Damaged)?;
        if let Some(name) = columns.iter().find(|name| !fields.contains_key(*name)) {
            return Err(Wrong::Damaged(format!("it has no column `{name}`")));
        }
        let mut fields = seal::unsealed(fields).map_err(Wrong::Damaged)?;
        // The folder says the number, which another study of the same point may change.
        if let Some(number) = fields.get_mut("index") {
            *number = index.into();
        }
        let provenance = fields.remove(PROVENANCE);
        let provenance: Option<Provenance> =
            provenance.and_then(|said| serde_json::from_value(said).ok());
        let provenance = provenance.ok_or_else(|| damaged("it does not say who computed it"))?;
        if fields.get("id").and_then(Json::as_str) != Some(id) {
            return Err(damaged("it is of another point"));
        }
        if fields.len() != columns.len() {
            return Err(damaged("it has columns that the study does not have"));
        }
        if !provenance.same_numbers() {
            return Err(Wrong::Other(Box::new(provenance)));
        }
        let row = fields.into_iter().collect();
        Ok(Self { row, provenance })
    }
}

/// Whether a point failed: it may be computed again.
#[must_use]
pub fn is_failed(row: &Row) -> bool {
    row.get("outcome").and_then(Json::as_str) == Some("failed")
}
