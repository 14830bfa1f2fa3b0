//! From a point to its sensor, and to the f64 sensor that it is measured against.
//!
//! The text is written here, not by `reference`: values stay as the study spells them, and the
//! text is part of a point's identity, so it may change for no other reason.

use std::fmt::Write as _;

use crate::{
    config::{Fault, Faults, Place},
    kernel::Kernel,
    photoreceptor::{Curve, Response},
    reference::Description,
    study::sweep::{points::point::Point, study_file::key::Side},
};

/// The sensor file of a float point, one key a line, with a channel for each of these kernels.
fn text(point: &Point, kernels: &[String]) -> String {
    let (response, scale) = response(point.word("response"));
    let mut text = format!("response = {response}\n");
    for key in ["memory", "polarity", "border"] {
        if let Some(word) = point.word(key) {
            let _ = writeln!(text, "{key} = {word:?}");
        }
    }
    if point.flag("shared") {
        text += "shared = true\n";
    }
    if let Some(refractory) = point.get("refractory") {
        let _ = writeln!(text, "refractory = {refractory}");
    }
    if let Some(noise) = point.word("noise").filter(|noise| *noise != "none") {
        let _ = writeln!(text, "noise = {noise}");
    }
    for (kind, kernel) in kernels.iter().enumerate() {
        text += &field(point, kernel, point.word("solver"));
        let [on, off, sigma] = point.threshold(kind).map(|number| number * scale);
        let _ = writeln!(
            text,
            "threshold = {{ on = {on:?}, off = {off:?}, sigma = {sigma:?} }}"
        );
    }
    text
}

/// The sensor file of what a point is measured against: the same receptive field in f64, whole
/// light, no dead time, no mismatch, no noise.
fn ideal_text(point: &Point, kernels: &[String], against: &str) -> String {
    let (given, scale) = response(point.word("response"));
    // A linear response only scales the signal, and thresholds are in light units.
    let response = if scale == 1.0 {
        given
    } else {
        "\"identity\"".to_owned()
    };
    let (own, shared) = memory(point);
    let memory = if against == "same" { own } else { against };
    let mut text = format!("response = {response}\nmemory = {memory:?}\n");
    if shared && own == memory {
        text += "shared = true\n";
    }
    let pixel = own == memory && point.word("polarity") == Some("pixel");
    let polarity = if pixel { "pixel" } else { "filtered" };
    let _ = writeln!(text, "polarity = {polarity:?}");
    let _ = writeln!(
        text,
        "border = {:?}",
        point.word("border").unwrap_or("zero")
    );
    for (kind, kernel) in kernels.iter().enumerate() {
        text += &field(point, kernel, None);
        let [on, off, _] = point.threshold(kind);
        let _ = writeln!(text, "threshold = {{ on = {on:?}, off = {off:?} }}");
    }
    text
}

/// What an event does to the memory of a point, and whether all kinds share one.
fn memory(point: &Point) -> (&str, bool) {
    let own = point.word("memory").unwrap_or_default();
    match point.side() {
        // As `study::together` has it.
        Side::Array if own == "shared" => ("raw-snap", true),
        Side::Array => ("filtered-snap", false),
        Side::Reference | Side::Mesh => (own, point.flag("shared")),
    }
}

/// What a kind of cells sees.
fn field(point: &Point, kernel: &str, solver: Option<&str>) -> String {
    let field = match point.side() {
        Side::Mesh => mesh(point, solver),
        Side::Reference | Side::Array => format!("kernel = {kernel}\n"),
    };
    format!("[[channel]]\n{field}")
}

fn mesh(point: &Point, solver: Option<&str>) -> String {
    let mut parts = Vec::new();
    for key in ["lambda", "lambda-y", "tau-us"] {
        parts.extend(
            point
                .number(key)
                .map(|number| format!("{key} = {number:?}")),
        );
    }
    parts.extend(solver.map(|rule| format!("rule = {rule:?}")));
    format!("mesh = {{ {} }}\n", parts.join(", "))
}

/// The response, and what light units become in it.
fn response(given: Option<&str>) -> (String, f64) {
    let given = given.unwrap_or("\"identity\"").to_owned();
    let scale = match Response::parse(&given).map(|read| read.curve) {
        Ok(Curve::Linear { white }) => 1.0 / white,
        _ => 1.0,
    };
    (given, scale)
}

/// The weights of a kernel, row by row.
pub(in crate::study::sweep) fn rows(kernel: &Kernel) -> Vec<Vec<f64>> {
    let rows = kernel.weights().rows();
    rows.into_iter().map(|row| row.to_vec()).collect()
}

fn written(kernels: &[Kernel]) -> Vec<String> {
    { kernels.iter() }
        .map(|kernel| format!("{:?}", rows(kernel)))
        .collect()
}

fn parse(text: &str) -> Result<Description, Faults> {
    let none = |name: &str| Err(std::io::Error::other(format!("{name} is not needed")));
    Description::parse("point", text, &none)
}

/// The sensor of a float point.
///
/// # Errors
/// When settings contradict each other.
pub(super) fn description(point: &Point, kernels: &[Kernel]) -> Result<Description, Faults> {
    parse(&text(point, &written(kernels)))
}

/// The sensor that a point is measured against.
///
/// # Errors
/// When settings contradict each other.
pub(in crate::study::sweep) fn ideal(
    point: &Point,
    kernels: &[Kernel],
    against: &str,
) -> Result<Description, Faults> {
    parse(&task(point, kernels, against))
}

/// All that makes the sensor that a point is measured against, in one text.
pub(in crate::study::sweep) fn task(point: &Point, kernels: &[Kernel], against: &str) -> String {
    ideal_text(point, &written(kernels), against)
}

/// What settings contradict each other, whatever the kernel, and at which key; `seen` saves
/// looking twice.
pub(in crate::study::sweep) fn contradiction(
    point: &Point,
    against: &str,
    seen: &mut std::collections::HashSet<String>,
) -> Option<(String, Fault)> {
    let kernel = ["[[1]]".to_owned()];
    let mut texts = vec![ideal_text(point, &kernel, against)];
    if point.side() != Side::Array {
        texts.push(text(point, &kernel));
    }
    for text in texts {
        if seen.contains(&text) {
            continue;
        }
        if let Err(error) = parse(&text) {
            let Some(first) = error.faults.into_iter().next() else {
                continue;
            };
            let line = text.lines().nth(first.line as usize - 1);
            let key = line.and_then(|line| line.split(" =").next()).unwrap_or("");
            let key = if key == "mesh" { "solver" } else { key };
            let fault = Fault::error(
                Place::new(0, 0),
                first.fault.message,
                "contradicts the others",
            );
            let advice = first.fault.help.unwrap_or_default();
            let help = format!("{advice}; or give those values a [[side]] of their own");
            return Some((key.to_owned(), fault.help(help)));
        }
        seen.insert(text);
    }
    None
}
