//! The columns of the results: one schema for CSV, JSON lines and Parquet.

use std::fmt::Write as _;

use serde_json::{Map, Value as Json};

pub use super::column::Holds;
use super::column::{Fixed, Part, real, text, whole};
use crate::{
    compare::metric::{Entry, Metric},
    study::sweep::study_file::{key::KEYS, study::Settings},
};

/// A row: a value for each column that has one.
pub type Row = Map<String, Json>;

/// One column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name. Those with `seconds`, `per_s` or `memory` in it may differ between machines.
    pub name: String,
    /// What stands in it.
    pub holds: Holds,
    /// What it is, with its unit.
    pub what: String,
}

/// What the point is, before its keys.
const BEFORE: [(Part, Fixed); 4] = [
    Part::Other.whole("index", "number of the point in the fixed order, from 0"),
    Part::Other.text("id", "identity: a hash of the point's description and of all that it names"),
    Part::Other.text("task", "identity of the f64 sensor that it is measured against, on its scene: points of one task answer one question"),
    Part::Sensor.text("side", "reference, array or mesh"),
];

/// And behind them.
const AGAINST: (Part, Fixed) = Part::Task.text(
    "against",
    "memory of the f64 sensor that it is measured against",
);

/// What came of it, before the metrics.
const FIGURES: [Fixed; 24] = [
    text(
        "outcome",
        "done; refused: the point cannot be; failed: it was given up, and is computed again by the next run",
    ),
    text("reason", "why it is refused or failed"),
    whole("width", "pixels"),
    whole("height", "pixels"),
    whole(
        "frames_seen",
        "frames that the sensor saw, inserted ones among them",
    ),
    whole("events", "events"),
    whole("on", "ON events"),
    whole("off", "OFF events"),
    whole("dropped", "events that were made and not delivered"),
    text(
        "warnings",
        "what makes these figures mean something else than they seem to: no-events, most-cells, slots, saturation, window; of a kernel in few values surround, lopsided, clipped",
    ),
    whole("bits", "bits of all events as fixed address words"),
    whole("reference_events", "events of the f64 sensor"),
    whole("words", "instruction words of a frame on the chip"),
    real(
        "array_us",
        "microseconds of a frame on the chip's array, readout left out",
    ),
    whole(
        "registers",
        "analogue registers that the filter holds at a time",
    ),
    whole(
        "prescale_bits",
        "halvings of the light before anything else",
    ),
    real(
        "quantisation_error",
        "the norm of w - scale levels over that of w, the kernel; of several kinds the largest",
    ),
    whole(
        "window_us",
        "window of the headline, microseconds: the first of `within`, else 100 ms or the time from frame to frame",
    ),
    real("kept", "the part of F1 above chance, within that window"),
    text(
        "kept_of_kinds",
        "the same of each kind of several by its own events, a JSON list, as `quantise` and `feasibility` tell it",
    ),
    real(
        "floor",
        "F1 of a redraw of the f64 sensor, within that window",
    ),
    real(
        "threshold_equivalent_percent",
        "change of the f64 sensor's threshold that costs as much",
    ),
    text(
        "threshold_equivalent_is_least",
        "true: no threshold that was tried costs as much, and the change is more than that",
    ),
    real("error", "1 - kept"),
];

/// What stands for the point, where a plainer model may.
const FIDELITY: [Fixed; 2] = [
    text(
        "left_out",
        "what a plainer model does without that stands for the point; empty where it was computed as it is",
    ),
    real(
        "left_out_limit",
        "the upper confidence limit (95 %) of the share of the point's events that this changes; 0 where it changes none. An event that moves by more than the narrowest window or time constant of the study is changed",
    ),
];

/// What differs between machines, or is named like it.
const MACHINE: [Fixed; 4] = [
    real(
        "seconds_per_frame",
        "seconds that one thread of this machine had a processor for a frame, the mean over the scene: other work on the machine lengthens it little",
    ),
    real("frames_per_s", "frames a second of computing"),
    real("events_per_s", "events a second of computing"),
    whole(
        "state_memory_bytes",
        "bytes that the sensor's model must keep from one frame to the next: computed from its formats, the same on every machine",
    ),
];

/// The columns that say what the point is.
fn point() -> impl Iterator<Item = &'static (Part, Fixed)> {
    let keys = KEYS.iter().flat_map(|key| key.columns);
    BEFORE.iter().chain(keys).chain([&AGAINST])
}

/// Those of them that say this of it.
pub(in crate::study::sweep) fn columns_of(
    parts: &'static [Part],
) -> impl Iterator<Item = &'static str> {
    let own = point().filter(|(part, _)| parts.contains(part));
    own.map(|(_, (name, ..))| *name)
}

/// All columns of a study, in their order.
#[must_use]
pub fn columns(settings: &Settings) -> Vec<Column> {
    let column = |(name, holds, what): &Fixed| Column {
        name: (*name).to_owned(),
        holds: *holds,
        what: (*what).to_owned(),
    };
    let metrics = metrics(settings).into_iter().map(|metric| Column {
        name: metric.key(),
        holds: Holds::Real,
        what: metric.to_string(),
    });
    let fidelity: &[_] = if settings.tolerance.is_some() {
        &FIDELITY
    } else {
        &[]
    };
    let point = point().map(|(_, column)| column);
    let before = point.chain(&FIGURES).chain(fidelity).map(column);
    before
        .chain(metrics)
        .chain(MACHINE.iter().map(column))
        .collect()
}

/// Their names.
#[must_use]
pub fn names(settings: &Settings) -> Vec<String> {
    let all = columns(settings);
    all.into_iter().map(|column| column.name).collect()
}

/// The metrics of a study, each at its scales.
#[must_use]
pub fn metrics(settings: &Settings) -> Vec<Metric> {
    let named = settings
        .metrics
        .iter()
        .filter_map(|name| Entry::in_studies(name));
    let each = named.flat_map(|entry| entry.metrics(settings.scales(entry.scale)));
    each.collect()
}

/// Whether a column may differ between machines.
#[must_use]
pub fn machine(name: &str) -> bool {
    ["seconds", "per_s", "memory"]
        .iter()
        .any(|part| name.contains(part))
}

/// Whether a column is a time that was measured.
#[must_use]
pub fn timed(name: &str) -> bool {
    MACHINE[..3].iter().any(|(timed, ..)| *timed == name)
}

/// A cell as text; nothing where there is none.
pub(in crate::study::sweep) fn cell(row: &Row, column: &str) -> String {
    match row.get(column) {
        None | Some(Json::Null) => String::new(),
        Some(Json::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    }
}

/// What stands in a column of this name; metrics are numbers.
#[must_use]
pub fn holds(name: &str) -> Holds {
    let point = point().map(|(_, column)| column);
    let fixed = point.chain(&FIGURES).chain(&FIDELITY);
    let fixed = fixed.chain(&MACHINE);
    let mut fixed = fixed.filter(|(known, ..)| *known == name);
    fixed.next().map_or(Holds::Real, |(_, holds, _)| *holds)
}

/// The columns as rows of a Markdown table.
#[must_use]
pub fn column_table(settings: &Settings) -> String {
    let mut text = String::from("| column | holds | what it is |\n|---|---|---|\n");
    for column in columns(settings) {
        let holds = match column.holds {
            Holds::Text => "text",
            Holds::Whole => "whole",
            Holds::Real => "number",
        };
        let _ = writeln!(text, "| `{}` | {holds} | {} |", column.name, column.what);
    }
    text
}
