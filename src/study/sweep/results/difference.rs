//! Where two results of one point differ.

use std::{fmt, path::PathBuf};

use serde_json::Value as Json;

use crate::study::sweep::tables::{
    column::Part,
    table::{self, Row},
};

/// Columns that name what a point's identity holds by content: the same point may be named
/// otherwise elsewhere.
pub(in crate::study::sweep) fn names() -> impl Iterator<Item = &'static str> {
    table::columns_of(&[Part::Light]).chain(["kernel", "chip"])
}

/// The columns in which two results of one point must agree and do not, with both values.
/// Numbers are compared to the bit.
pub(super) fn differences<'a>(
    columns: &'a [String],
    one: &'a Row,
    other: &'a Row,
) -> impl Iterator<Item = (&'a str, &'a Json, &'a Json)> {
    const NONE: &Json = &Json::Null;
    let judged = columns.iter().filter(|name| is_judged(name));
    judged.filter_map(move |name| {
        let values = [one, other].map(|row| row.get(name).unwrap_or(NONE));
        let [one, other] = values;
        // The shortest text that reads back: another text is another number, also of zeros.
        let [text, another] = values.map(Json::to_string);
        (text != another).then_some((name.as_str(), one, other))
    })
}

/// Whether a column is the same wherever the point is computed: not a time, not a name, and not
/// words for people.
fn is_judged(name: &str) -> bool {
    !table::timed(name)
        && names().all(|other| other != name)
        && !["reason", "index"].contains(&name)
}

/// A column of a point of which two folders say different things.
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    /// The point's number.
    pub point: usize,
    /// Its identity.
    pub id: String,
    /// Which column.
    pub column: String,
    /// What each folder says.
    pub values: [(PathBuf, Json); 2],
}

impl fmt::Display for Disagreement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            point,
            id,
            column,
            values: [(one, a), (other, b)],
        } = self;
        let (one, other) = (one.display(), other.display());
        write!(
            f,
            "point {point} ({id}), {column}: {a} in {one}, {b} in {other}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn bits_are_compared_and_times_are_not() {
        let row = |value: Json| value.as_object().unwrap().clone();
        let a = row(
            json!({"error": 0.1, "f1": 0.0, "events": 3, "seconds_per_frame": 1.0,
            "state_memory_bytes": 8, "kernel": "a", "reason": "x"}),
        );
        let b = row(
            json!({"error": 0.100_000_000_000_000_02, "f1": -0.0, "events": 3,
            "seconds_per_frame": 2.0, "state_memory_bytes": 9, "kernel": "b", "reason": "y"}),
        );
        let columns: Vec<String> = a.keys().cloned().collect();
        let found: Vec<_> = differences(&columns, &a, &b)
            .map(|(name, ..)| name)
            .collect();
        let mut found = found;
        found.sort_unstable();
        assert_eq!(found, ["error", "f1", "state_memory_bytes"]);
        assert_eq!(differences(&columns, &a, &a).count(), 0);
        let without = row(json!({"error": 0.1}));
        assert!(differences(&columns, &a, &without).any(|(name, ..)| name == "events"));
    }
}
