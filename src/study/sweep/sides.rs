//! The sides of a study file, each with its axes.

use toml::{
    Spanned,
    de::{DeString, DeTable, DeValue},
};

use super::{
    entry::{self, Read},
    grid::{Axes, Axis},
    key::{Absent, Key, Side},
    read,
    study::{Entry, Reader, SETTINGS},
    value::Values,
};
use crate::config::{Fault, Place};

impl Reader<'_> {
    /// The axes of every side; what stands above them holds for all that have the key.
    pub fn sides(
        &mut self,
        written: &Spanned<DeValue<'_>>,
        common: &[Entry<'_>],
        sampled: bool,
    ) -> Vec<Axes> {
        let DeValue::Array(list) = written.get_ref() else {
            let fault = entry::kind("side", written, "[[side]] tables");
            self.faults.push(fault);
            return Vec::new();
        };
        let mut all = Vec::new();
        for item in list {
            let DeValue::Table(table) = item.get_ref() else {
                let fault = entry::kind("side", item, "[[side]] tables");
                self.faults.push(fault);
                continue;
            };
            all.extend(self.side(table, item.span().into(), common, sampled));
        }
        if list.is_empty() {
            let what = "the list of sides is empty";
            self.faults.push(
                Fault::error(written.span().into(), what, "here")
                    .help("add [[side]] with side = \"reference\", \"array\" or \"mesh\""),
            );
        }
        all
    }

    fn side(
        &mut self,
        table: &DeTable<'_>,
        place: Place,
        common: &[Entry<'_>],
        sampled: bool,
    ) -> Option<Axes> {
        let names = Side::ALL.map(Side::name);
        let Some(kind) = table.get("side") else {
            self.faults.push(
                Fault::error(place, "a [[side]] that does not say which", "here")
                    .help("add side = \"reference\", \"array\" or \"mesh\""),
            );
            return None;
        };
        let word = entry::word("side", kind)
            .and_then(|word| entry::one_of("side", word, &names, kind.span().into()));
        let word = self.keep(word)?;
        let side = Side::ALL.into_iter().find(|side| side.name() == word)?;
        let mut known = vec!["side"];
        known.extend(Key::of(side).map(|key| key.name));
        for key in table.keys() {
            if !known.contains(&key.get_ref().as_ref()) {
                let fault = misplaced(key, side, &known);
                self.faults.push(fault);
            }
        }
        let mut axes = Vec::new();
        for key in Key::of(side) {
            let own = table.get_key_value(key.name);
            let own = own.or_else(|| {
                let found = common.iter().find(|(name, _)| name.get_ref() == key.name);
                found.map(|(name, written)| (*name, *written))
            });
            let read = match own {
                Some((_, written)) => axis(key, written, sampled).map(Some),
                None => absent(key, side, place),
            };
            axes.extend(self.keep(read).flatten());
        }
        Some(Axes { side, axes, place })
    }

    /// An axis that no side has would change nothing.
    pub fn unused(&mut self, axes: &[Entry<'_>], sides: &[Axes]) {
        if sides.is_empty() {
            return;
        }
        for (key, _) in axes {
            let name = key.get_ref().as_ref();
            let has = |axes: &Axes| Key::of(axes.side).any(|key| key.name == name);
            if !sides.iter().any(has) {
                let who: Vec<_> = Side::ALL
                    .iter()
                    .filter(|side| Key::of(**side).any(|key| key.name == name))
                    .map(|side| format!("\"{side}\""))
                    .collect();
                let what = format!("`{name}` is set, and no side of this study has it");
                self.faults.push(
                    Fault::error(key.span().into(), what, "changes nothing").help(format!(
                        "leave it out, or add a [[side]] with side = {}",
                        who.join(" or ")
                    )),
                );
            }
        }
    }
}

fn axis(key: &'static Key, written: &Spanned<DeValue<'_>>, sampled: bool) -> Read<Axis> {
    let values = read::values(key, written)?;
    let place: Place = written.span().into();
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
            let value = DeValue::parse(text)
                .map_err(|e| Fault::error(place, e.message().to_owned(), "here"))?;
            let mut axis = axis(key, &value, true)?;
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
fn misplaced(key: &Spanned<DeString<'_>>, side: Side, known: &[&str]) -> Fault {
    let name = key.get_ref().as_ref();
    let others: Vec<_> = Side::ALL
        .iter()
        .filter(|other| Key::of(**other).any(|key| key.name == name))
        .map(|other| format!("\"{other}\""))
        .collect();
    if others.is_empty() {
        let every = SETTINGS.iter().any(|(known, _)| *known == name);
        let fault = entry::unknown(key, known, &format!("of side = \"{side}\""));
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
        key.span().into(),
        format!("side = \"{side}\" has no `{name}`"),
        "contradicts the side",
    )
    .help(instead)
}
