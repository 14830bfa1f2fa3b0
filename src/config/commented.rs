//! The keys that a file does not have, in comments, as its schema tells them.

use std::fmt::Write as _;

use serde_json::Value as Json;

use super::{CHANGES_NOTHING, Faults, Located};

/// Stands above tables that a file could have: an example where a key must be given with its table.
const TABLES: &str = "# Tables that may stand here, with what holds in them, or an example:\n";

/// A text of TOML with the keys that it does not have, in comments: its own before its first table,
/// those of its last table behind it, and the tables that it could have at the end.
#[must_use]
pub fn with_keys(text: &str, schema: &Json) -> String {
    let own: toml::Table = text.parse().unwrap_or_default();
    let mut tables = String::new();
    for (key, about) in properties(schema) {
        let items = own
            .get(key)
            .and_then(|it| it.as_array()?.last()?.as_table());
        if let (Some(last), "array") = (items, kind(about)) {
            let items = &about["items"];
            let keys = lines(last, properties(items), items);
            if !keys.is_empty() {
                let _ = write!(tables, "\n# What else may stand in a [[{key}]]:\n{keys}");
            }
        } else if is_table(about) && !own.contains_key(key) {
            let keys = lines(&toml::Table::new(), properties(about), about);
            if !tables.contains(TABLES) {
                let _ = write!(tables, "\n{TABLES}");
            }
            let _ = write!(tables, "\n# [{key}]    # {}\n{keys}", says(about));
        }
    }
    let plain = properties(schema).filter(|(_, about)| !is_table(about));
    let others = lines(&own, plain, schema);
    let text = text.trim_end();
    if others.is_empty() {
        return format!("{text}\n{tables}");
    }
    let others =
        format!("# What else may stand here, with what holds where it does not:\n{others}");
    // Keys behind a table would be the table's, behind one in comments too once it is none.
    let table = text.starts_with('[').then_some(0);
    let table = table.or_else(|| text.find("\n[").map(|at| at + 1));
    match table {
        Some(at) => format!("{}{others}\n{}\n{tables}", &text[..at], &text[at..]),
        None => format!("{text}\n\n{others}{tables}"),
    }
}

/// The same text, in which each key in a comment of a table that is there holds when it stands there
/// alone: where it does not, its value is left open, and what would change nothing is left out.
/// `read` reads a text.
#[must_use]
pub fn that_hold(text: &str, read: &dyn Fn(&str) -> Result<(), Faults>) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let mut all = String::new();
    // Of a table that is in a comment itself all keys go together.
    let mut of_comment = false;
    for (at, line) in lines.iter().enumerate() {
        let heads = line.starts_with("# [");
        of_comment = heads || of_comment && line.starts_with('#');
        let key = line.strip_prefix("# ").filter(|_| !of_comment);
        let parts =
            key.and_then(|key| Some((key, key.split_once(" = ")?, key.split_once("    # ")?)));
        let Some((key, (name, _), (_, about))) = parts.filter(|it| !it.1.1.starts_with('…'))
        else {
            all.push_str(line);
            all.push('\n');
            continue;
        };
        let tried = [&lines[..at], &[key], &lines[at + 1..]].concat().join("\n");
        let idle = |it: &Located| it.fault.label == CHANGES_NOTHING;
        match read(&tried) {
            Ok(()) => all.push_str(line),
            Err(faults) if faults.faults.iter().any(idle) => continue,
            Err(_) => {
                let _ = write!(all, "# {name} = …    # {about}");
            }
        }
        all.push('\n');
    }
    all
}

/// A comment for each key that the table lacks.
fn lines<'a>(
    own: &toml::Table,
    keys: impl Iterator<Item = (&'a String, &'a Json)>,
    of: &Json,
) -> String {
    let mut text = String::new();
    for (key, about) in keys.filter(|(key, _)| !own.contains_key(*key)) {
        let all = [&about["default"], &about["examples"][0], &about["enum"][0]];
        let value = all.into_iter().find(|it| !it.is_null());
        let value = value.map_or("…".to_owned(), |value| {
            toml::Value::try_from(value).map_or_else(|_| value.to_string(), |it| it.to_string())
        });
        let instead = instead(own, key, of).map(|other| format!("in place of {other}: "));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "# {key} = {value}    # {}{}",
            instead.unwrap_or_default(),
            says(about)
        );
    }
    text
}

/// The key of the table that excludes this one.
fn instead(own: &toml::Table, key: &str, of: &Json) -> Option<String> {
    let ways = of["oneOf"].as_array()?;
    let mut needed = ways.iter().filter_map(|way| way["required"][0].as_str());
    needed
        .clone()
        .any(|own| own == key)
        .then(|| needed.find(|other| own.contains_key(*other)))?
        .map(str::to_owned)
}

fn properties(of: &Json) -> impl Iterator<Item = (&String, &Json)> {
    of["properties"].as_object().into_iter().flatten()
}

fn kind(about: &Json) -> &str {
    about["type"].as_str().unwrap_or_default()
}

/// Whether it is a table of keys that are known and optional.
fn is_table(about: &Json) -> bool {
    kind(about) == "object" && about["examples"].is_null()
}

/// What it is for; of a key that means two things, both.
fn says(about: &Json) -> String {
    let own = about["description"].as_str().map(str::to_owned);
    let each = || {
        let ways = about["anyOf"].as_array().into_iter().flatten();
        let ways: Vec<&str> = ways.filter_map(|way| way["description"].as_str()).collect();
        ways.join("; or ")
    };
    own.unwrap_or_else(each).replace('\n', " ")
}
