//! The thresholds of a point: the same for all kinds of its cells, or each kind's own.

use std::fmt;

use serde::Serialize;
use serde_json::{Map, Value as Json, json};

use crate::{
    config::{Document, Key, Kind, Node, Range, Read, Section, Table},
    limit::KERNELS,
    unit::counted,
};

/// The keys of a threshold that is a table.
pub(in crate::study::sweep) const TABLE: Table = Table::new(&[
    Key::required("on", POSITIVE, "for ON events").example("on = 8"),
    Key::required("off", POSITIVE, "for OFF events, a positive magnitude").example("off = 8"),
    Key::with_default(
        "sigma",
        NOT_NEGATIVE,
        "0",
        "standard deviation of the fixed-pattern mismatch, in the unit of the threshold",
    ),
]);

const POSITIVE: Kind = Kind::Either {
    ways: &[
        Kind::Number(Range::POSITIVE),
        each(&Kind::Number(Range::POSITIVE)),
    ],
    expected: "a number above 0, or a list with one for each kernel",
};

const NOT_NEGATIVE: Kind = Kind::Either {
    ways: &[
        Kind::Number(Range::NOT_NEGATIVE),
        each(&Kind::Number(Range::NOT_NEGATIVE)),
    ],
    expected: "a number from 0 on, or a list with one for each kernel",
};

const fn each(of: &'static Kind) -> Kind {
    Kind::List {
        of,
        least: 1,
        most: KERNELS,
    }
}

/// A number for all kinds of cells, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PerKind {
    /// For all.
    All(f64),
    /// For each, in the order of the kernels.
    Each(Vec<f64>),
}

impl PerKind {
    fn read(node: Node<'_>) -> Self {
        match node.as_list() {
            Some(list) => Self::Each(list.into_iter().filter_map(Node::as_number).collect()),
            None => Self::All(node.as_number().unwrap_or_default()),
        }
    }

    /// That of a kind; 0 where there is none.
    fn of(&self, kind: usize) -> f64 {
        match self {
            Self::All(all) => *all,
            Self::Each(each) => each.get(kind).copied().unwrap_or_default(),
        }
    }

    /// The number that all kinds have, if they have the same.
    fn same(&self) -> Option<f64> {
        match self {
            Self::All(all) => Some(*all),
            Self::Each(each) => {
                let (first, others) = each.split_first()?;
                others.iter().all(|other| other == first).then_some(*first)
            }
        }
    }
}

impl fmt::Display for PerKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, self.same()) {
            (_, Some(same)) => write!(f, "{same:?}"),
            (Self::All(all), None) => write!(f, "{all:?}"),
            (Self::Each(each), None) => write!(f, "{each:?}"),
        }
    }
}

/// Thresholds for ON and OFF and the deviation of their mismatch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Thresholds {
    /// Above zero.
    pub on: PerKind,
    /// A positive magnitude.
    pub off: PerKind,
    /// Deviation of the mismatch.
    pub sigma: PerKind,
}

impl Thresholds {
    /// One for both signs and all kinds.
    #[must_use]
    pub const fn both(threshold: f64) -> Self {
        Self {
            on: PerKind::All(threshold),
            off: PerKind::All(threshold),
            sigma: PerKind::All(0.0),
        }
    }

    /// Those of a checked table.
    pub(in crate::study::sweep) fn read(node: Node<'_>) -> Read<Self> {
        let section = Section::new(node, &TABLE);
        let sigma = section.get("sigma").map(PerKind::read);
        Ok(Self {
            on: PerKind::read(section.need("on")?),
            off: PerKind::read(section.need("off")?),
            sigma: sigma.unwrap_or(PerKind::All(0.0)),
        })
    }

    /// Those that a row has as one text.
    pub(in crate::study::sweep) fn written(text: &str) -> Option<Self> {
        let document = Document::value(text).ok()?;
        Self::read(document.root()).ok()
    }

    const fn named(&self) -> [(&'static str, &PerKind); 3] {
        [("on", &self.on), ("off", &self.off), ("sigma", &self.sigma)]
    }

    /// ON, OFF and the deviation of a kind.
    #[must_use]
    pub fn of(&self, kind: usize) -> [f64; 3] {
        self.named().map(|(_, number)| number.of(kind))
    }

    /// Whether any kind has mismatch.
    #[must_use]
    pub fn has_mismatch(&self) -> bool {
        match &self.sigma {
            PerKind::All(sigma) => *sigma > 0.0,
            PerKind::Each(each) => each.iter().any(|sigma| *sigma > 0.0),
        }
    }

    /// What is wrong with them for so many kinds.
    #[must_use]
    pub fn wrong_for(&self, kinds: usize) -> Option<String> {
        { self.named().into_iter() }.find_map(|(name, number)| match number {
            PerKind::Each(each) if each.len() != kinds => Some(format!(
                "`threshold.{name}` has {} for {}",
                counted(each.len(), "number"),
                counted(kinds, "kind")
            )),
            _ => None,
        })
    }

    /// Columns of a row: a number that all kinds have has one, and where kinds differ all of them
    /// are one text.
    pub(super) fn columns(&self, row: &mut Map<String, Json>) {
        let named = self.named();
        for (name, number) in named {
            if let Some(same) = number.same() {
                row.insert(format!("threshold_{name}"), json!(same));
            }
        }
        if named.iter().any(|(_, number)| number.same().is_none()) {
            row.insert("thresholds".to_owned(), json!(self.to_string()));
        }
    }
}

impl fmt::Display for Thresholds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { on, off, sigma } = self;
        write!(f, "{{ on = {on}, off = {off}, sigma = {sigma} }}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use PerKind::{All, Each};

    #[test]
    fn equal_numbers_are_written_as_one() {
        let columns = |on: PerKind| {
            let mut row = Map::new();
            let (off, sigma) = (All(8.0), All(0.0));
            Thresholds { on, off, sigma }.columns(&mut row);
            Json::from(row)
        };
        let same = json!({"threshold_on": 9.0, "threshold_off": 8.0, "threshold_sigma": 0.0});
        assert_eq!(columns(All(9.0)), same);
        assert_eq!(columns(Each(vec![9.0, 9.0])), same);
        let differ = json!({"threshold_off": 8.0, "threshold_sigma": 0.0,
            "thresholds": "{ on = [9.0, 7.5], off = 8.0, sigma = 0.0 }"});
        assert_eq!(columns(Each(vec![9.0, 7.5])), differ);
    }

    #[test]
    fn what_is_written_is_read_again() {
        let all = Thresholds {
            on: Each(vec![9.0, 7.5]),
            off: All(1e-9),
            sigma: Each(vec![0.0, 0.1 + 0.2]),
        };
        assert_eq!(Thresholds::written(&all.to_string()), Some(all));
        for other in ["", "8", "{ off = 8 }", "{ on = 8, off = 8"] {
            assert_eq!(Thresholds::written(other), None, "{other}");
        }
    }
}
