//! JSON Schema (draft 2020-12) of a file, made from the description that it is read by.

use serde_json::{Map, Value as Json, json};

use super::{Absent, File, Key, Kind, Range, Table};

/// The schema of a file.
#[must_use]
pub fn file(file: &File) -> Json {
    let mut schema = kind(&file.kind);
    add(
        &mut schema,
        "$schema",
        "https://json-schema.org/draft/2020-12/schema",
    );
    add(&mut schema, "title", file.title);
    add(&mut schema, "$comment", file.see);
    schema
}

/// Sets one member of an object.
pub fn add(schema: &mut Json, name: &str, value: impl Into<Json>) {
    if let Some(members) = schema.as_object_mut() {
        members.insert(name.to_owned(), value.into());
    }
}

/// The schema of a key: what it takes, what it is, what holds when it is left out.
#[must_use]
pub fn key(key: &Key) -> Json {
    let mut schema = kind(&key.kind);
    add(&mut schema, "description", description(key.what, key.unit));
    if let Absent::Is(text) = key.absent
        && let Some(default) = value(&format!("{} = {text}", key.name), key.name)
    {
        add(&mut schema, "default", default);
    }
    if let Some(example) = value(key.example, key.name) {
        add(&mut schema, "examples", json!([example]));
    }
    schema
}

fn description(what: &str, unit: &str) -> String {
    match unit {
        "" => what.to_owned(),
        unit => format!("{what} [{unit}]"),
    }
}

/// The value of a key in a line of TOML.
fn value(line: &str, key: &str) -> Option<Json> {
    let table: toml::Table = line.parse().ok()?;
    serde_json::to_value(table.get(key)?).ok()
}

/// The schema of what a key takes.
#[must_use]
pub fn kind(kind: &Kind) -> Json {
    match kind {
        Kind::Text => json!({"type": "string"}),
        Kind::Name => json!({"type": "string", "minLength": 1}),
        Kind::Choice(words) => json!({"enum": words}),
        Kind::Spelled(spelling) => {
            let mut schema = json!({"type": "string", "$comment": spelling.what});
            if !spelling.pattern.is_empty() {
                add(&mut schema, "pattern", spelling.pattern);
            }
            schema
        }
        Kind::Flag => json!({"type": "boolean"}),
        Kind::Number(range) => number(range),
        Kind::Whole { least, most } => {
            json!({"type": "integer", "minimum": least, "maximum": most})
        }
        Kind::List { of, least, most } => {
            let mut schema = json!({"type": "array", "items": self::kind(of)});
            if *least > 0 {
                add(&mut schema, "minItems", *least);
            }
            if *most < usize::MAX {
                add(&mut schema, "maxItems", *most);
            }
            schema
        }
        Kind::Table(table) => self::table(table),
        Kind::Map(of) => json!({"type": "object", "additionalProperties": self::kind(of)}),
        Kind::Either { ways, .. } => {
            let ways: Vec<Json> = ways.iter().map(self::kind).collect();
            json!({"anyOf": ways})
        }
        Kind::Cases { tag, cases } => {
            let case = |(word, table): &(&str, &Table)| {
                let mut schema = self::table(table);
                schema["properties"][*tag] = json!({"const": word});
                schema
            };
            let cases: Vec<Json> = cases.iter().map(case).collect();
            json!({"oneOf": cases})
        }
    }
}

/// The schema of a table.
#[must_use]
pub fn table(table: &Table) -> Json {
    let mut schema = object(table.keys.iter());
    if !table.one_of.is_empty() {
        let one = |name: &&str| json!({"required": [name]});
        let one_of: Vec<Json> = table.one_of.iter().map(one).collect();
        add(&mut schema, "oneOf", one_of);
    }
    schema
}

/// The schema of a table with these keys and no others.
pub fn object<'a>(keys: impl Iterator<Item = &'a Key>) -> Json {
    let (mut properties, mut required) = (Map::new(), Vec::new());
    for it in keys {
        properties.insert(it.name.to_owned(), key(it));
        if it.absent == Absent::Required {
            required.push(it.name);
        }
    }
    let mut schema = json!({
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    });
    if !required.is_empty() {
        add(&mut schema, "required", required);
    }
    schema
}

fn number(range: &Range) -> Json {
    let mut schema = json!({"type": "number"});
    let least = if range.above {
        "exclusiveMinimum"
    } else {
        "minimum"
    };
    let most = if range.below {
        "exclusiveMaximum"
    } else {
        "maximum"
    };
    for (name, end) in [(least, range.least), (most, range.most)] {
        if end.is_finite() {
            add(&mut schema, name, whole(end));
        }
    }
    schema
}

/// Whole ends are written without a fraction.
fn whole(number: f64) -> Json {
    if number.fract() == 0.0 && number.abs() < 2f64.powi(53) {
        json!(number as i64)
    } else {
        json!(number)
    }
}
