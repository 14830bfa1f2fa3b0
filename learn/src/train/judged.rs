//! What is known of an arm once it is judged.

use std::fmt::Display;

use crate::record::Row;

/// What is measured of an arm, and what is to be said of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judged {
    /// A row for each form, decoder and held-out clip.
    pub rows: Vec<Row>,
    /// Why it has no program, what few values have taken from it, rates that are not the target.
    pub remarks: Vec<String>,
}

impl Judged {
    /// Nothing but a remark.
    pub(super) fn without(why: String) -> Self {
        Self {
            rows: Vec::new(),
            remarks: vec![why],
        }
    }

    /// What the compiler says of what it refuses.
    pub(super) fn refused(why: &dyn Display) -> Self {
        Self::without(format!("no program: {why}"))
    }
}
