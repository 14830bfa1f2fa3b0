//! A study file: which points, and what is measured of each.

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use super::{
    entry::{self, Read},
    grid::{self, Axes},
    key::{Key, Side},
    point::Point,
    sample::{Method, Sample},
};
pub use crate::compare::metric::IN_STUDIES as METRICS;
use crate::{
    compile::Effort,
    isa::text::{Fault, Faults, Place, suggestion_or},
    unit::Micros,
};

/// A study, read and checked; nothing that it names has been opened.
#[derive(Clone, Debug)]
pub struct Study {
    /// The file's name as it was given.
    pub file: String,
    /// Its text.
    pub text: String,
    /// What it is called.
    pub title: String,
    /// What is measured.
    pub settings: Settings,
    /// The axes of each `[[side]]`.
    pub sides: Vec<Axes>,
    /// Points drawn in place of the grid.
    pub sample: Option<Sample>,
}

/// What holds for every point.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What is measured, by name.
    pub metrics: Vec<&'static str>,
    /// Windows of matches; the error of a point is 1 - F1 in the first of them.
    pub within: Vec<Micros>,
    /// Time constants of van Rossum's distance.
    pub van_rossum: Vec<Micros>,
    /// Shifts that cost 1 in Victor and Purpura's distance.
    pub victor_purpura: Vec<Micros>,
    /// Which memory the sensor has against which events are measured.
    pub against: &'static str,
    /// How long to search for each program, in states.
    pub effort: u64,
}

impl Settings {
    /// All that changes what is written of a point, in a fixed order.
    pub(super) fn measured(&self) -> serde_json::Value {
        serde_json::json!([
            self.metrics,
            self.within,
            self.van_rossum,
            self.victor_purpura,
            self.against
        ])
    }
}

/// Metrics that are measured when none are named: the cheap ones.
const USUAL: [&str; 5] = ["f1", "precision", "recall", "count-l1", "van-rossum"];

/// What the events are measured against.
pub const AGAINST: [&str; 4] = ["same", "filtered-snap", "filtered-step", "raw-snap"];

/// The keys beside the axes, and what each is.
pub const SETTINGS: [(&str, &str); 9] = [
    (
        "title",
        "what the study is called; the file's name when left out",
    ),
    ("source", "where the numbers come from, for people"),
    (
        "metrics",
        "what is measured of each point; `f1`, `precision`, `recall`, `count-l1` and `van-rossum` when left out",
    ),
    (
        "within",
        "windows of matches, such as `[\"1ms\", \"10ms\"]`; `\"1ms\"` when left out. A point's error is 1 - F1 in the first",
    ),
    (
        "van-rossum",
        "time constants of van Rossum's distance; `\"5ms\"` when left out",
    ),
    (
        "victor-purpura",
        "shifts that cost 1 in Victor and Purpura's distance; `\"5ms\"` when left out",
    ),
    (
        "against",
        "memory of the f64 sensor that events are measured against: `same` as the point's own (when left out), or one for all",
    ),
    (
        "effort",
        "how long to search for each program, in seconds of two cores of 2024; counted in states, so the result does not depend on the machine; 0.2 when left out",
    ),
    (
        "sample",
        "draw points instead of taking the whole grid: `{ method = \"sobol\", points = 256, seed = 0 }` or `method = \"random\"`",
    ),
];

impl Study {
    /// Reads the text of a study called `file`.
    ///
    /// # Errors
    /// Everything that is wrong, each with its place.
    pub fn parse(file: &str, text: &str) -> Result<Self, Faults> {
        let table = DeTable::parse(text).map_err(|e| {
            let place = e.span().map_or(Place::new(0, 0), Place::from);
            let fault = Fault::error(place, format!("not TOML: {}", e.message().trim()), "here")
                .help("write key = value; words go in quotes, as in kernel = \"csdvs-5\"");
            Faults::one(file, text, fault)
        })?;
        let mut reader = Reader {
            text,
            faults: Vec::new(),
        };
        let study = reader.study(file, table.get_ref());
        if !reader.faults.is_empty() {
            return Err(Faults::new(file, text, reader.faults));
        }
        study.ok_or_else(|| {
            // Nothing is missing without a fault.
            Faults::one(file, text, no_side())
        })
    }

    /// The points in their fixed order, as they are named: the same one may come twice.
    ///
    /// # Errors
    /// When there are too many, or none.
    pub fn points(&self) -> Result<Vec<Point>, Faults> {
        let points = match &self.sample {
            Some(sample) => Ok(sample.points(&self.sides)),
            None => grid::points(&self.sides),
        };
        points.map_err(|fault| self.fault(fault))
    }

    /// A fault in this file.
    #[must_use]
    pub fn fault(&self, fault: Fault) -> Faults {
        Faults::one(&self.file, &self.text, fault)
    }
}

fn no_side() -> Fault {
    Fault::error(
        Place::new(0, 0),
        "there is no [[side]]",
        "a study needs one",
    )
    .help("add [[side]] with side = \"reference\", \"array\" or \"mesh\", once for each sensor")
}

/// A key and what it is set to.
pub(super) type Entry<'a> = (
    &'a Spanned<toml::de::DeString<'a>>,
    &'a Spanned<DeValue<'a>>,
);

/// The study being read; everything that is wrong with it so far.
pub(super) struct Reader<'a> {
    pub text: &'a str,
    pub faults: Vec<Fault>,
}

impl Reader<'_> {
    /// What was read, or its fault is kept.
    pub fn keep<T>(&mut self, read: Read<T>) -> Option<T> {
        read.map_err(|fault| self.faults.push(fault)).ok()
    }

    fn study(&mut self, file: &str, table: &DeTable<'_>) -> Option<Study> {
        let mut axes = Vec::new();
        let mut settings = Vec::new();
        let mut sides = None;
        for (key, written) in table {
            let name = key.get_ref().as_ref();
            if name == "side" {
                sides = Some(written);
            } else if SETTINGS.iter().any(|(known, _)| *known == name) {
                settings.push((key, written));
            } else if Side::ALL
                .iter()
                .any(|side| Key::of(*side).any(|k| k.name == name))
            {
                axes.push((key, written));
            } else {
                let fault = entry::unknown(key, &all_names(), "in a study");
                self.faults.push(fault);
            }
        }
        let drawn = settings.iter().find(|(key, _)| key.get_ref() == "sample");
        let sample = drawn.and_then(|(_, written)| self.keep(sample(written)));
        let title = self.title(file, &settings);
        let settings = self.settings(&settings);
        let Some(written) = sides else {
            self.faults.push(no_side());
            return None;
        };
        let sides = self.sides(written, &axes, sample.is_some());
        self.unused(&axes, &sides);
        Some(Study {
            file: file.to_owned(),
            text: self.text.to_owned(),
            title: title?,
            settings: settings?,
            sides,
            sample,
        })
    }

    fn title(&mut self, file: &str, settings: &[Entry<'_>]) -> Option<String> {
        for (key, written) in settings {
            if key.get_ref() == "source" {
                let read = entry::word("source", written);
                self.keep(read)?;
            }
        }
        let given = settings.iter().find(|(key, _)| key.get_ref() == "title");
        let Some((_, written)) = given else {
            let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
            return Some(name.strip_suffix(".toml").unwrap_or(name).to_owned());
        };
        let read = entry::word("title", written).map(str::to_owned);
        self.keep(read)
    }

    fn settings(&mut self, written: &[Entry<'_>]) -> Option<Settings> {
        let named = |name: &str| {
            let found = written.iter().find(|(key, _)| key.get_ref() == name);
            found.map(|(_, value)| *value)
        };
        let metrics = match named("metrics") {
            None => Some(USUAL.to_vec()),
            Some(written) => {
                let read = metrics(written);
                self.keep(read)
            }
        };
        let mut times = |name, usual| {
            let read = named(name).map_or(Ok(vec![Micros(usual)]), |it| times(name, it));
            self.keep(read)
        };
        let within = times("within", 1_000);
        let van_rossum = times("van-rossum", 5_000);
        let victor_purpura = times("victor-purpura", 5_000);
        let against = named("against").map_or(Ok("same"), |written| {
            let word = entry::word("against", written)?;
            entry::one_of("against", word, &AGAINST, written.span().into())
        });
        let against = self.keep(against);
        let effort = named("effort").map_or(Ok(0.2), |written| {
            let seconds = entry::number("effort", written)?;
            if (0.0..=3600.0).contains(&seconds) {
                return Ok(seconds);
            }
            let what = format!("`effort` is {seconds}");
            Err(Fault::error(written.span().into(), what, "here")
                .help("give seconds from 0 to 3600"))
        });
        let effort = self.keep(effort);
        Some(Settings {
            metrics: metrics?,
            within: within?,
            van_rossum: van_rossum?,
            victor_purpura: victor_purpura?,
            against: against?,
            effort: Effort::seconds(effort?).states,
        })
    }
}

fn sample(written: &Spanned<DeValue<'_>>) -> Read<Sample> {
    let place: Place = written.span().into();
    let example = "{ method = \"sobol\", points = 256, seed = 0 }";
    let DeValue::Table(table) = written.get_ref() else {
        return Err(entry::kind("sample", written, example));
    };
    let mut parts = entry::Parts::of("sample", table, &["method", "points", "seed"], place)?;
    let missing = |key: &str| {
        Fault::error(place, format!("`sample` has no `{key}`"), "here")
            .help(format!("write sample = {example}"))
    };
    let method = parts.take("method").ok_or_else(|| missing("method"))?;
    let method = entry::one_of(
        "sample.method",
        entry::word("sample.method", method)?,
        &["random", "sobol"],
        method.span().into(),
    )?;
    let method = match method {
        "sobol" => Method::Sobol,
        _ => Method::Random,
    };
    let count = parts.take("points").ok_or_else(|| missing("points"))?;
    let points = entry::whole("sample.points", count)?;
    let most = method.most();
    if points == 0 || points > most {
        let what = format!("`sample.points` is {points}");
        return Err(Fault::error(count.span().into(), what, "here")
            .help(format!("give from 1 to {most} points")));
    }
    let seed = match parts.take("seed") {
        None => 0,
        Some(seed) => entry::whole("sample.seed", seed)?,
    };
    Ok(Sample {
        method,
        points,
        seed,
    })
}

/// Every key that can stand at the top.
fn all_names() -> Vec<&'static str> {
    let mut names: Vec<_> = SETTINGS.iter().map(|(name, _)| *name).collect();
    names.push("side");
    names.extend(super::key::KEYS.iter().map(|key| key.name));
    names
}

fn listed<'a>(written: &'a Spanned<DeValue<'a>>) -> Vec<&'a Spanned<DeValue<'a>>> {
    match written.get_ref() {
        DeValue::Array(list) => list.iter().collect(),
        _ => vec![written],
    }
}

fn metrics(written: &Spanned<DeValue<'_>>) -> Read<Vec<&'static str>> {
    let names = METRICS.map(|(name, _)| name);
    let mut chosen = Vec::new();
    for item in listed(written) {
        let word = entry::word("metrics", item)?;
        let Some(name) = names.iter().find(|name| **name == word) else {
            let otherwise = format!("known are {}", names.join(", "));
            let what = format!("unknown metric \"{word}\"");
            return Err(Fault::error(item.span().into(), what, "here")
                .help(suggestion_or(word, names, &otherwise)));
        };
        if !chosen.contains(name) {
            chosen.push(*name);
        }
    }
    Ok(chosen)
}

fn times(name: &str, written: &Spanned<DeValue<'_>>) -> Read<Vec<Micros>> {
    let mut all = Vec::new();
    for item in listed(written) {
        let word = entry::word(name, item)?;
        let time: Micros = word.parse().map_err(|_| {
            Fault::error(
                item.span().into(),
                format!("`{name}` takes times, \"{word}\" is none"),
                "here",
            )
            .help("give a number and a unit, such as 100us, 1ms or 0.5s")
        })?;
        if name != "within" && time.0 == 0 {
            let what = format!("`{name}` is 0");
            return Err(
                Fault::error(item.span().into(), what, "here").help("give a time above zero")
            );
        }
        if !all.contains(&time) {
            all.push(time);
        }
    }
    if all.is_empty() {
        return Err(
            Fault::error(written.span().into(), format!("`{name}` is empty"), "here")
                .help("give at least one time, or leave the key out"),
        );
    }
    Ok(all)
}
