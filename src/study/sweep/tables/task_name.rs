//! What tasks are called: by the columns in which they differ, such as kernel and threshold.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value as Json;

use super::{
    column::Part,
    table::{self, Row},
};
use crate::order::Order;

/// What a user chooses of a task as of a sensor: its receptive field and its thresholds.
pub(super) fn field_columns() -> impl Iterator<Item = &'static str> {
    table::columns_of(&[Part::Field])
}

/// Those, then what it is shown, and what else its f64 sensor has of it.
fn task_columns() -> impl Iterator<Item = &'static str> {
    field_columns().chain(table::columns_of(&[Part::Light, Part::Model, Part::Task]))
}

/// The values of the columns that make a task, those without one left out.
pub type Columns = BTreeMap<String, Vec<Json>>;

/// The columns of the tasks of these points, each value once.
pub(super) fn columns(rows: &[&Row]) -> Columns {
    let each = task_columns().map(|column| {
        let mut values: Vec<Json> = Vec::new();
        let mut seen = BTreeSet::new();
        for row in rows {
            if let Some(value) = row.get(column).filter(|value| !value.is_null())
                && seen.insert(value.to_string())
            {
                values.push(value.clone());
            }
        }
        let number = |value: &Json| value.as_f64().unwrap_or(0.0);
        values.order_by(|a, b| number(a).total_cmp(&number(b)));
        (column.to_owned(), values)
    });
    each.filter(|(_, values)| !values.is_empty()).collect()
}

/// What the tasks of a group are called among all groups: the columns that differ between groups or
/// within one. Empty where nothing does.
pub(super) fn name(own: &Columns, all: &[&Columns]) -> String {
    let one = |column: &str| {
        let of = |columns: &Columns| columns.get(column).cloned().unwrap_or_default();
        of(own).len() > 1 || all.iter().any(|other| of(other) != of(own))
    };
    // Thresholds of several kinds stand beside those of one in another column.
    let both = own.contains_key("threshold_on") && own.contains_key("thresholds");
    let differs = |column: &str| match column {
        "threshold_on" | "threshold_off" | "thresholds" if both => true,
        // One word where they are equal, two where not.
        "threshold_on" | "threshold_off" => one("threshold_on") || one("threshold_off"),
        _ => one(column),
    };
    let mut words = Vec::new();
    for column in task_columns() {
        let Some(values) = own.get(column).filter(|_| differs(column)) else {
            continue;
        };
        let off = own.get("threshold_off");
        match column {
            "threshold_on" if off == Some(values) => {
                words.push(format!("threshold {}", several(values)));
            }
            "threshold_off" if own.get("threshold_on") == Some(values) => {}
            _ => words.push(format!("{} {}", label(column), several(values))),
        }
    }
    words.join(", ")
}

/// A column as it is called in text.
fn label(column: &str) -> &str {
    match column {
        "threshold_on" => "ON threshold",
        "threshold_off" => "OFF threshold",
        "lambda_y" => "lambda-y",
        "tau_us" => "tau (us)",
        "rule" => "memory",
        other => other,
    }
}

/// What a sensor's own task is called beside others: the values of a row in the columns of
/// its field that differ.
pub(super) fn field(row: &Row, differs: impl Fn(&str) -> bool) -> String {
    let mut words = Vec::new();
    let own = |column: &str| row.get(column).filter(|value| !value.is_null());
    for column in field_columns().filter(|column| differs(column)) {
        let Some(value) = own(column) else { continue };
        let said = shown(value);
        match column {
            "kernel" | "thresholds" => words.push(said),
            "threshold_on" if own("threshold_off") == Some(value) => {
                words.push(format!("threshold {said}"));
            }
            "threshold_off" if own("threshold_on") == Some(value) => {}
            _ => words.push(format!("{} {said}", label(column))),
        }
    }
    words.join(" ")
}

/// The most values that are named one by one.
const NAMED: usize = 6;

/// Values for people; of many numbers the ends.
fn several(values: &[Json]) -> String {
    match values {
        [first, .., last] if values.len() > NAMED && first.is_number() => format!(
            "{} to {} ({} values)",
            shown(first),
            shown(last),
            values.len()
        ),
        _ => {
            let mut words: Vec<String> = values.iter().take(NAMED).map(shown).collect();
            if values.len() > NAMED {
                words.push(format!("and {} more", values.len() - NAMED));
            }
            words.join(" | ")
        }
    }
}

/// A value in five digits at most.
fn shown(value: &Json) -> String {
    let Some(number) = value.as_f64() else {
        return value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned);
    };
    let short: f64 = format!("{number:.4e}").parse().unwrap_or(number);
    short.to_string()
}

/// Whether the values of a column differ among these points.
pub(super) fn varies(rows: &[Row], column: &str) -> bool {
    let mut values = rows.iter().map(|row| table::cell(row, column));
    let first = values.next();
    values.any(|value| Some(value) != first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn of(rows: &[Json]) -> Columns {
        let rows: Vec<Row> = rows
            .iter()
            .map(|row| row.as_object().unwrap().clone())
            .collect();
        columns(&rows.iter().collect::<Vec<_>>())
    }

    #[test]
    fn groups_are_called_by_what_differs() {
        let row = |kernel: &str, on: f64, off: f64| json!({"scene": "a", "kernel": kernel, "threshold_on": on, "threshold_off": off});
        let (a, b) = (of(&[row("dog", 8.0, 8.0)]), of(&[row("dvs", 8.0, 9.5)]));
        assert_eq!(name(&a, &[&a]), "");
        assert_eq!(name(&a, &[&a, &b]), "kernel dog, threshold 8");
        let different = "kernel dvs, ON threshold 8, OFF threshold 9.5";
        assert_eq!(name(&b, &[&a, &b]), different);
        let many: Vec<Json> = (1..9)
            .map(|n| row("dog", f64::from(n), f64::from(n)))
            .collect();
        let many = of(&many);
        assert_eq!(name(&many, &[&many]), "threshold 1 to 8 (8 values)");
        // One threshold beside those of several kinds.
        let mut kinds = row("k", 0.0, 0.0);
        if let Some(kinds) = kinds.as_object_mut() {
            kinds.retain(|column, _| !column.starts_with("threshold"));
            kinds.insert("thresholds".to_owned(), json!("20, 30"));
        }
        let both = of(&[row("k", 24.0, 24.0), kinds]);
        assert_eq!(name(&both, &[&both]), "threshold 24, thresholds 20, 30");
        let few = of(&[row("dog", 4.0, 4.0), row("dvs", 17.123_456, 17.123_456)]);
        assert_eq!(
            name(&few, &[&few]),
            "kernel dog | dvs, threshold 4 | 17.123"
        );
    }
}
