//! The columns of the results: one schema for CSV, JSON lines and Parquet.

use std::fmt::Write as _;

use serde_json::{Map, Value as Json};

use super::study::Settings;
use crate::compare::metric::{Entry, Metric};

/// A row: a value for each column that has one.
pub type Row = Map<String, Json>;

/// What stands in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Text.
    Text,
    /// Whole numbers.
    Whole,
    /// Numbers.
    Real,
}

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

const fn text(name: &'static str, what: &'static str) -> (&'static str, Holds, &'static str) {
    (name, Holds::Text, what)
}

const fn whole(name: &'static str, what: &'static str) -> (&'static str, Holds, &'static str) {
    (name, Holds::Whole, what)
}

const fn real(name: &'static str, what: &'static str) -> (&'static str, Holds, &'static str) {
    (name, Holds::Real, what)
}

/// What the point is.
const POINT: [(&str, Holds, &str); 42] = [
    whole("index", "number of the point in the fixed order, from 0"),
    text(
        "id",
        "identity: a hash of the point's description and of all that it names",
    ),
    text(
        "task",
        "identity of the f64 sensor that it is measured against, on its scene: points of one task answer one question",
    ),
    text("side", "reference, array or mesh"),
    text("scene", "as it is named in the study"),
    real(
        "fps",
        "frames per second of the scene, before any are inserted",
    ),
    whole("frames", "frames of the source, where the study says so"),
    text(
        "range",
        "which samples are black and white, where the study says so",
    ),
    text(
        "transfer",
        "the transfer that is undone, where the study says so",
    ),
    real("scale", "what the numbers of an array are multiplied by"),
    text(
        "slice",
        "which frames of the scene, where the study says so",
    ),
    text(
        "crop",
        "which part of each picture, where the study says so",
    ),
    text(
        "resize",
        "to what size it is averaged, where the study says so",
    ),
    real(
        "upsample",
        "largest change of light (of 255) plus 1 between frames, in ln units; empty: no frames inserted",
    ),
    text("kernel", "as it is named in the study"),
    whole("kinds", "kinds of cells: kernels of the file"),
    real("lambda", "space constant of the mesh, pixels"),
    real(
        "lambda_y",
        "space constant down the columns, pixels, where it is another",
    ),
    real("tau_us", "time constant of the mesh, microseconds"),
    real(
        "threshold_on",
        "light units (0 to 255) times kernel; ln units under a logarithmic response; empty where kinds differ",
    ),
    real("threshold_off", "the same, a positive magnitude"),
    real(
        "threshold_sigma",
        "deviation of the threshold's mismatch, same unit",
    ),
    text(
        "thresholds",
        "the thresholds of each kind, as in the study, where kinds differ",
    ),
    text("response", "photoreceptor, as in a sensor file"),
    text("border", "what the kernel reads off the array"),
    text(
        "rule",
        "what an event does to the memory: the `memory` of a sensor file",
    ),
    text(
        "shared",
        "true: one memory of the pixel for all kinds of a float sensor",
    ),
    text("polarity", "where the sign of an event comes from"),
    real("refractory_us", "dead time, microseconds"),
    text("refractory_rule", "dead-time or authors"),
    text("noise", "none, or the keys of a sensor file's `[noise]`"),
    text("format", "number format of a float sensor"),
    text("solver", "how the mesh is moved on"),
    text("chip", "as it is named in the study"),
    text("quantise", "quantiser of the kernel"),
    text("sum", "what the quantised kernel must sum to"),
    text(
        "kept_in",
        "what the array keeps of the last events, and where",
    ),
    text(
        "readout",
        "chip: 4000 events of either sign a frame at most; all: every event",
    ),
    text("domain", "arithmetic of the array"),
    text("schedule", "order of the array's work"),
    whole(
        "seed",
        "of mismatch, noise and stochastic rounding; empty where there is no chance",
    ),
    text(
        "against",
        "memory of the f64 sensor that it is measured against",
    ),
];

/// What came of it, before the metrics.
const FIGURES: [(&str, Holds, &str); 24] = [
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
    real(
        "kept",
        "what of F1 is more than accident, within that window",
    ),
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
const FIDELITY: [(&str, Holds, &str); 2] = [
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
const MACHINE: [(&str, Holds, &str); 4] = [
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

/// All columns of a study, in their order.
#[must_use]
pub fn columns(settings: &Settings) -> Vec<Column> {
    let column = |(name, holds, what): &(&str, Holds, &str)| Column {
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
    let before = POINT.iter().chain(&FIGURES).chain(fidelity).map(column);
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
pub(super) fn cell(row: &Row, column: &str) -> String {
    match row.get(column) {
        None | Some(Json::Null) => String::new(),
        Some(Json::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    }
}

/// What stands in a column of this name; metrics are numbers.
#[must_use]
pub fn holds(name: &str) -> Holds {
    let fixed = POINT.iter().chain(&FIGURES).chain(&FIDELITY);
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
