//! Messages in the words of Python.

use super::{InPython, OPTIONS, is_command};
use crate::order::Order as _;

/// What a message of too much memory ends with: Python has no such argument.
const MORE_MEMORY: &str = ", or allow more with --max-memory";

/// A message with arguments of Python in place of options. Commands in backticks are left as they are,
/// but for the name of the program.
#[must_use]
pub fn in_python(text: &str) -> String {
    let mut text = text.to_owned();
    if let Some(at) = text.find(MORE_MEMORY) {
        let end = text[at..].find('\n').map_or(text.len(), |line| at + line);
        text.replace_range(at..end, "");
    }
    // A phrase may stand in a longer one.
    let mut phrases: Vec<_> = { OPTIONS.iter() }
        .flat_map(|advised| advised.phrases)
        .collect();
    phrases.order_by(|(a, _), (b, _)| b.len().cmp(&a.len()));
    for (option, argument) in phrases {
        text = text.replace(option, argument);
    }
    let parts = text.split('`').enumerate().map(|(n, part)| {
        if is_command(n, part) && is_of_verb(part) {
            format!("amacrine {part}")
        } else if is_command(n, part) {
            part.to_owned()
        } else {
            renamed(part)
        }
    });
    parts.collect::<Vec<_>>().join("`")
}

/// Whether a command begins with a verb of the program: `exec --set …`.
fn is_of_verb(command: &str) -> bool {
    let verb = command.split_once(" --").map_or("", |(verb, _)| verb);
    !verb.is_empty() && verb.bytes().all(|letter| letter.is_ascii_lowercase())
}

/// What stands between backticks, or in them.
fn renamed(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, found) = rest.split_at(at);
        out.push_str(before);
        let name = &found[2..];
        let end = name
            .find(|c: char| !(c.is_ascii_lowercase() || c == '-'))
            .unwrap_or(name.len());
        let (name, after) = name.split_at(end);
        let call = of_sensor(&out, name, after).or_else(|| of_readout(&out, name, after));
        if let Some((call, behind)) = call {
            out += &call;
            rest = behind;
            continue;
        }
        let known = OPTIONS.iter().find(|advised| advised.option == name);
        let is_word = match known.map(|advised| advised.python) {
            Some(InPython::Word) => Some(true),
            Some(InPython::Number) => Some(false),
            Some(InPython::Phrases | InPython::Typed(_)) | None => None,
        };
        let Some(is_word) = is_word else {
            out.push_str("--");
            out.push_str(name);
            rest = after;
            continue;
        };
        out.push_str(&name.replace('-', "_"));
        rest = after;
        if let Some(value) = value(after, is_word) {
            out.push('=');
            let quote = if is_word && !is_placeholder(value) {
                "\""
            } else {
                ""
            };
            out.extend([quote, value, quote]);
            rest = &after[1 + value.len()..];
        }
    }
    out.push_str(rest);
    out
}

/// `(--without leak,mismatch)`, which of a sensor is a call of its own, and what stands behind it.
fn of_sensor<'a>(before: &str, name: &str, after: &'a str) -> Option<(String, &'a str)> {
    if name != "without" || !before.ends_with('(') {
        return None;
    }
    let (effects, _) = after.strip_prefix(' ')?.split_once(')')?;
    let each: Vec<_> = effects.split(',').map(|one| format!("\"{one}\"")).collect();
    let behind = &after[1 + effects.len()..];
    Some((format!("sensor.without({})", each.join(", ")), behind))
}

/// `(--with slots=VALUE)`, which a readout has as a key of its own, and what stands behind it.
fn of_readout<'a>(before: &str, name: &str, after: &'a str) -> Option<(String, &'a str)> {
    if name != "with" || !before.ends_with('(') {
        return None;
    }
    let (setting, _) = after.strip_prefix(' ')?.split_once(')')?;
    let (key, value) = setting.split_once('=')?;
    let behind = &after[1 + setting.len()..];
    Some((format!("readout={{…, \"{key}\": {value}}}"), behind))
}

/// What an option is given: a number, a placeholder, or a word where it takes one.
fn value(after: &str, is_word: bool) -> Option<&str> {
    let after = after.strip_prefix(' ')?;
    let end = after
        .find(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '-' | ':' | '.')))
        .unwrap_or(after.len());
    // Of a slice the points are a part.
    let value = match &after[..end] {
        slice if slice.ends_with("..") => slice,
        word => word.trim_end_matches(['.', ':']),
    };
    let is_number = value.parse::<f64>().is_ok();
    (!value.is_empty() && (is_number || is_word || is_placeholder(value))).then_some(value)
}

fn is_placeholder(value: &str) -> bool {
    value.chars().all(|c| c.is_ascii_uppercase())
}
