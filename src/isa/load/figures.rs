//! The quantities of a chip.

use std::collections::BTreeMap;

use crate::config::{Fault, Faults, suggestion};

use super::{
    super::{Figure, FigureRange, Quantity},
    file::Placed,
    layers::Layer,
};

pub(super) fn figures(layers: &[Layer]) -> Result<Vec<Quantity>, Faults> {
    let mut found: BTreeMap<Figure, Quantity> = BTreeMap::new();
    for layer in layers {
        let mut faults = Vec::new();
        for (section, key, entry) in &layer.device.figures {
            let name = format!("{section}.{}", key.value);
            let figure = Figure::ALL
                .iter()
                .find(|f| f.key() == (section.as_str(), key.value.as_str()));
            let Some(&figure) = figure else {
                let known: Vec<String> = Figure::ALL
                    .iter()
                    .map(|f| format!("{}.{}", f.key().0, f.key().1))
                    .collect();
                faults.push(
                    Fault::error(key.place, format!("unknown figure `{name}`"), "this key").help(
                        suggestion(&name, known.iter().map(String::as_str))
                            .unwrap_or_else(|| format!("known are {}", known.join(", "))),
                    ),
                );
                continue;
            };
            if let Some(fault) = wrong_quantity(figure, entry) {
                faults.push(fault);
            }
            found.insert(figure, entry.value.clone());
        }
        layer.wrong("device.toml", faults)?;
    }
    let top = &layers[layers.len() - 1];
    let mut faults = Vec::new();
    let missing: Vec<String> = Figure::ALL
        .iter()
        .filter(|figure| !found.contains_key(figure))
        .map(|figure| format!("{}.{} ({})", figure.key().0, figure.key().1, figure.unit()))
        .collect();
    if !missing.is_empty() {
        faults.push(
            Fault::error(
                top.device.name.place,
                format!(
                    "{} figures are missing: {}",
                    missing.len(),
                    missing.join(", ")
                ),
                "this chip",
            )
            .help("state each under [figure.<section>], or extend a chip that does"),
        );
    }
    if let (Some(low), Some(high)) = (found.get(&Figure::Lowest), found.get(&Figure::Highest)) {
        faults.extend(wrong_range(low.value, high.value, top));
    }
    top.wrong("device.toml", faults)?;
    Ok(found.into_values().collect())
}

/// What is wrong with the range of an analogue register.
fn wrong_range(low: f64, high: f64, top: &Layer) -> Option<Fault> {
    let (what, help) = if low >= high {
        (
            format!("range.low ({low}) is not below range.high ({high})"),
            "swap them",
        )
    } else if low > 0.0 || high < 0.0 {
        (
            format!("0 is not in the range, from range.low ({low}) to range.high ({high})"),
            "give a range that holds 0, which a register holds that was never written",
        )
    } else {
        return None;
    };
    // Of both, that which is new here.
    let mut own = { top.device.figures.iter().rev() }.filter(|(section, ..)| section == "range");
    let place = own.next().map(|(_, _, stated)| stated.place);
    let place = place.unwrap_or(top.device.name.place);
    Some(Fault::error(place, what, "this figure").help(help))
}

fn wrong_quantity(figure: Figure, entry: &Placed<Quantity>) -> Option<Fault> {
    let (section, key) = figure.key();
    let name = format!("{section}.{key}");
    wrong(&name, (figure.unit(), figure.range()), entry)
}

/// What is wrong with a quantity of this name, unit and range.
pub(super) fn wrong(
    name: &str,
    (wanted, range): (&str, FigureRange),
    entry: &Placed<Quantity>,
) -> Option<Fault> {
    let Quantity {
        value,
        unit,
        source,
        ..
    } = &entry.value;
    let wrong = if unit != wanted {
        format!("`{name}` is stated in `{wanted}`, not in `{unit}`")
    } else if !range.holds(*value) {
        let found = shown(*value);
        format!("`{name}` is {}, not {found}", range.instead_of(*value))
    } else if source.trim().is_empty() {
        format!("`{name}` has no source")
    } else {
        wrong_interval(name, range, &entry.value)?
    };
    Some(Fault::error(entry.place, wrong, "this figure").help(
        "write { value = …, unit = …, source = …, evidence = measured|quoted|modelled|guess }",
    ))
}

/// What is wrong with an interval: an end that makes no sense, or one beyond the value.
fn wrong_interval(name: &str, range: FigureRange, stated: &Quantity) -> Option<String> {
    let [low, high] = stated.interval.as_ref()?.ends();
    if let Some(end) = [low, high].into_iter().find(|end| !range.holds(*end)) {
        let (expected, found) = (range.instead_of(end), shown(end));
        return Some(format!("`{name}` is {expected}, not {found}"));
    }
    let beyond = !(low..=high).contains(&stated.value);
    beyond.then(|| {
        let value = stated.value;
        format!("`{name}` is {value}, which is not from {low} to {high}")
    })
}

/// A number in few digits, however large.
fn shown(value: f64) -> String {
    if value.abs() < 1e15 {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
