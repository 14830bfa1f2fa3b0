//! The schema of a study file as JSON Schema, and its keys as a table: both made from the
//! table of keys that the file is read by.

use std::fmt::Write as _;

use serde_json::{Map, Value as Json, json};

use super::{
    key::{Absent, Key, Kind, Side},
    key_values::RAMP,
    study::SETTINGS,
};
use crate::config::{self, schema};

/// JSON Schema (draft 2020-12) of a study file, read as TOML.
#[must_use]
pub fn json_schema() -> Json {
    let mut properties: Map<String, Json> = SETTINGS
        .iter()
        .map(|key| (key.name.to_owned(), schema::key(key)))
        .collect();
    for side in Side::ALL {
        for key in Key::on_side(side) {
            let own = axis(key);
            match properties.get_mut(key.name) {
                // Two sides have a key of this name.
                Some(other) if *other != own => {
                    let both = json!({"anyOf": [other.clone(), own]});
                    if other.get("anyOf").is_none() || other.get("description").is_some() {
                        *other = both;
                    }
                }
                Some(_) => {}
                None => {
                    properties.insert(key.name.to_owned(), own);
                }
            }
        }
    }
    let sides: Vec<Json> = Side::ALL.iter().map(|side| of_side(*side)).collect();
    properties.insert(
        "side".to_owned(),
        json!({"type": "array", "minItems": 1, "items": {"oneOf": sides}}),
    );
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "a study of amacrine sweep",
        "description": "Every axis takes one value or a list of values, numbers also a range { from, to, steps, log }. An axis above the first [[side]] holds for every side that has it; one inside a [[side]] takes its place there.",
        "type": "object",
        "additionalProperties": false,
        "required": ["side"],
        "properties": properties,
    })
}

fn of_side(side: Side) -> Json {
    let mut properties: Map<String, Json> = Key::on_side(side)
        .map(|key| (key.name.to_owned(), axis(key)))
        .collect();
    properties.insert("side".to_owned(), json!({"const": side.name()}));
    json!({
        "type": "object",
        "additionalProperties": false,
        "required": ["side"],
        "properties": properties,
    })
}

fn axis(key: &Key) -> Json {
    let mut one = schema::kind(&key.kind.value_kind());
    if let Kind::Spelled(_, pattern) = key.kind {
        schema::add(&mut one, "pattern", pattern());
    }
    let mut ways = vec![
        one.clone(),
        json!({"type": "array", "minItems": 1, "items": one}),
    ];
    if key.ranges() {
        ways.push(schema::table(&RAMP));
    }
    // The default and the description are those of any key.
    let key = config::Key {
        absent: key.default,
        ..config::Key::optional(key.name, config::Kind::Text, key.what)
    };
    let mut axis = schema::key(&key);
    if let Some(members) = axis.as_object_mut() {
        members.remove("type");
    }
    schema::add(&mut axis, "anyOf", ways);
    axis
}

/// Every key as rows of a Markdown table: the settings, then the axes.
#[must_use]
pub fn key_table() -> String {
    let mut text = String::from("| key | side | when left out | what it is |\n|---|---|---|---|\n");
    for key in SETTINGS {
        let _ = writeln!(text, "| `{}` | all | | {} |", key.name, key.what);
    }
    for key in super::key::KEYS {
        let sides: Vec<&str> = key.sides.iter().map(|side| side.name()).collect();
        let sides = if sides.len() == Side::ALL.len() {
            "all".to_owned()
        } else {
            sides.join(", ")
        };
        let absent = match key.default {
            Absent::Required => "needed".to_owned(),
            Absent::None => "none".to_owned(),
            Absent::Is(text) => format!("`{text}`"),
        };
        let _ = writeln!(
            text,
            "| `{}` | {sides} | {absent} | {} |",
            key.name, key.what
        );
    }
    text
}
