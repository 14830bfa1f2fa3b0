//! Keys of a study set on the command line: `format=f32,q8.8`, `sample.points=64`,
//! `array.domain=exact`.
//!
//! What is set is written into the study's text in place of what stands there, and then read as
//! any study is: a key that is written in the file and one that is set are the same point, and a
//! wrong one has the same message. A key without a side replaces what the top and every `[[side]]`
//! say of it; where it stands nowhere, it is written at the top.

use std::{fmt, str::FromStr};

use super::{
    key::{KEYS, Side},
    sides::{no_side_has, sides_with, takes_none},
    study::SETTINGS,
};
use crate::{
    config::{Document, Fault, Faults, Node, Place, on_one_line, suggestion_or},
    order::Order,
};

/// A key and what it is set to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// Where it stands, in parts.
    key: Vec<String>,
    /// TOML.
    value: String,
    /// As it was written.
    text: String,
}

/// No override.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is no key=value")]
#[diagnostic(help(
    "give key=value or key=a,b, such as format=f32,q8.8, sample.points=64 or array.domain=exact"
))]
pub struct OverrideError {
    /// What was given.
    pub text: String,
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for Override {
    type Err = OverrideError;

    fn from_str(text: &str) -> Result<Self, OverrideError> {
        let wrong = || OverrideError {
            text: text.to_owned(),
        };
        let (key, value) = text.split_once('=').ok_or_else(wrong)?;
        let key: Vec<String> = key.split('.').map(|part| part.trim().to_owned()).collect();
        let word = |part: &String| {
            !part.is_empty()
                && part
                    .chars()
                    .all(|c| c.is_ascii_alphanumeric() || "-_".contains(c))
        };
        if !key.iter().all(word) || value.trim().is_empty() {
            return Err(wrong());
        }
        let values: Vec<String> = parts(value).into_iter().map(toml).collect();
        let value = match &values[..] {
            [one] => one.clone(),
            several => format!("[{}]", several.join(", ")),
        };
        Ok(Self {
            key,
            value,
            text: text.to_owned(),
        })
    }
}

/// Parts of a list between commas that are in no brackets and in no quotes.
fn parts(text: &str) -> Vec<&str> {
    let (mut depth, mut quote, mut start, mut parts) = (0_usize, None, 0, Vec::new());
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), c) if open == c => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            (None, ',') if depth == 0 => {
                parts.push(text.get(start..at).unwrap_or_default());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text.get(start..).unwrap_or_default());
    parts
}

/// A value as TOML: what is none is a word.
fn toml(text: &str) -> String {
    let text = text.trim();
    match Document::value(text) {
        Ok(_) if !text.contains('\n') => text.to_owned(),
        _ => on_one_line(text),
    }
}

/// A change of the text: a place, and what stands there instead.
type Edit = (Place, String);

/// The text of a study with keys set.
///
/// # Errors
/// When the text is no TOML, or a key cannot be set.
pub fn overridden(file: &str, text: &str, overrides: &[Override]) -> Result<String, Faults> {
    let mut text = text.to_owned();
    for (n, one) in overrides.iter().enumerate() {
        if overrides[..n].iter().any(|before| before.key == one.key) {
            let key = one.key.join(".");
            let help = format!("give all values at once, with commas between: {key}=a,b");
            let fault = one.fault(format!("`{key}` is set twice"), help);
            return Err(Faults::one(&one.text, &one.text, fault));
        }
        let document = Document::parse(&text).map_err(|fault| Faults::one(file, &text, fault))?;
        let edits = one.edits(document.root(), &text);
        let mut edits = edits.map_err(|fault| Faults::one(&one.text, &one.text, fault))?;
        drop(document);
        edits.order_by_key(|(place, _)| std::cmp::Reverse(place.start));
        for (place, new) in edits {
            text.replace_range(place.start..place.end, &new);
        }
    }
    Ok(text)
}

impl Override {
    fn edits(&self, root: Node<'_>, text: &str) -> Result<Vec<Edit>, Fault> {
        let Some((first, rest)) = self.key.split_first() else {
            return Ok(Vec::new());
        };
        if let Some(side) = Side::ALL.into_iter().find(|side| side.name() == first) {
            return self.of_side(side, rest, root, text);
        }
        if KEYS.iter().any(|key| key.name == first) {
            let sides = root.get("side").and_then(Node::as_list).unwrap_or_default();
            // Above the sides it is for those that have it and do not set it themselves.
            let mut edits = Vec::new();
            if sides.is_empty()
                || root.get(first).is_some()
                || !sides.iter().all(|side| takes_none(*side, first))
            {
                edits = self.within(root, &self.key, text, 0)?;
            }
            for side in sides {
                if side.get(first).is_some() {
                    edits.extend(self.within(side, &self.key, text, 0)?);
                }
            }
            if edits.is_empty() {
                return Err(self.fault(
                    no_side_has(first),
                    format!("leave it out, or add a [[side]] with {}", sides_with(first)),
                ));
            }
            return Ok(edits);
        }
        if SETTINGS.iter().any(|key| key.name == first) {
            return self.within(root, &self.key, text, 0);
        }
        let known = || {
            let settings = SETTINGS.iter().map(|key| key.name);
            settings
                .chain(KEYS.iter().map(|key| key.name))
                .chain(Side::ALL.map(Side::name))
        };
        Err(self.fault(
            format!("a study has no key `{first}`"),
            suggestion_or(first, known(), "docs/sweeps.md lists every key of a study; array.domain=exact sets one of the array's sides"),
        ))
    }

    /// Tables with this key, one for each value.
    fn each(&self, keys: &[String]) -> String {
        let open = keys
            .iter()
            .fold(String::new(), |open, key| open + "{ " + key + " = ");
        let close = " }".repeat(keys.len());
        let value: Option<toml::Table> = format!("it = {}", self.value).parse().ok();
        let list = value.as_ref().and_then(|it| it.get("it")?.as_array());
        let values = list.map_or_else(
            || vec![self.value.clone()],
            |all| all.iter().map(ToString::to_string).collect(),
        );
        let each = values.iter().map(|value| format!("{open}{value}{close}"));
        each.collect::<Vec<_>>().join(",")
    }

    fn of_side(
        &self,
        side: Side,
        rest: &[String],
        root: Node<'_>,
        text: &str,
    ) -> Result<Vec<Edit>, Fault> {
        if rest.is_empty() {
            return Err(self.fault(
                format!("`{side}` is a side, not a key"),
                format!("name the key too, such as {side}.threshold=16"),
            ));
        }
        let sides = root.get("side").and_then(Node::as_list).unwrap_or_default();
        let named = |node: &Node<'_>| {
            let name = node.get("side").and_then(Node::as_text);
            name == Some(side.name())
        };
        let own: Vec<Node<'_>> = sides.into_iter().filter(named).collect();
        if own.is_empty() {
            return Err(self.fault(
                format!("this study has no side `{side}`"),
                "set a key of a side that it has, or leave the side out".to_owned(),
            ));
        }
        let mut edits = Vec::new();
        for node in own {
            let header = node.get("side").map_or(0, |side| side.place().end);
            edits.extend(self.within(node, rest, text, header)?);
        }
        Ok(edits)
    }

    /// Sets a key of a table: in place of what stands there, else after `at`.
    fn within(
        &self,
        table: Node<'_>,
        key: &[String],
        text: &str,
        at: usize,
    ) -> Result<Vec<Edit>, Fault> {
        let Some((first, rest)) = key.split_first() else {
            return Ok(Vec::new());
        };
        let nested = |keys: &[String]| {
            let open = keys.iter().map(|key| format!("{{ {key} = "));
            let close = " }".repeat(keys.len());
            format!("{}{}{close}", open.collect::<String>(), self.value)
        };
        match table.get(first) {
            Some(node) if rest.is_empty() => Ok(vec![(node.place(), self.value.clone())]),
            Some(node) if node.as_table().is_some() => {
                let place = node.place();
                if !text
                    .get(place.start..)
                    .is_some_and(|text| text.starts_with('{'))
                {
                    return Err(self.fault(
                        format!("`{first}` is not written as {{ … }} in the study"),
                        format!("set all of it: {first}='{}'", nested(rest)),
                    ));
                }
                let key = rest.first().map_or("", String::as_str);
                if node.get(key).is_some() {
                    return self.within(node, rest, text, place.start + 1);
                }
                let empty = node.as_table().is_some_and(|all| all.is_empty());
                let comma = if empty { "" } else { "," };
                let inner = rest.get(1..).unwrap_or_default();
                let new = format!(" {key} = {}{comma}", nested(inner));
                Ok(vec![(Place::new(place.start + 1, place.start + 1), new)])
            }
            Some(node) => Err(self.fault(
                format!(
                    "`{first}` is {} in the study, and has no keys",
                    node.found()
                ),
                format!("set all of it: {first}='{}'", self.each(rest)),
            )),
            None => {
                // At the top before all tables; in a side after its name.
                let new = format!("{first} = {}", nested(rest));
                let inline = { text.get(at..) }.is_some_and(|text| {
                    let next = text.trim_start_matches([' ', '\t']);
                    next.starts_with(',') || next.starts_with('}')
                });
                let new = match (at, inline) {
                    (0, _) => format!("{new}\n"),
                    (_, true) => format!(", {new}"),
                    (_, false) => format!("\n{new}"),
                };
                Ok(vec![(Place::new(at, at), new)])
            }
        }
    }

    fn fault(&self, what: String, help: String) -> Fault {
        let end = self.text.find('=').unwrap_or(self.text.len());
        Fault::error(Place::new(0, end), what, "set here").help(help)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::sweep::Study;

    const STUDY: &str = "scene = \"bundled\"\nthreshold = [16, 32] # steps\n\n[[side]]\nside = \"reference\"\nkernel = \"csdvs-3\"\nformat = [\"f64\",\n  \"f32\"]\nrefractory = { us = 5 }\n\n[[side]]\nside = \"array\" # a chip\nkernel = \"csdvs-3\"\n";

    fn set(study: &str, overrides: &[&str]) -> String {
        let overrides: Vec<Override> = { overrides.iter() }
            .map(|text| text.parse().unwrap())
            .collect();
        overridden("study.toml", study, &overrides).unwrap()
    }

    /// The points of a study with keys set are those of one where they are written.
    #[track_caller]
    fn same(overrides: &[&str], written: &str) {
        let points = |text: &str| Study::parse("study.toml", text).unwrap().points().unwrap();
        let set = set(STUDY, overrides);
        assert_eq!(points(&set), points(written), "{set}");
    }

    #[test]
    fn what_is_set_is_as_if_it_were_written() {
        same(
            &["format=f16,q8.8"],
            &STUDY.replace("\"f64\",\n  \"f32\"", "\"f16\", \"q8.8\""),
        );
        same(&["threshold=8"], &STUDY.replace("[16, 32]", "8"));
        same(
            &["threshold={from=8,to=64,steps=3}"],
            &STUDY.replace("[16, 32]", "{ from = 8, to = 64, steps = 3 }"),
        );
        same(
            &["reference.refractory.us=7"],
            &STUDY.replace("us = 5", "us = 7"),
        );
        same(
            &["refractory.rule=authors"],
            &STUDY.replace("{ us = 5 }", "{ us = 5, rule = \"authors\" }"),
        );
        same(
            &[
                "array.domain=exact,silicon",
                "array.threshold=9",
                "frames=5",
            ],
            &format!("frames = 5\n{STUDY}domain = [\"exact\", \"silicon\"]\nthreshold = 9\n"),
        );
        same(
            &["sample.points=3", "sample.method=sobol"],
            &format!("sample = {{ method = \"sobol\", points = 3 }}\n{STUDY}"),
        );
    }

    #[test]
    fn a_key_is_set_once() {
        let twice = |overrides: &[&str]| {
            let overrides: Vec<Override> = { overrides.iter() }
                .map(|text| text.parse().unwrap())
                .collect();
            overridden("study.toml", STUDY, &overrides)
        };
        let error = twice(&["threshold=40", "format=f16", "threshold=50"]).unwrap_err();
        assert!(
            format!("{error:?}").contains("`threshold` is set twice"),
            "{error:?}"
        );
        // A side's own is another key.
        assert!(twice(&["threshold=40", "reference.threshold=50"]).is_ok());
    }

    #[test]
    fn a_key_that_no_side_has_is_refused() {
        for text in ["lambda=-1", "solver=ramp", "tau-us=500"] {
            let one: Override = text.parse().unwrap();
            let error = overridden("study.toml", STUDY, &[one]).unwrap_err();
            let told = format!("{error:?}");
            assert!(told.contains("no side of this study has it"), "{told}");
            assert!(told.contains("side = \\\"mesh\\\""), "{told}");
        }
        let one: Override = "domain=silicn".parse().unwrap();
        let study = STUDY.replace("\"array\"", "\"mesh\"");
        assert!(overridden("study.toml", &study, &[one]).is_err());
    }

    #[test]
    fn words_need_no_quotes() {
        let value = |text: &str| text.parse::<Override>().unwrap().value;
        assert_eq!(value("a=f32,q8.8"), "[\"f32\", \"q8.8\"]");
        assert_eq!(value("a=1,2.5"), "[1, 2.5]");
        assert_eq!(
            value("a={ us = 0 },{us=1, rule=\"x,y\"}"),
            "[{ us = 0 }, {us=1, rule=\"x,y\"}]"
        );
        assert_eq!(value("a=pattern:disc?x=1"), "\"pattern:disc?x=1\"");
        assert_eq!(value("a=\"1\""), "\"1\"");
        assert_eq!(value("a=1\nb = 2"), "\"1\\nb = 2\"");
        for wrong in ["a", "=1", "a=", "a..b=1", "a b=1", ".a=1"] {
            assert!(wrong.parse::<Override>().is_err(), "{wrong}");
        }
    }
}
