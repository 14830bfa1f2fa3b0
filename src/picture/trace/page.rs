//! The page itself: HTML around the script and what it reads.

use base64::{Engine, prelude::BASE64_STANDARD};
use maud::{DOCTYPE, PreEscaped, html};
use serde_json::json;
use sha2::{Digest as _, Sha256};

use super::{LARGEST, PictureError, Trace, pack::pack};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// How fine values are told, as parts of an LSB: the finest first.
const PARTS: [u32; 7] = [1024, 256, 64, 32, 16, 8, 4];

/// The page of a trace, at most [`LARGEST`] bytes: values as fine as fit; where even coarse ones
/// do not fit, of fewer pixels.
///
/// # Errors
/// When there is nothing to show.
pub fn page(trace: &Trace) -> Result<String, PictureError> {
    if trace.steps.is_empty() || trace.registers.is_empty() {
        return Err(PictureError::Nothing);
    }
    // The finer, the larger.
    let (mut best, mut low, mut high) = (None, 0, PARTS.len());
    while low < high {
        let middle = usize::midpoint(low, high);
        let page = whole(trace, PARTS[middle]);
        if page.len() <= LARGEST {
            best = Some(page);
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    if let Some(page) = best {
        return Ok(page);
    }
    if trace.shown().pixels() <= 1 {
        return Err(PictureError::TooLarge(trace.size));
    }
    page(&trace.thinned())
}

/// What the script is told of the steps.
fn description(trace: &Trace, parts: u32) -> String {
    let shown = trace.shown();
    let quiet = trace.steps.iter().flat_map(|step| &step.written);
    let quiet = quiet.take(1).any(|version| version.quiet.is_some());
    let registers = trace.registers.iter().map(|it| json!([it.name, it.is_bit]));
    let steps = trace.steps.iter().map(|step| {
        let written: Vec<usize> = step.written.iter().map(|it| it.register).collect();
        json!([step.frame, step.line, step.text, step.reads, written])
    });
    json!({
        "width": shown.width,
        "height": shown.height,
        "every": trace.every,
        "parts": parts,
        "quiet": quiet,
        "limit": trace.limit,
        "registers": registers.collect::<Vec<_>>(),
        "steps": steps.collect::<Vec<_>>(),
        "parting": trace.parting.as_ref().map(|it| json!({
            "frame": it.frame, "word": it.word, "register": it.register,
            "x": it.at.x, "y": it.at.y,
        })),
    })
    .to_string()
}

fn whole(trace: &Trace, parts: u32) -> String {
    // Writing to memory cannot fail.
    let data = pack(trace, &description(trace, parts), f64::from(parts)).unwrap_or_default();
    let hash = BASE64_STANDARD.encode(Sha256::digest(SCRIPT.as_bytes()));
    let policy =
        format!("default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'");
    let title = trace.title.as_ref().unwrap_or(&trace.program);
    let words = trace.steps.iter().filter(|step| step.line > 0).count();
    let (first, last) = (trace.steps.first(), trace.steps.last());
    let frames = match (
        first.map_or(0, |it| it.frame),
        last.map_or(0, |it| it.frame),
    ) {
        (a, b) if a == b => format!("frame {a}"),
        (a, b) => format!("frames {a} to {b}"),
    };
    html! {
        (DOCTYPE)
        html lang="en-GB" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content={ "amacrine " (env!("CARGO_PKG_VERSION")) };
                title { "Trace of " (trace.program) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    p.kind { "Register trace" }
                    h1 { (title) }
                    p.lead {
                        (trace.program) " on " (trace.machine) ", " (trace.size)
                        " pixels, beside itself in exact arithmetic: " (frames) ", " (words)
                        " words and operations."
                    }
                }
                noscript { p { "This page steps through a program with a script of its own; it loads nothing. Allow scripts for it." } }
                p #fault hidden role="alert" {}
                nav #bar aria-label="Steps" hidden {
                    div.row {
                        button #first type="button" title="first (Home)" aria-label="first" { "|◀" }
                        button #back type="button" title="one back (left arrow)" aria-label="one back" { "◀" }
                        button #play type="button" title="play (space)" aria-label="play" aria-pressed="false" { "play" }
                        button #next type="button" title="one on (right arrow)" aria-label="one on" { "▶" }
                        button #last type="button" title="last (End)" aria-label="last" { "▶|" }
                        input #slide type="range" min="0" value="0" aria-label="step";
                    }
                    p #word aria-live="polite" {}
                    p #line { code {} }
                    div.row.small {
                        label { input #noise type="checkbox" checked; " noise" }
                        label { input #apart type="checkbox"; " difference" }
                        label { input #follow type="checkbox"; " follow" }
                        span.part {
                            button #part type="button" { "first that parts" }
                            label { " by " input #limit type="number" min="0" step="0.25" inputmode="decimal"; " LSB" }
                        }
                        span.part {
                            label { "pixel: column " input #column type="number" min="0" inputmode="numeric"; }
                            label { " row " input #row type="number" min="0" inputmode="numeric"; }
                        }
                    }
                    p #found aria-live="polite" {}
                }
                main hidden {
                    section #registers aria-label="Registers" { h2 { "Registers" } }
                    section #listing aria-label="Program" {
                        h2 { "Program" }
                        ol #text {
                            @for line in trace.text.lines() { li { code { (line) } } }
                        }
                    }
                }
                footer {
                    h2 { "How to read it" }
                    ul {
                        li { "Each register: left on the chip, right in exact arithmetic. Black is the lowest value of a picture and white its highest, which stand below it. What the word wrote has a solid frame, what it read a dashed one." }
                        li { "Point at a pixel, touch it, or give its column and row, for its value in all registers." }
                        li { "Difference: chip less exact, less the median of that; blue is more, vermilion less." }
                        li { "The first that parts: the first word after which a pixel of the chip differs from its exact self by more than the limit, the median difference of the pixels that are shown not counted, or a bit differs." }
                        li { "Noise: that of the chip's stores; what differs from pixel to pixel stays without it. Follow: the page scrolls to what a word wrote." }
                        li { "Values are told to 1/" (parts) " LSB." }
                        @if trace.every > 1 {
                            li #sampled { strong { "Sampled: " } "of " (trace.every) " rows and columns one is shown, so that the page stays below " (LARGEST / 1_000_000) " MB. Neighbours in a picture are " (trace.every) " pixels apart." }
                        }
                        @if let Some(it) = &trace.parting {
                            li #parting { "Of all pixels, by more than " (trace.limit) " LSB, they first part in " (it.to_string()) "." }
                        } @else {
                            li #parting { "Nowhere does a pixel part by more than " (trace.limit) " LSB." }
                        }
                        @for note in &trace.notes { li { (sentence(note)) } }
                    }
                    p { "Made by amacrine " (env!("CARGO_PKG_VERSION")) "." }
                }
                script #data type="application/octet-stream" { (PreEscaped(BASE64_STANDARD.encode(data))) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// A message as a sentence of the page.
fn sentence(message: &str) -> String {
    let mut letters = message.chars();
    let first = letters.next().map(char::to_uppercase);
    first
        .into_iter()
        .flatten()
        .chain(letters)
        .chain(['.'])
        .collect()
}
