//! The sides of a study file: which sensors it varies, each with its axes.

use super::{
    key::{Absent, Key, Side},
    key_values::{self, SEE},
    study::{Entry, Reader, SETTINGS},
};
use crate::{
    config::{CHANGES_NOTHING, Document, Fault, Name, Node, Place, Read, choice, unknown_key},
    study::sweep::points::{
        grid::{Axes, Axis},
        value::Values,
    },
};

impl Reader<'_> {
    /// The axes of every side; what stands above them holds for all that have the key.
    pub fn sides(&mut self, node: Node<'_>, common: &[Entry<'_>], sampled: bool) -> Vec<Axes> {
        let list = node.as_list().unwrap_or_default();
        let wrong = list.iter().find(|side| side.as_table().is_none());
        let wrong = wrong.or(list.is_empty().then_some(&node));
        if let Some(wrong) = wrong {
            let what = format!("`side` takes [[side]] tables, this is {}", wrong.found());
            self.faults.push(
                Fault::error(wrong.place(), what, "here")
                    .help("add [[side]] with side = \"reference\", \"array\" or \"mesh\""),
            );
            return Vec::new();
        }
        let sides = list.into_iter();
        sides
            .filter_map(|side| self.side(side, common, sampled))
            .collect()
    }

    fn side(&mut self, table: Node<'_>, common: &[Entry<'_>], sampled: bool) -> Option<Axes> {
        let place = table.place();
        let Some(kind) = table.get("side") else {
            self.faults.push(
                Fault::error(place, "a [[side]] that does not say which", "here")
                    .help("add side = \"reference\", \"array\" or \"mesh\""),
            );
            return None;
        };
        let names = Side::ALL.map(Side::name);
        let word = kind.as_text().unwrap_or_default();
        let side = choice(word, &names, kind.place(), SEE);
        let side = Side::ALL[self.keep(side)?];
        let mut known = vec!["side"];
        known.extend(Key::on_side(side).map(|key| key.name));
        for (name, _) in table.as_table().unwrap_or_default() {
            if !known.contains(&name.text) {
                self.faults.push(misplaced(name, side, &known));
            }
        }
        let mut axes = Vec::new();
        for key in Key::on_side(side) {
            let own = table.get(key.name).or_else(|| {
                let found = common.iter().find(|(name, _)| name.text == key.name);
                found.map(|(_, node)| *node)
            });
            let read = match own {
                Some(node) => axis(key, node, sampled).map(Some),
                None => absent(key, side, place),
            };
            axes.extend(self.keep(read).flatten());
        }
        Some(Axes { side, axes, place })
    }

    /// An axis that no side takes would change nothing, and would not be checked either.
    pub fn unused(&mut self, axes: &[Entry<'_>], node: Node<'_>, sides: &[Axes]) {
        if sides.is_empty() {
            return;
        }
        let tables = node.as_list().unwrap_or_default();
        for (key, _) in axes {
            let name = key.text;
            let has = |axes: &Axes| Key::on_side(axes.side).any(|key| key.name == name);
            if !sides.iter().any(has) {
                let what = no_side_has(name);
                self.faults
                    .push(Fault::error(key.place, what, CHANGES_NOTHING).help(format!(
                        "leave it out, or add a [[side]] with {}",
                        sides_with(name)
                    )));
            } else if tables.iter().all(|side| takes_none(*side, name)) {
                let what = format!("`{name}` is set, and every side that has it sets its own");
                self.faults
                    .push(Fault::error(key.place, what, CHANGES_NOTHING).help("leave it out"));
            }
        }
    }
}

/// That a key is of no use, in words.
pub(super) fn no_side_has(name: &str) -> String {
    format!("`{name}` is set, and no side of this study has it")
}

/// The sides that have a key, as they are written.
pub(super) fn sides_with(name: &str) -> String {
    let has = |side: &&Side| Key::on_side(**side).any(|key| key.name == name);
    let who = Side::ALL
        .iter()
        .filter(has)
        .map(|side| format!("\"{side}\""));
    format!("side = {}", who.collect::<Vec<_>>().join(" or "))
}

/// Whether a side does without a key that stands above the sides.
pub(super) fn takes_none(side: Node<'_>, name: &str) -> bool {
    let kind = side.get("side").and_then(Node::as_text).unwrap_or_default();
    let kind = Side::ALL.into_iter().find(|side| side.name() == kind);
    side.get(name).is_some()
        || !kind.is_some_and(|kind| Key::on_side(kind).any(|key| key.name == name))
}

fn axis(key: &'static Key, node: Node<'_>, sampled: bool) -> Read<Axis> {
    let values = key_values::values(key, node)?;
    let place = node.place();
    let name = key.name;
    match &values {
        Values::List(list) if list.is_empty() => Err(Fault::error(
            place,
            format!("`{name}` has no values: the grid is empty"),
            "no value",
        )
        .help("give at least one value, or leave the key out for its default")),
        Values::Ramp(ramp) if ramp.steps.is_none() && !sampled => Err(Fault::error(
            place,
            format!("`{name}` is a range without `steps`, and a grid takes single values"),
            "here",
        )
        .help(format!(
            "add steps = 5, or draw points from the range with sample = {{ method = \"sobol\", points = {} }}",
            256
        ))),
        _ => Ok(Axis { key, values, place }),
    }
}

fn absent(key: &'static Key, side: Side, place: Place) -> Read<Option<Axis>> {
    match key.default {
        Absent::None => Ok(None),
        Absent::Required => Err(Fault::error(
            place,
            format!("side = \"{side}\" has no `{}`", key.name),
            "this side",
        )
        .help(format!("add {}: {}", key.name, key.what))),
        Absent::Is(text) => {
            let value = Document::value(text)?;
            let mut axis = axis(key, value.root(), true)?;
            axis.place = place;
            if let Values::List(list) = &mut axis.values {
                for (_, at) in list {
                    *at = place;
                }
            }
            Ok(Some(axis))
        }
    }
}

/// A key that this side does not have; another may.
fn misplaced(key: Name<'_>, side: Side, known: &[&'static str]) -> Fault {
    let name = key.text;
    let others: Vec<_> = Side::ALL
        .iter()
        .filter(|other| Key::on_side(**other).any(|key| key.name == name))
        .map(|other| format!("\"{other}\""))
        .collect();
    if others.is_empty() {
        let every = SETTINGS.iter().any(|known| known.name == name);
        let fault = unknown_key(key, known.iter().copied(), SEE);
        return if every {
            fault.help("it holds for the whole study: write it above the first [[side]]")
        } else {
            fault
        };
    }
    let otherwise = format!("it is a key of side = {}", others.join(" and "));
    let instead = match (side, name) {
        (Side::Array, "format") => "an array has a `domain` in place of a `format`".to_owned(),
        (Side::Reference | Side::Mesh, "domain") => {
            "a float sensor has a `format` in place of a `domain`".to_owned()
        }
        (Side::Mesh, "kernel") => "a mesh has a `lambda` in place of a kernel".to_owned(),
        _ => otherwise,
    };
    Fault::error(
        key.place,
        format!("side = \"{side}\" has no `{name}`"),
        "contradicts the side",
    )
    .help(instead)
}
