//! The schema of a study file as JSON Schema, and its keys as a table: both made from the
//! table of keys that the file is read by.

use std::fmt::Write as _;

use serde_json::{Map, Value as Json, json};

use super::{
    key::{Absent, Key, Kind, Side},
    study::{AGAINST, METRICS, SETTINGS},
};

/// JSON Schema (draft 2020-12) of a study file, read as TOML.
#[must_use]
pub fn json_schema() -> Json {
    let mut properties: Map<String, Json> = SETTINGS
        .iter()
        .map(|(name, what)| ((*name).to_owned(), setting(name, what)))
        .collect();
    for side in Side::ALL {
        for key in Key::of(side) {
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
    let mut properties: Map<String, Json> = Key::of(side)
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
    let one = one(key);
    let mut ways = vec![
        one.clone(),
        json!({"type": "array", "minItems": 1, "items": one}),
    ];
    if key.ranges() {
        ways.push(json!({
            "type": "object",
            "additionalProperties": false,
            "required": ["from", "to"],
            "properties": {
                "from": {"type": "number"},
                "to": {"type": "number"},
                "steps": {"type": "integer", "minimum": 2},
                "log": {"type": "boolean"},
            },
        }));
    }
    let mut schema = json!({"description": key.what, "anyOf": ways});
    if let (Absent::Is(text), Some(schema)) = (key.default, schema.as_object_mut()) {
        schema.insert("x-default-toml".to_owned(), json!(text));
    }
    schema
}

fn one(key: &Key) -> Json {
    match key.kind {
        Kind::Name | Kind::Spelled(_) => json!({"type": "string", "minLength": 1}),
        Kind::Number { least, above: true } => json!({"type": "number", "exclusiveMinimum": least}),
        Kind::Number { least, .. } => json!({"type": "number", "minimum": least}),
        Kind::Whole { least, most } => {
            json!({"type": "integer", "minimum": least, "maximum": most})
        }
        Kind::Choice(words) => json!({"enum": words}),
        Kind::Threshold => json!({"anyOf": [
            {"type": "number", "exclusiveMinimum": 0},
            {
                "type": "object",
                "additionalProperties": false,
                "required": ["on", "off"],
                "properties": {
                    "on": {"type": "number", "exclusiveMinimum": 0},
                    "off": {"type": "number", "exclusiveMinimum": 0},
                    "sigma": {"type": "number", "minimum": 0},
                },
            },
        ]}),
        Kind::Refractory => json!({
            "type": "object",
            "additionalProperties": false,
            "required": ["us"],
            "properties": {
                "us": {"type": "number", "minimum": 0},
                "rule": {"enum": ["dead-time", "authors"]},
            },
        }),
        Kind::Noise => json!({"anyOf": [{"enum": ["none", "noisy"]}, {"type": "object"}]}),
        Kind::Response => json!({"anyOf": [{"const": "identity"}, {"type": "object"}]}),
    }
}

fn setting(name: &str, what: &str) -> Json {
    let several = |one: Json| json!([one, {"type": "array", "items": one}]);
    let mut schema = match name {
        "metrics" => json!({"anyOf": several(json!({"enum": METRICS.map(|(name, _)| name)}))}),
        "within" | "van-rossum" | "victor-purpura" => {
            json!({"anyOf": several(json!({"type": "string"}))})
        }
        "against" => json!({"enum": AGAINST}),
        "effort" => json!({"type": "number", "minimum": 0, "maximum": 3600}),
        "sample" => json!({
            "type": "object",
            "additionalProperties": false,
            "required": ["method", "points"],
            "properties": {
                "method": {"enum": ["random", "sobol"]},
                "points": {"type": "integer", "minimum": 1},
                "seed": {"type": "integer", "minimum": 0},
            },
        }),
        _ => json!({"type": "string"}),
    };
    if let Some(schema) = schema.as_object_mut() {
        schema.insert("description".to_owned(), json!(what));
    }
    schema
}

/// Every key as rows of a Markdown table: the settings, then the axes.
#[must_use]
pub fn key_table() -> String {
    let mut text = String::from("| key | side | when left out | what it is |\n|---|---|---|---|\n");
    for (name, what) in SETTINGS {
        let _ = writeln!(text, "| `{name}` | all | | {what} |");
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
