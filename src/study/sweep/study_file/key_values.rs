//! From a document to the values of a key.

use super::key::{Key, Kind};
use crate::{
    config::{self, Fault, Node, Range, Read, Section, Table},
    mesh::Between,
    photoreceptor::Response,
    reference::{Noise, RefractoryRule, keys::REFRACTORY},
    study::sweep::points::{
        thresholds::Thresholds,
        value::{Ramp, Value, Values},
    },
};

/// What to do where nothing better can be said.
pub(in crate::study::sweep) const SEE: &str = "docs/sweeps.md lists every key of a study";

/// The values of a key: one, a list, or a range.
pub(super) fn values(key: &Key, node: Node<'_>) -> Read<Values> {
    if let Some(list) = node.as_list() {
        let one = |item: Node<'_>| Ok((value(key, item)?, item.place()));
        return list
            .into_iter()
            .map(one)
            .collect::<Read<_>>()
            .map(Values::List);
    }
    if key.ranges() && node.get("from").is_some() {
        return ramp(key, node).map(Values::Ramp);
    }
    Ok(Values::List(vec![(value(key, node)?, node.place())]))
}

/// One value.
pub(in crate::study::sweep) fn value(key: &Key, node: Node<'_>) -> Read<Value> {
    key.kind.value_kind().check(node, key.name, SEE)?;
    let word = node.as_text().unwrap_or_default();
    match key.kind {
        Kind::Name | Kind::Choice(_) => Ok(Value::Word(word.to_owned())),
        Kind::Number { .. } => Ok(Value::Number(node.as_number().unwrap_or_default())),
        Kind::Whole { .. } => Ok(Value::Whole(node.as_whole().unwrap_or_default())),
        Kind::Spelled(spell, _) => spell(word)
            .map(Value::Word)
            .map_err(|(what, help)| Fault::error(node.place(), what, "here").help(help)),
        Kind::Flag => Ok(Value::Flag(node.as_flag().unwrap_or_default())),
        Kind::Threshold => {
            let thresholds = match node.as_number() {
                Some(both) => Thresholds::both(both),
                None => Thresholds::read(node)?,
            };
            Ok(Value::Threshold(thresholds))
        }
        Kind::Refractory => {
            let refractory = Section::new(node, &REFRACTORY);
            let rule = refractory.word("rule", RefractoryRule::ALL)?;
            Ok(Value::Refractory {
                us: refractory.number("us")?,
                rule: rule.unwrap_or_default().word(),
            })
        }
        Kind::Noise => {
            let noise = match node.as_text() {
                Some("noisy") => NOISY,
                Some(_) => Noise::NONE,
                None => Noise::stated(node)?,
            };
            Ok(Value::Word(noise_text(&noise)))
        }
        Kind::Response => Ok(Value::Word(Response::read(node)?.text())),
    }
}

/// The `[noise]` of `sensors/dvs-noisy.toml`; a test holds it to the file.
const NOISY: Noise = Noise {
    cutoff_hz: 30.0,
    cutoff_rule: Between::Step,
    leak_hz: 0.1,
    leak_spread: 0.1,
    shot_hz: 5.0,
    shot_at_white: 0.25,
    ..Noise::NONE
};

/// The keys that are not as in a sensor without noise.
fn noise_text(noise: &Noise) -> String {
    let none = Noise::NONE;
    let all = noise.numbers().into_iter().zip(none.numbers());
    let mut pairs: Vec<String> = all
        .filter(|(own, none)| own != none)
        .map(|((key, value), _)| format!("{key} = {value:?}"))
        .collect();
    if noise.cutoff_rule != none.cutoff_rule {
        pairs.push(format!("cutoff-rule = \"{}\"", noise.cutoff_rule));
    }
    if pairs.is_empty() {
        return "none".to_owned();
    }
    format!("{{ {} }}", pairs.join(", "))
}

/// The keys of a range.
pub(super) const RAMP: Table = Table::new(&[
    config::Key::required(
        "from",
        config::Kind::Number(Range::FINITE),
        "the first value",
    ),
    config::Key::required("to", config::Kind::Number(Range::FINITE), "the last value"),
    config::Key::optional(
        "steps",
        config::Kind::Whole {
            least: 2,
            most: i64::MAX as u64,
        },
        "how many values, ends included; any number between when left out",
    ),
    config::Key::with_default(
        "log",
        config::Kind::Flag,
        "false",
        "equal factors instead of equal steps",
    ),
]);

fn ramp(key: &Key, node: Node<'_>) -> Read<Ramp> {
    let (name, place) = (key.name, node.place());
    config::Kind::Table(&RAMP).check(node, name, SEE)?;
    let parts = Section::new(node, &RAMP);
    let (from, to) = (parts.number("from")?, parts.number("to")?);
    let log = parts.flag("log");
    let mut steps = parts.maybe_whole("steps");
    let is_whole = matches!(key.kind, Kind::Whole { .. });
    let wrong = |what: String, help: &str| Err(Fault::error(place, what, "here").help(help));
    for end in [from, to] {
        let range = match key.kind {
            Kind::Number { least, above } => Range {
                above,
                ..Range::least(least)
            },
            Kind::Whole { least, most } => {
                if end.fract() != 0.0 || end < 0.0 || end > 2f64.powi(53) {
                    return wrong(
                        format!("`{name}` ends at {end}"),
                        "give whole numbers up to 2^53",
                    );
                }
                Range::between(least as f64, most as f64)
            }
            _ => Range::POSITIVE,
        };
        if !range.holds(end) {
            let help = format!("give {}", range.words());
            return wrong(format!("`{name}` is {end}"), &help);
        }
    }
    if from >= to {
        return wrong(
            format!("`{name}` goes from {from} to {to}"),
            "give a lower end below the upper one, or one value",
        );
    }
    if log && from <= 0.0 {
        return wrong(
            format!("`{name}` goes from {from} in equal factors"),
            "give a lower end above zero, or leave `log` out",
        );
    }
    if is_whole {
        let all = (to - from) as u64 + 1;
        if log || steps.is_some_and(|steps| steps != all) {
            return wrong(
                format!("`{name}` counts in whole numbers"),
                "leave `log` and `steps` out: every whole number from one end to the other is taken",
            );
        }
        steps = Some(all);
    }
    Ok(Ramp {
        from,
        to,
        steps,
        log,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Description;

    #[test]
    fn the_noisy_preset_is_the_sensor_files() {
        let text = include_str!("../../../../sensors/dvs-noisy.toml");
        let none = |name: &str| Err(std::io::Error::other(name.to_owned()));
        let sensor = Description::parse("dvs-noisy.toml", text, &none).unwrap();
        assert_eq!(sensor.noise, NOISY);
    }
}
