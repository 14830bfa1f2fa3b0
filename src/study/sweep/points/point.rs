//! A point: one sensor on one scene, fully described.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json, json};

use super::{thresholds::Thresholds, value::Value};
use crate::study::sweep::study_file::key::{Key, Kind, Side};

/// One sensor on one scene. What plays no part in it is not in it, so that two ways to write
/// the same point are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    side: Side,
    values: BTreeMap<&'static str, Value>,
}

impl Point {
    /// A point of these values.
    #[must_use]
    pub fn new(side: Side, values: impl IntoIterator<Item = (&'static str, Value)>) -> Self {
        let mut point = Self {
            side,
            values: values.into_iter().collect(),
        };
        if !point.has_chance() {
            point.values.remove("seed");
        }
        if point.word("quantise") == Some("none") {
            point.values.remove("sum");
        }
        if point.values.get("lambda-y") == point.values.get("lambda") {
            point.values.remove("lambda-y");
        }
        if !point.flag("shared") {
            point.values.remove("shared");
        }
        if point.number("upsample") == Some(0.0) {
            point.values.remove("upsample");
        }
        for (key, left_out) in [("range", "auto"), ("transfer", "as-coded"), ("slice", "..")] {
            if point.word(key) == Some(left_out) {
                point.values.remove(key);
            }
        }
        point
    }

    /// Whether a seed can change anything.
    fn has_chance(&self) -> bool {
        match self.side {
            Side::Array => {
                let rounds = |name: &str| name.ends_with(":stochastic");
                self.word("domain") == Some("silicon") || self.word("quantise").is_some_and(rounds)
            }
            Side::Reference | Side::Mesh => {
                let mismatch = self.thresholds().is_some_and(Thresholds::has_mismatch);
                mismatch || self.word("noise").is_some_and(|noise| noise != "none")
            }
        }
    }

    /// Which sensor.
    #[must_use]
    pub const fn side(&self) -> Side {
        self.side
    }

    /// What a key is set to; none where it plays no part.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.values.get(key)
    }

    /// A name.
    #[must_use]
    pub fn word(&self, key: &str) -> Option<&str> {
        match self.get(key)? {
            Value::Word(word) => Some(word),
            _ => None,
        }
    }

    /// A number.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.get(key)? {
            Value::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// A whole number.
    #[must_use]
    pub fn whole(&self, key: &str) -> Option<u64> {
        match self.get(key)? {
            Value::Whole(number) => Some(*number),
            _ => None,
        }
    }

    /// Whether something is so.
    #[must_use]
    pub fn flag(&self, key: &str) -> bool {
        matches!(self.get(key), Some(Value::Flag(true)))
    }

    /// Thresholds for ON and OFF and their deviation, in light units.
    #[must_use]
    pub fn thresholds(&self) -> Option<&Thresholds> {
        match self.get("threshold")? {
            Value::Threshold(thresholds) => Some(thresholds),
            _ => None,
        }
    }

    /// Those of one kind of cells.
    pub(in crate::study::sweep) fn threshold(&self, kind: usize) -> [f64; 3] {
        self.thresholds()
            .map_or([1.0, 1.0, 0.0], |thresholds| thresholds.of(kind))
    }

    /// The description as columns of a row, as it is written.
    #[must_use]
    pub fn columns(&self) -> Map<String, Json> {
        let mut row = Map::new();
        row.insert("side".to_owned(), json!(self.side.name()));
        for key in Key::on_side(self.side) {
            let Some(value) = self.get(key.name) else {
                continue;
            };
            let values = match value {
                Value::Number(number) => vec![json!(number)],
                Value::Whole(number) => vec![json!(number)],
                Value::Word(word) if matches!(key.kind, Kind::Response) => {
                    vec![json!(word.trim_matches('"'))]
                }
                Value::Word(word) => vec![json!(word)],
                Value::Flag(flag) => vec![json!(flag.to_string())],
                Value::Threshold(thresholds) => {
                    thresholds.columns(&mut row);
                    continue;
                }
                Value::Refractory { us, rule } => vec![json!(us), json!(rule)],
            };
            let names = key.columns.iter().map(|(_, (name, ..))| (*name).to_owned());
            row.extend(names.zip(values));
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::sweep::points::thresholds::PerKind;

    fn word(text: &str) -> Value {
        Value::Word(text.to_owned())
    }

    #[test]
    fn what_plays_no_part_is_not_in_a_point() {
        let array = |domain: &str, seed| {
            let values = [
                ("domain", word(domain)),
                ("quantise", word("none")),
                ("sum", word("zero")),
                ("seed", Value::Whole(seed)),
            ];
            Point::new(Side::Array, values)
        };
        assert_eq!(array("exact", 1), array("exact", 2));
        assert_ne!(array("silicon", 1), array("silicon", 2));
        assert_eq!(array("exact", 1).get("sum"), None);
        let float = |sigma, seed| {
            let thresholds = Thresholds {
                sigma: PerKind::Each(vec![0.0, sigma]),
                ..Thresholds::both(8.0)
            };
            let values = [
                ("threshold", Value::Threshold(thresholds)),
                ("noise", word("none")),
                ("seed", Value::Whole(seed)),
            ];
            Point::new(Side::Reference, values)
        };
        assert_eq!(float(0.0, 1), float(0.0, 2));
        assert_ne!(float(0.1, 1), float(0.1, 2));
    }
}
