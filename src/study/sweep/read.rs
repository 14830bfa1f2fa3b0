//! From TOML to the values of a key.

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use super::{
    entry::{Parts, Read, at, in_range, kind, number, one_of, whole, whole_in_range, word},
    key::{Key, Kind},
    value::{Ramp, Value, Values},
};
use crate::{
    config::{self, Fault, Node, Place},
    photoreceptor::{Curve, Response},
    reference::{Noise, keys::FILE},
};

/// The values of a key: one, a list, or a range.
pub(super) fn values(key: &Key, written: &Spanned<DeValue<'_>>) -> Read<Values> {
    match written.get_ref() {
        DeValue::Array(list) => {
            let one = |item: &Spanned<DeValue<'_>>| Ok((value(key, item)?, at(item.span())));
            list.iter().map(one).collect::<Read<_>>().map(Values::List)
        }
        DeValue::Table(table) if key.ranges() && table.contains_key("from") => {
            ramp(key, table, at(written.span())).map(Values::Ramp)
        }
        _ => Ok(Values::List(vec![(
            value(key, written)?,
            at(written.span()),
        )])),
    }
}

/// One value.
pub(super) fn value(key: &Key, written: &Spanned<DeValue<'_>>) -> Read<Value> {
    let place = at(written.span());
    let name = key.name;
    match key.kind {
        Kind::Name => {
            let word = word(name, written)?;
            if word.is_empty() {
                return Err(Fault::error(place, format!("`{name}` is empty"), "here")
                    .help(format!("give {}", key.what)));
            }
            Ok(Value::Word(word.to_owned()))
        }
        Kind::Number { least, above } => {
            let number = number(name, written)?;
            in_range(name, number, least, above, place)?;
            Ok(Value::Number(number))
        }
        Kind::Whole { least, most } => {
            let number = whole(name, written)?;
            whole_in_range(name, number, least..=most, place)?;
            Ok(Value::Whole(number))
        }
        Kind::Choice(words) => {
            let word = word(name, written)?;
            one_of(name, word, words, place).map(|word| Value::Word(word.to_owned()))
        }
        Kind::Spelled(spell) => {
            let word = word(name, written)?;
            let spelled = spell(word);
            spelled
                .map(Value::Word)
                .map_err(|(what, help)| Fault::error(place, what, "here").help(help))
        }
        Kind::Threshold => threshold(name, written),
        Kind::Refractory => refractory(name, written),
        Kind::Noise => noise(written),
        Kind::Response => response(written),
    }
}

fn threshold(name: &str, written: &Spanned<DeValue<'_>>) -> Read<Value> {
    let place = at(written.span());
    let DeValue::Table(table) = written.get_ref() else {
        let both = number(name, written)?;
        in_range(name, both, 0.0, true, place)?;
        return Ok(Value::Threshold {
            on: both,
            off: both,
            sigma: 0.0,
        });
    };
    let mut parts = Parts::of(name, table, &["on", "off", "sigma"], place)?;
    let on = parts.number("on", None)?;
    let off = parts.number("off", None)?;
    let sigma = parts.number("sigma", Some(0.0))?;
    in_range("threshold.on", on, 0.0, true, place)?;
    in_range("threshold.off", off, 0.0, true, place)?;
    in_range("threshold.sigma", sigma, 0.0, false, place)?;
    Ok(Value::Threshold { on, off, sigma })
}

fn refractory(name: &str, written: &Spanned<DeValue<'_>>) -> Read<Value> {
    let place = at(written.span());
    let DeValue::Table(table) = written.get_ref() else {
        return Err(kind(name, written, "{ us = 1000 }"));
    };
    let mut parts = Parts::of(name, table, &["us", "rule"], place)?;
    let us = parts.number("us", None)?;
    in_range("refractory.us", us, 0.0, false, place)?;
    let rule = match parts.take("rule") {
        None => "dead-time",
        Some(rule) => one_of(
            "refractory.rule",
            word("refractory.rule", rule)?,
            &["dead-time", "authors"],
            at(rule.span()),
        )?,
    };
    Ok(Value::Refractory { us, rule })
}

/// The `[noise]` of `sensors/dvs-noisy.toml`; a test holds it to the file.
const NOISY: Noise = Noise {
    cutoff_hz: 30.0,
    leak_hz: 0.1,
    leak_spread: 0.1,
    shot_hz: 5.0,
    shot_at_white: 0.25,
    ..Noise::NONE
};

fn noise(written: &Spanned<DeValue<'_>>) -> Read<Value> {
    let place = at(written.span());
    let noise = match written.get_ref() {
        DeValue::String(name) => match one_of("noise", name, &["none", "noisy"], place)? {
            "noisy" => NOISY,
            _ => Noise::NONE,
        },
        _ => {
            let kind = config::Kind::Table(&Noise::TABLE);
            Noise::stated(kind.check(Node::new(written), "noise", FILE.see)?)?
        }
    };
    Ok(Value::Word(noise_text(&noise)))
}

/// The keys that are not as in a sensor without noise.
fn noise_text(noise: &Noise) -> String {
    let none = Noise::NONE;
    let all = [
        ("leak-hz", noise.leak_hz, none.leak_hz),
        ("leak-spread", noise.leak_spread, none.leak_spread),
        ("shot-hz", noise.shot_hz, none.shot_hz),
        ("shot-at-white", noise.shot_at_white, none.shot_at_white),
        ("hot-fraction", noise.hot_fraction, none.hot_fraction),
        ("hot-hz", noise.hot_hz, none.hot_hz),
        ("jitter-us", noise.jitter_us, none.jitter_us),
        ("cutoff-hz", noise.cutoff_hz, none.cutoff_hz),
    ];
    let told: Vec<String> = all
        .iter()
        .filter(|(_, value, none)| value != none)
        .map(|(name, value, _)| format!("{name} = {value:?}"))
        .collect();
    if told.is_empty() {
        return "none".to_owned();
    }
    format!("{{ {} }}", told.join(", "))
}

fn response(written: &Spanned<DeValue<'_>>) -> Read<Value> {
    let Response { curve, round_f32 } =
        Response::read(Response::KIND.check(Node::new(written), "response", FILE.see)?)?;
    let round = if round_f32 { ", round = \"f32\"" } else { "" };
    Ok(Value::Word(match curve {
        Curve::Identity => "\"identity\"".to_owned(),
        Curve::Linear { white } if round_f32 => {
            format!("{{ linear = {{ white = {white:?}{round} }} }}")
        }
        Curve::Linear { white } => format!("{{ linear = {white:?} }}"),
        Curve::Log { white, offset } => {
            format!("{{ log = {{ white = {white:?}, offset = {offset:?}{round} }} }}")
        }
        Curve::LinLog { knee } => format!("{{ lin-log = {{ knee = {knee:?} }} }}"),
    }))
}

fn ramp(key: &Key, table: &DeTable<'_>, place: Place) -> Read<Ramp> {
    let name = key.name;
    let is_whole = matches!(key.kind, Kind::Whole { .. });
    let mut parts = Parts::of(name, table, &["from", "to", "steps", "log"], place)?;
    let (from, to) = (parts.number("from", None)?, parts.number("to", None)?);
    let log = match parts.take("log") {
        None => false,
        Some(given) => match given.get_ref() {
            DeValue::Boolean(log) => *log,
            _ => return Err(kind("log", given, "true or false")),
        },
    };
    let mut steps = match parts.take("steps") {
        None => None,
        Some(given) => {
            let steps = whole("steps", given)?;
            whole_in_range("steps", steps, 2..=u64::MAX, at(given.span()))?;
            Some(steps)
        }
    };
    let wrong = |what: String, help: &str| Err(Fault::error(place, what, "here").help(help));
    for end in [from, to] {
        match key.kind {
            Kind::Number { least, above } => in_range(name, end, least, above, place)?,
            Kind::Whole { least, most } => {
                if end.fract() != 0.0 || end < 0.0 || end > 2f64.powi(53) {
                    return wrong(
                        format!("`{name}` ends at {end}"),
                        "give whole numbers up to 2^53",
                    );
                }
                whole_in_range(name, end as u64, least..=most, place)?;
            }
            _ => in_range(name, end, 0.0, true, place)?,
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
        let text = include_str!("../../../sensors/dvs-noisy.toml");
        let none = |name: &str| Err(std::io::Error::other(name.to_owned()));
        let sensor = Description::parse("dvs-noisy.toml", text, &none).unwrap();
        assert_eq!(sensor.noise, NOISY);
    }
}
