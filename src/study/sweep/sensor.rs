//! From a point to its sensor, and to the f64 sensor that it is measured against.
//!
//! The text is written here, not by `reference`: values stay as the study spells them, and the
//! text is part of a point's identity, so it may change for no other reason.

use std::fmt::Write as _;

use super::{key::Side, point::Point};
use crate::{
    config::{Fault, Faults, Place},
    kernel::Kernel,
    photoreceptor::{Curve, Response},
    reference::Description,
};

/// The sensor file of a float point, one key a line.
fn text(point: &Point, kernel: &str) -> String {
    let (response, scale) = response(point.word("response"));
    let mut text = format!("response = {response}\n");
    for key in ["memory", "polarity", "border"] {
        if let Some(word) = point.word(key) {
            let _ = writeln!(text, "{key} = {word:?}");
        }
    }
    if let Some(refractory) = point.get("refractory") {
        let _ = writeln!(text, "refractory = {refractory}");
    }
    if let Some(noise) = point.word("noise").filter(|noise| *noise != "none") {
        let _ = writeln!(text, "noise = {noise}");
    }
    text += "[[channel]]\n";
    if point.side() == Side::Mesh {
        text += &mesh(point, point.word("solver"));
    } else {
        let _ = writeln!(text, "kernel = {kernel}");
    }
    let [on, off, sigma] = point.thresholds().unwrap_or([1.0, 1.0, 0.0]);
    let [on, off, sigma] = [on * scale, off * scale, sigma * scale];
    let _ = writeln!(
        text,
        "threshold = {{ on = {on:?}, off = {off:?}, sigma = {sigma:?} }}"
    );
    text
}

/// The sensor file of what a point is measured against: the same receptive field in f64, whole
/// light, no dead time, no mismatch, no noise.
fn ideal_text(point: &Point, kernel: &str, against: &str) -> String {
    let (given, scale) = response(point.word("response"));
    // A linear response only scales the signal, and thresholds are in light units.
    let response = if scale == 1.0 {
        given
    } else {
        "\"identity\"".to_owned()
    };
    let own = match point.side() {
        Side::Array => None,
        Side::Reference | Side::Mesh => point.word("memory"),
    };
    let memory = match against {
        "same" => own.unwrap_or("filtered-snap"),
        one => one,
    };
    let mut text = format!("response = {response}\nmemory = {memory:?}\n");
    let pixel = own == Some(memory) && point.word("polarity") == Some("pixel");
    let polarity = if pixel { "pixel" } else { "filtered" };
    let _ = writeln!(text, "polarity = {polarity:?}");
    let _ = writeln!(
        text,
        "border = {:?}",
        point.word("border").unwrap_or("zero")
    );
    text += "[[channel]]\n";
    if point.side() == Side::Mesh {
        text += &mesh(point, None);
    } else {
        let _ = writeln!(text, "kernel = {kernel}");
    }
    let [on, off, _] = point.thresholds().unwrap_or([1.0; 3]);
    let _ = writeln!(text, "threshold = {{ on = {on:?}, off = {off:?} }}");
    text
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

fn rows(kernel: &Kernel) -> String {
    let rows = kernel.weights().rows();
    let rows: Vec<Vec<f64>> = rows.into_iter().map(|row| row.to_vec()).collect();
    format!("{rows:?}")
}

fn parse(text: &str) -> Result<Description, Faults> {
    let none = |name: &str| Err(std::io::Error::other(format!("{name} is not needed")));
    Description::parse("point", text, &none)
}

/// The sensor of a float point.
///
/// # Errors
/// When settings contradict each other.
pub(super) fn description(point: &Point, kernel: &Kernel) -> Result<Description, Faults> {
    parse(&text(point, &rows(kernel)))
}

/// The sensor that a point is measured against.
///
/// # Errors
/// When settings contradict each other.
pub(super) fn ideal(point: &Point, kernel: &Kernel, against: &str) -> Result<Description, Faults> {
    parse(&ideal_text(point, &rows(kernel), against))
}

/// All that makes the sensor that a point is measured against, in one text.
pub(super) fn task(point: &Point, kernel: &Kernel, against: &str) -> String {
    ideal_text(point, &rows(kernel), against)
}

/// What settings contradict each other, whatever the kernel, and at which key; `seen` saves
/// looking twice.
pub(super) fn contradiction(
    point: &Point,
    against: &str,
    seen: &mut std::collections::HashSet<String>,
) -> Option<(String, Fault)> {
    let mut texts = vec![ideal_text(point, "[[1]]", against)];
    if point.side() != Side::Array {
        texts.push(text(point, "[[1]]"));
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
