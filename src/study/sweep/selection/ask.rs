//! Ask and tell: a study's space for a search of somebody else's, and points of it computed one by
//! one as they come.

use std::{collections::HashMap, path::Path};

use serde_json::{Map, Value as Json, json};

use crate::{
    config::{Document, nearest},
    rig::guard::Warning,
    study::sweep::{
        measurement::{limits::Limits, measure::measure, memo::Shared, run::alone},
        points::{
            grid::{Axes, Axis},
            plan::{Opened, Plan},
            point::Point,
            thresholds::{PerKind, Thresholds},
            value::{Value, Values},
        },
        study_file::{
            key::{Key, Kind, Side},
            key_values,
            study::{COSTS, Study},
        },
        tables::table::{self, Row},
    },
};

/// The space of a study: its sides, each with its axes.
#[must_use]
pub fn space(study: &Study) -> Json {
    let sides = study.sides.iter().enumerate().map(|(number, own)| {
        let axes: Vec<Json> = own.axes.iter().map(axis).collect();
        json!({"number": number, "side": own.side.name(), "axes": axes})
    });
    json!({
        "title": study.title,
        "sides": sides.collect::<Vec<_>>(),
        "objectives": {"error": "minimise", "costs": COSTS},
    })
}

/// An axis: its values, or its range; one value is a constant.
fn axis(axis: &Axis) -> Json {
    let mut json = json!({"name": axis.key.name, "what": axis.key.what});
    match &axis.values {
        Values::List(list) => {
            json["values"] = list
                .iter()
                .map(|(value, _)| said(axis.key, value))
                .collect();
        }
        Values::Ramp(ramp) => {
            let whole = matches!(axis.at(0), Some(Value::Whole(_)));
            json["from"] = json!(ramp.from);
            json["to"] = json!(ramp.to);
            json["log"] = json!(ramp.log);
            json["steps"] = json!(ramp.steps);
            json["whole"] = json!(whole);
        }
    }
    json
}

/// A value as a point takes it again.
fn said(key: &Key, value: &Value) -> Json {
    match value {
        // As TOML has it.
        Value::Word(word) if matches!(key.kind, Kind::Response | Kind::Noise) => {
            let table: Result<toml::Table, _> = format!("it = {word}").parse();
            table.map_or_else(|_| json!(word), |table| json!(table["it"]))
        }
        Value::Number(number) => json!(number),
        Value::Whole(number) => json!(number),
        Value::Word(word) => json!(word),
        Value::Flag(flag) => json!(flag),
        Value::Threshold(thresholds) => match thresholds.on {
            PerKind::All(both) if *thresholds == Thresholds::both(both) => json!(both),
            _ => json!(thresholds),
        },
        Value::Refractory { us, rule } => json!({"us": us, "rule": rule}),
    }
}

/// No point of a study.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{what}")]
pub struct PointError {
    /// What is wrong.
    pub what: String,
    /// What to do.
    #[help]
    pub help: String,
}

fn wrong(what: impl Into<String>, help: impl Into<String>) -> PointError {
    PointError {
        what: what.into(),
        help: help.into(),
    }
}

/// Computes points of a study as they come; what they share is kept between them.
pub struct Asked<'a> {
    study: &'a Study,
    opened: Opened<'a>,
    plan: Plan,
    shared: Shared,
    known: HashMap<String, Row>,
}

impl<'a> Asked<'a> {
    /// Of a study whose files are in `folder`, and in which nothing is left out ([`Study::in_full`]):
    /// what stands for a point is measured for many of them.
    #[must_use]
    pub fn new(study: &'a Study, folder: &'a Path) -> Self {
        Self {
            opened: Opened::new(study, folder),
            plan: Plan {
                study: study.clone(),
                entries: Vec::new(),
                named: 0,
            },
            shared: Shared::new(None),
            known: HashMap::new(),
            study,
        }
    }

    /// What the scenes that were opened warn of.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        self.opened.warnings()
    }

    /// Computes a point; the row has every column, `null` where it has no value. It is written as a
    /// JSON object: `side` (a name, or a number of the space), and
    /// a value for each key that the study gives several for. A key of the side that is not
    /// written has the study's value.
    ///
    /// # Errors
    /// When it is no point of the study, or what it names cannot be opened. A point that cannot be
    /// computed is a row that says why.
    pub fn tell(&mut self, text: &str, limits: Limits<'_>) -> Result<Row, PointError> {
        let point = self.point(text)?;
        let entry = self.opened.checked_entry(point).map_err(|faults| {
            let first = faults.faults.first();
            let help = first.and_then(|first| first.fault.help.clone());
            wrong(
                first.map_or(String::new(), |first| first.fault.message.clone()),
                help.unwrap_or_default(),
            )
        })?;
        if let Some(row) = self.known.get(&entry.id) {
            return Ok(row.clone());
        }
        let mut row = alone(|| measure(&self.plan, &entry, &self.shared, limits));
        for column in table::names(&self.study.settings) {
            row.entry(column).or_insert(Json::Null);
        }
        self.known.insert(entry.id, row.clone());
        Ok(row)
    }

    fn point(&self, text: &str) -> Result<Point, PointError> {
        let json: Json = serde_json::from_str(text).map_err(|error| {
            wrong(
                format!("a point is not JSON: {error}"),
                "write an object, such as {\"side\": \"reference\", \"format\": \"f32\"}",
            )
        })?;
        let Json::Object(given) = json else {
            return Err(wrong(
                "a point is no JSON object",
                "write an object, such as {\"side\": \"reference\", \"format\": \"f32\"}",
            ));
        };
        let axes = self.side(&given)?;
        let known = || Key::on_side(axes.side).map(|key| key.name);
        let mut values = Vec::new();
        for (name, value) in given.iter().filter(|(name, _)| *name != "side") {
            let Some(key) = Key::on_side(axes.side).find(|key| key.name == name) else {
                let side = axes.side;
                let help = match nearest(name, known()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("it has {}", known().collect::<Vec<_>>().join(", ")),
                };
                return Err(wrong(format!("side `{side}` has no key `{name}`"), help));
            };
            values.push((key.name, value_of(key, value)?));
        }
        for axis in &axes.axes {
            let name = axis.key.name;
            if values.iter().any(|(known, _)| *known == name) {
                continue;
            }
            let one = axis.count().filter(|count| *count == 1);
            let Some(value) = one.and_then(|_| axis.at(0)) else {
                return Err(wrong(
                    format!("the point does not say `{name}`, and the study gives several"),
                    format!("add \"{name}\": one of them; --space lists them"),
                ));
            };
            values.push((name, value));
        }
        Ok(Point::new(axes.side, values))
    }

    fn side(&self, given: &Map<String, Json>) -> Result<&'a Axes, PointError> {
        let sides = &self.study.sides;
        let names: Vec<String> = { sides.iter().enumerate() }
            .map(|(number, axes)| format!("{number} ({})", axes.side))
            .collect();
        let help = format!("the study has {}", names.join(", "));
        let named = |name: &str| -> Vec<&'a Axes> {
            let side = Side::ALL.into_iter().find(|side| side.name() == name);
            sides
                .iter()
                .filter(|axes| Some(axes.side) == side)
                .collect()
        };
        let found = match given.get("side") {
            None => sides.iter().collect(),
            Some(Json::String(name)) => named(name),
            Some(number) => {
                let number = number.as_u64().and_then(|n| usize::try_from(n).ok());
                number.and_then(|n| sides.get(n)).into_iter().collect()
            }
        };
        match (&found[..], given.get("side")) {
            ([one], _) => Ok(one),
            ([], Some(side)) => Err(wrong(format!("the study has no side {side}"), help)),
            (_, Some(side)) => Err(wrong(
                format!("the study has several sides {side}"),
                format!("give the number of one: {help}"),
            )),
            (_, None) => Err(wrong("the point does not say its `side`", help)),
        }
    }
}

/// A value of a point, read as a study's is.
fn value_of(key: &Key, json: &Json) -> Result<Value, PointError> {
    let text = toml(json).filter(|_| !json.is_array()).ok_or_else(|| {
        wrong(
            format!("`{}` is {json}", key.name),
            "a point has one value of each key: a number, a text, or an object of them",
        )
    })?;
    let read = Document::value(&text).and_then(|document| key_values::value(key, document.root()));
    read.map_err(|fault| {
        wrong(
            fault.message,
            fault.help.unwrap_or_else(|| key_values::SEE.to_owned()),
        )
    })
}

/// JSON as TOML, where that is a value.
fn toml(json: &Json) -> Option<String> {
    match json {
        Json::String(_) | Json::Number(_) | Json::Bool(_) => Some(json.to_string()),
        Json::Object(map) => {
            let one = |(key, value): (&String, &Json)| {
                let key = Json::from(key.as_str());
                Some(format!("{key} = {}", toml(value)?))
            };
            let all: Option<Vec<String>> = map.iter().map(one).collect();
            Some(format!("{{ {} }}", all?.join(", ")))
        }
        Json::Array(list) => {
            let all: Option<Vec<String>> = list.iter().map(toml).collect();
            Some(format!("[{}]", all?.join(", ")))
        }
        Json::Null => None,
    }
}
