//! From a number of the answer to its sources.
//!
//! A number is made of others by a formula, and in the end of figures of the chip's data, of
//! counts, and of what was given. `LINKS` has the formulas in words; which figures an estimate
//! is made of it says itself ([`Estimate::inputs`](super::Estimate::inputs)).

use std::fmt;

use serde_json::Value as Json;

use super::{
    Feasibility,
    estimate::short,
    named::{FigureSummary, Named},
};
use crate::{
    config::suggestion_or,
    isa::{Device, Evidence, PrimitiveKind},
};

/// A number, how it is made, and what of.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Explanation {
    /// Its name.
    pub name: String,
    /// Its place in the JSON; none of a figure of the chip's data.
    pub pointer: Option<String>,
    /// Its value, with its unit.
    pub value: String,
    /// How well it is known; none where it is counted or given.
    pub evidence: Option<Evidence>,
    /// The formula in words, or who states it.
    pub says: String,
    /// What it is made of.
    pub inputs: Vec<Self>,
}

/// A name or a place at which there is no number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("there is no number `{what}` to explain")]
#[diagnostic(help("{help}"))]
pub struct ExplainError {
    /// What was asked for.
    pub what: String,
    /// What there is.
    pub help: String,
}

/// A number with a name of its own.
struct Link {
    name: &'static str,
    pointer: &'static str,
    /// The unit of a plain number; an estimate has its own.
    unit: &'static str,
    formula: &'static str,
    /// By name.
    of: &'static [&'static str],
    /// Whether it depends on all that is drawn.
    is_of_errors: bool,
    /// Whether it is as well known as the weakest of what it is made of.
    is_of_inputs: bool,
}

impl Link {
    const fn new(
        name: &'static str,
        pointer: &'static str,
        formula: &'static str,
        of: &'static [&'static str],
    ) -> Self {
        Self {
            name,
            pointer,
            unit: "",
            formula,
            of,
            is_of_errors: false,
            is_of_inputs: false,
        }
    }

    /// In a unit.
    const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Worked out from what it is made of alone.
    const fn of_inputs(self) -> Self {
        Self {
            is_of_inputs: true,
            ..self
        }
    }

    /// Found by running the program with the chip's errors.
    const fn of_errors(self) -> Self {
        Self {
            is_of_errors: true,
            ..self
        }
    }
}

/// The numbers with names, each after those that are made of it.
const LINKS: &[Link] = &[
    Link::new(
        "chips_feasible",
        "/chips_feasible",
        "share of the drawn chips that keep at least 0.8 of the float sensor's events and reach the frame rate; each number of a chip is drawn from its interval, mismatch and noise by a seed of its own",
        &["chips", "fps", "window_us", "array_us", "readout_us"],
    )
    .of_errors(),
    Link::new("chips", "/chips", "as given: --chips", &[]),
    Link::new(
        "threshold_equivalent",
        "/streams/silicon/judged/threshold_equivalent_percent",
        "the change of the float sensor's threshold at which it keeps as much, read from a ladder of float sensors with other thresholds",
        &["kept"],
    )
    .unit("%")
    .of_errors(),
    Link::new(
        "kept",
        "/streams/silicon/judged/kept",
        "(F1 - floor) / (1 - floor)",
        &["f1", "floor"],
    )
    .of_errors(),
    Link::new(
        "f1",
        "/streams/silicon/judged/likeness/f1",
        "harmonic mean of precision and recall against the float sensor, of events matched within the window; the program runs on the chip of the seed, with every error at its value",
        &["events", "window_us"],
    )
    .of_errors(),
    Link::new(
        "floor",
        "/streams/silicon/judged/likeness/floor",
        "F1 of redraws of the float sensor: right places and rates, times by chance",
        &["window_us"],
    ),
    Link::new(
        "window_us",
        "/within_us",
        "--within; else 100 ms, or the time from frame to frame where that is longer",
        &[],
    )
    .unit("us"),
    Link::new(
        "ceiling",
        "/fit/on_chip/time/ceiling",
        "1 / the time of a frame: overlapped, the longer of exposure, and array then readout; sequential, the longer of exposure and array, then readout",
        &["array_us", "readout_us", "exposure_us"],
    ),
    Link::new(
        "exposure_us",
        "/fit/on_chip/time/exposure",
        "as given: --exposure",
        &[],
    ),
    Link::new(
        "array_us",
        "/fit/on_chip/time/array",
        "words / the highest clock; at most plus one launch for each word",
        &["words"],
    ),
    Link::new(
        "readout_us",
        "/fit/on_chip/time/readout",
        "scans x slots for the busiest frame x time of a slot, or scans x rows x time of a row of bits where that is less: all rows, or those in which the scene has events",
        &["slots"],
    ),
    Link::new(
        "slots",
        "/fit/on_chip/time/slots_of_scene",
        "counted: the most events of one sign in a frame of this scene, on the chip of the seed",
        &["events"],
    ),
    Link::new(
        "power.known",
        "/power/known",
        "the array while it is busy, and the link; idle, readout and host are not known, and not in it",
        &["power.busy", "power.link"],
    ),
    Link::new(
        "power.busy",
        "/power/busy/power",
        "full power / the highest clock x words a frame x frames/s",
        &["words", "fps"],
    ),
    Link::new(
        "power.idle",
        "/power/idle/at_most",
        "not known; at most full power for the time in which no word runs",
        &["words", "fps"],
    ),
    Link::new(
        "power.link",
        "/power/link/power",
        "bits a second x energy of a bit",
        &["kbit_s", "bit_pj"],
    ),
    Link::new(
        "energy.frame",
        "/power/frame",
        "known power / frames/s",
        &["power.known", "fps"],
    ),
    Link::new(
        "energy.event",
        "/power/event",
        "known power / events a second of the chip",
        &["power.known", "events"],
    ),
    Link::new("bit_pj", "/link/bit", "as given: --link-energy", &[]),
    Link::new(
        "kbit_s",
        "/streams/silicon/mean_kbit_s",
        "events x bits of an address word / the time of the scene",
        &["events"],
    )
    .unit("kbit/s"),
    Link::new(
        "events",
        "/streams/silicon/events",
        "counted: events of the program on the chip of the seed, over the whole scene",
        &[],
    )
    .of_errors(),
    Link::new(
        "words",
        "/fit/on_chip/frame_words",
        "counted: instruction words of a frame, over the program that the compiler found",
        &[],
    ),
    Link::new(
        "noise.temporal",
        "/fit/on_chip/noise/temporal",
        "noise of each store through the rest of the program, the squares added",
        &["words"],
    ),
    Link::new(
        "noise.fixed",
        "/fit/on_chip/noise/fixed",
        "mismatch of each cell through the rest of the program, the squares added",
        &["words"],
    ),
    Link::new(
        "noise.margin",
        "/fit/on_chip/noise/margin",
        "threshold / (sqrt(2) x noise of a result): a decision compares two frames",
        &["noise.temporal"],
    )
    .of_inputs(),
    Link::new(
        "fps",
        "/scene/fps",
        "the scene's frame rate, or --fps",
        &[],
    )
    .unit("frames/s"),
];

/// Whether a number can be explained, before anything is run: a name, a figure, or a place in
/// the JSON, which may still turn out to be empty.
///
/// # Errors
/// When it can be none of these.
pub fn check(what: &str, device: &Device) -> Result<(), ExplainError> {
    let words = PrimitiveKind::ALL.iter().copied().map(Named::Words);
    let figures = FigureSummary::all(device, &words.collect::<Vec<_>>());
    let is_figure = figures.iter().any(|it| it.figure == what);
    let is_link = LINKS.iter().any(|link| link.name == what);
    if is_link || is_figure || what.starts_with('/') {
        Ok(())
    } else {
        Err(unknown(what))
    }
}

fn unknown(what: &str) -> ExplainError {
    let names = || LINKS.iter().map(|link| link.name);
    let known: Vec<&str> = names().collect();
    let all = format!(
        "give one of {}; a figure such as error.noise; or a place in the JSON such as /power/known",
        known.join(", ")
    );
    ExplainError {
        what: what.to_owned(),
        help: suggestion_or(what, names(), &all),
    }
}

/// The chain from a number to its sources: by name (`array_us`, `ceiling`, `power.busy`), as a
/// figure of the chip's data (`error.noise`), or by its place in the JSON (`/power/known`).
///
/// # Errors
/// When there is no such number.
pub fn explain(all: &Feasibility, what: &str) -> Result<Explanation, ExplainError> {
    let json = serde_json::to_value(all).unwrap_or_default();
    let chain = Chain { all, json: &json };
    let found = if let Some(link) = LINKS.iter().find(|link| link.name == what) {
        chain.link(link)
    } else if let Some(figure) = all.figures.iter().find(|figure| figure.figure == what) {
        Some(of_figure(figure))
    } else if what.starts_with('/') {
        chain.place(what)
    } else {
        None
    };
    found.ok_or_else(|| {
        if LINKS.iter().any(|link| link.name == what) {
            let help = "this answer has none, as where there is no program, no event to keep, or a window in which chance alone scores nearly 1 (--within)";
            return ExplainError {
                what: what.to_owned(),
                help: help.to_owned(),
            };
        }
        unknown(what)
    })
}

struct Chain<'a> {
    all: &'a Feasibility,
    json: &'a Json,
}

impl Chain<'_> {
    /// A number with a name; nothing where this answer has none.
    fn link(&self, link: &Link) -> Option<Explanation> {
        let at = self.json.pointer(link.pointer)?;
        let known = |name: &&str| LINKS.iter().find(|link| link.name == *name);
        let mut inputs: Vec<Explanation> = { link.of.iter() }
            .filter_map(known)
            .filter_map(|link| self.link(link))
            .collect();
        let mut evidence = evidence(at);
        // What lies in an input of this one is not said again.
        let named = |inputs: &[Explanation], name: &str| inputs.iter().any(|it| it.says_of(name));
        let figures: Vec<&FigureSummary> = { self.all.figures.iter() }
            .filter(|figure| match at.get("inputs").and_then(Json::as_array) {
                Some(names) => names.iter().any(|name| name == figure.figure.as_str()),
                None => link.is_of_errors && figure.is_of_events(),
            })
            .collect();
        if link.is_of_errors {
            let weakest = figures.iter().map(|figure| figure.interval_evidence);
            evidence = Some(Evidence::weakest(weakest));
        }
        if link.is_of_inputs {
            evidence = Some(Evidence::weakest(
                inputs.iter().filter_map(|it| it.evidence),
            ));
        }
        for figure in figures {
            if !named(&inputs, &figure.figure) {
                inputs.push(of_figure(figure));
            }
        }
        Some(Explanation {
            name: link.name.to_owned(),
            pointer: Some(link.pointer.to_owned()),
            value: value(at, link.unit)?,
            evidence,
            says: link.formula.to_owned(),
            inputs,
        })
    }

    /// What stands at a place of the JSON: a number with a name, an estimate, or a bare number.
    fn place(&self, pointer: &str) -> Option<Explanation> {
        let at = self.json.pointer(pointer)?;
        let (parent, _) = pointer.rsplit_once('/')?;
        let is_end = pointer.ends_with("/low") || pointer.ends_with("/high");
        let of = if is_end { parent } else { pointer };
        if let Some(link) = LINKS.iter().find(|link| link.pointer == of) {
            return self.link(link);
        }
        let whole = self.json.pointer(of)?;
        let names = whole.get("inputs").and_then(Json::as_array);
        let is_input = |figure: &&FigureSummary| {
            names.is_some_and(|all| all.iter().any(|name| name == figure.figure.as_str()))
        };
        let says = whole.get("source").and_then(Json::as_str);
        Some(Explanation {
            name: pointer.to_owned(),
            pointer: Some(pointer.to_owned()),
            value: value(if is_end { whole } else { at }, "")?,
            evidence: evidence(whole),
            says: says
                .unwrap_or("counted, or found by running the sensors: docs/feasibility.md")
                .to_owned(),
            inputs: { self.all.figures.iter() }
                .filter(is_input)
                .map(of_figure)
                .collect(),
        })
    }
}

impl FigureSummary {
    /// Whether a chip computes with it.
    fn is_of_events(&self) -> bool {
        let costs = ["clock.", "scan_", "global_", "store."];
        let is_cost = |cost: &&str| self.figure.starts_with(cost);
        !costs.iter().any(is_cost) && !self.figure.contains(".words")
    }
}

impl Explanation {
    /// Whether it or anything that it is made of is this.
    fn says_of(&self, name: &str) -> bool {
        self.name == name || self.inputs.iter().any(|input| input.says_of(name))
    }

    fn write(&self, f: &mut fmt::Formatter<'_>, depth: usize) -> fmt::Result {
        let evidence = self.evidence.map_or("", Evidence::word);
        let name = format!("{}{}", "  ".repeat(depth), self.name);
        writeln!(
            f,
            "{name:<30} {:<28} {evidence:<9} {}",
            self.value, self.says
        )?;
        for input in &self.inputs {
            input.write(f, depth + 1)?;
        }
        Ok(())
    }
}

impl fmt::Display for Explanation {
    /// A line for each number, what it is made of below it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, 0)
    }
}

fn of_figure(figure: &FigureSummary) -> Explanation {
    let between = if figure.low < figure.high {
        format!(", {} to {}", short(figure.low), short(figure.high))
    } else {
        String::new()
    };
    let unit = match figure.unit {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let why = { figure.why.as_ref() }.map_or(String::new(), |why| format!("; interval: {why}"));
    Explanation {
        name: figure.figure.clone(),
        pointer: None,
        value: format!("{}{between}{unit}", short(figure.value)),
        evidence: Some(figure.interval_evidence),
        says: format!("{} ({}){why}", figure.source, figure.evidence.word()),
        inputs: Vec::new(),
    }
}

/// A number, or an estimate, with its unit.
fn value(at: &Json, unit: &str) -> Option<String> {
    if let Some(number) = at.as_f64() {
        let number = if number.fract() == 0.0 {
            format!("{number}")
        } else {
            short(number)
        };
        return Some(format!("{number} {unit}").trim_end().to_owned());
    }
    let [low, high] = [at.get("low")?.as_f64()?, at.get("high")?.as_f64()?];
    let unit = match at.get("unit")?.as_str()? {
        "1" => "",
        unit => unit,
    };
    let text = if low < high {
        format!("{} to {} {unit}", short(low), short(high))
    } else {
        format!("{} {unit}", short(low))
    };
    Some(text.trim_end().to_owned())
}

/// How well an estimate is known.
fn evidence(at: &Json) -> Option<Evidence> {
    let word = at.get("evidence")?.as_str()?;
    Evidence::ALL.into_iter().find(|it| it.word() == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_link_leads_to_links_that_there_are() {
        for link in LINKS {
            for name in link.of {
                let next = LINKS.iter().find(|other| other.name == *name);
                assert!(next.is_some(), "{} of {name}", link.name);
            }
        }
        let mut names: Vec<&str> = LINKS.iter().map(|link| link.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), LINKS.len());
    }
}
