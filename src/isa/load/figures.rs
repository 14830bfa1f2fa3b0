//! The quantities and registers of a chip.

use std::collections::BTreeMap;

use crate::config::{Fault, Faults, suggestion, suggestion_or};
use crate::limit::ALIASES;

use super::{
    super::{Analog, Digital, Figure, Quantity, Registers, Roles},
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
    if let (Some(low), Some(high)) = (found.get(&Figure::Lowest), found.get(&Figure::Highest))
        && low.value >= high.value
    {
        faults.push(
            Fault::error(
                top.device.name.place,
                format!(
                    "range.low ({}) is not below range.high ({})",
                    low.value, high.value
                ),
                "this chip",
            )
            .help("swap them"),
        );
    }
    top.wrong("device.toml", faults)?;
    Ok(found.into_values().collect())
}

pub(super) fn wrong_quantity(figure: Figure, entry: &Placed<Quantity>) -> Option<Fault> {
    let Quantity {
        value,
        unit,
        source,
        ..
    } = &entry.value;
    let (section, key) = figure.key();
    let wrong = if unit != figure.unit() {
        format!(
            "`{section}.{key}` is stated in `{}`, not in `{unit}`",
            figure.unit()
        )
    } else if !figure.domain().holds(*value) {
        format!(
            "`{section}.{key}` is {}, not {value}",
            figure.domain().instead_of(*value)
        )
    } else if source.trim().is_empty() {
        format!("`{section}.{key}` has no source")
    } else {
        wrong_interval(figure, &entry.value)?
    };
    Some(Fault::error(entry.place, wrong, "this figure").help(
        "write { value = …, unit = …, source = …, evidence = measured|quoted|modelled|guess }",
    ))
}

/// What is wrong with an interval: an end that makes no sense, or one beyond the value.
fn wrong_interval(figure: Figure, stated: &Quantity) -> Option<String> {
    let (section, key) = figure.key();
    let [low, high] = stated.interval.as_ref()?.ends();
    let domain = figure.domain();
    if let Some(end) = [low, high].into_iter().find(|end| !domain.holds(*end)) {
        let expected = domain.instead_of(end);
        return Some(format!("`{section}.{key}` is {expected}, not {end}"));
    }
    let beyond = !(low..=high).contains(&stated.value);
    beyond.then(|| {
        let value = stated.value;
        format!("`{section}.{key}` is {value}, which is not from {low} to {high}")
    })
}

pub(super) fn registers(layers: &[Layer]) -> Result<Registers, Faults> {
    let top = &layers[layers.len() - 1];
    let parts = || {
        layers
            .iter()
            .rev()
            .filter_map(|l| l.device.registers.as_ref())
    };
    let missing = |what: &str| -> Result<Registers, Faults> {
        let fault = Fault::error(
            top.device.name.place,
            format!("`registers.{what}` is missing"),
            "this chip",
        )
        .help("state it, or extend a chip that does");
        Err(Faults::one(
            &format!("{}/device.toml", top.folder.name),
            &top.folder.device,
            fault,
        ))
    };
    let Some(analog) = parts().find_map(|r| r.analogue.as_ref()) else {
        return missing("analogue");
    };
    let Some(digital) = parts().find_map(|r| r.digital.as_ref()) else {
        return missing("digital");
    };
    let Some(news) = parts().find_map(|r| r.news.as_ref()) else {
        return missing("news");
    };
    let Some(roles) = parts().find_map(|r| r.roles.as_ref()) else {
        return missing("roles");
    };
    let mut faults = wrong_lists(top, analog, digital);
    let mut find = |list: &[Placed<String>], name: &Placed<String>, what: &str| -> u8 {
        let at = list.iter().position(|n| n.value == name.value);
        if at.is_none() {
            let names = list.iter().map(|n| n.value.as_str());
            faults.push(
                Fault::error(
                    name.place,
                    format!("`{}` is not {what} register", name.value),
                    "this name",
                )
                .help(suggestion_or(&name.value, names, "name one of the list")),
            );
        }
        at.unwrap_or(0) as u8
    };
    let news = Analog(find(analog, news, "an analogue"));
    let mut bit = |name: &Placed<String>| Digital(find(digital, name, "a one-bit"));
    let roles = Roles {
        mask: bit(&roles.mask),
        propagated: bit(&roles.propagated),
        enable: roles.enable.each_ref().map(&mut bit),
    };
    let mut aliases: Vec<(String, Digital)> = Vec::new();
    for part in parts() {
        for (alias, name) in &part.aliases {
            // One more than there can be tells enough.
            if aliases.len() <= ALIASES && !aliases.iter().any(|(known, _)| known == alias) {
                aliases.push((alias.clone(), bit(name)));
            }
        }
    }
    if aliases.len() > ALIASES {
        let what = format!("too many other names: {ALIASES} aliases at most");
        let place = top.device.name.place;
        faults.push(Fault::error(place, what, "this chip").help("leave some out"));
    }
    let owner = layers.iter().rev().find(|l| l.device.registers.is_some());
    owner.unwrap_or(top).wrong("device.toml", faults)?;
    let plain = |list: &[Placed<String>]| list.iter().map(|n| n.value.clone()).collect();
    Ok(Registers {
        analog: plain(analog),
        news,
        digital: plain(digital),
        aliases,
        roles,
    })
}

/// Names that stand twice, and lists that are empty or too long.
pub(super) fn wrong_lists(
    top: &Layer,
    analog: &[Placed<String>],
    digital: &[Placed<String>],
) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    for name in analog.iter().chain(digital) {
        if seen.contains(&name.value.as_str()) {
            faults.push(
                Fault::error(
                    name.place,
                    format!("two registers are called `{}`", name.value),
                    "the second",
                )
                .help("every register has a name of its own"),
            );
        }
        seen.push(&name.value);
    }
    for (what, list) in [("analogue", analog), ("one-bit", digital)] {
        if list.is_empty() || list.len() > 64 {
            faults.push(
                Fault::error(
                    top.device.name.place,
                    format!("{} {what} registers; there can be 1 to 64", list.len()),
                    "this chip",
                )
                .help("list their names"),
            );
        }
    }
    faults
}
