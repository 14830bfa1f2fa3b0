//! What a study states, key by key: so that two studies can be told apart in words.

use std::collections::{BTreeMap, BTreeSet};

use super::study::Study;
use crate::{
    study::sweep::points::{
        sample::{Method, Sample},
        thresholds::{PerKind, Thresholds},
        value::{Ramp, Value, Values},
    },
    unit::Micros,
};

/// The keys of the study and of each side, each with its values.
pub type Stated = BTreeMap<String, BTreeMap<String, String>>;

/// What holds for the whole study.
const STUDY: &str = "study";

/// How points are drawn, and by a search.
const SAMPLE: &str = "sample";
const SEARCH: &str = "search";

/// The longest value that is told, in letters.
const LONGEST: usize = 100;

/// All keys of a study, those that are left out with what they are then.
pub(in crate::study::sweep) fn stated(study: &Study) -> Stated {
    let mut all = Stated::new();
    let settings = &study.settings;
    let times = |times: &[Micros]| {
        let times: Vec<_> = times.iter().map(ToString::to_string).collect();
        times.join(", ")
    };
    let mut own: BTreeMap<String, String> = [
        ("metrics", settings.metrics.join(", ")),
        ("within", times(&settings.within)),
        ("van-rossum", times(&settings.van_rossum)),
        ("victor-purpura", times(&settings.victor_purpura)),
        ("against", settings.against.to_owned()),
        (
            "threshold-equivalent",
            settings.threshold_equivalent.to_string(),
        ),
        ("effort", format!("{} states", settings.effort)),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into();
    let fidelity = settings.tolerance.map_or("full", |_| "auto");
    own.insert("fidelity".to_owned(), fidelity.to_owned());
    if let Some(tolerance) = settings.tolerance {
        own.insert("tolerance".to_owned(), tolerance.to_string());
    }
    if let Some(sample) = study.sample {
        own.insert(SAMPLE.to_owned(), drawn(sample));
    }
    all.insert(STUDY.to_owned(), own);
    for (number, side) in (1..).zip(&study.sides) {
        let axes = side.axes.iter();
        let axes = axes.map(|axis| (axis.key.name.to_owned(), text(&axis.values)));
        all.insert(format!("side {number}, {}", side.side), axes.collect());
    }
    all
}

/// Whether a search draws the points of a study that states this.
pub(in crate::study::sweep) fn is_search(stated: &Stated) -> bool {
    let sample = stated.get(STUDY).and_then(|own| own.get(SAMPLE));
    sample.is_some_and(|sample| sample.starts_with(SEARCH))
}

/// How points are drawn.
fn drawn(sample: Sample) -> String {
    let Sample {
        method,
        points,
        seed,
        search,
    } = sample;
    let method = match method {
        Method::Random => "random",
        Method::Sobol => "sobol",
        Method::Search => SEARCH,
    };
    let search = search.map_or(String::new(), |search| {
        format!(", finish {}, cost {}", search.finish, search.cost)
    });
    format!("{method}, {points} points, seed {seed}{search}")
}

/// The values of an axis.
fn text(values: &Values) -> String {
    match values {
        Values::List(list) => {
            let list: Vec<_> = list.iter().map(|(value, _)| one(value)).collect();
            list.join(", ")
        }
        Values::Ramp(Ramp {
            from,
            to,
            steps,
            log,
        }) => {
            let steps = steps.map_or(String::new(), |steps| format!(" in {steps} steps"));
            let log = if *log { ", in equal factors" } else { "" };
            format!("{from} to {to}{steps}{log}")
        }
    }
}

/// A value, as short as a study can have it.
fn one(value: &Value) -> String {
    match value {
        Value::Threshold(of) => match of.on {
            PerKind::All(both) if *of == Thresholds::both(both) => both.to_string(),
            _ => value.to_string(),
        },
        _ => value.to_string(),
    }
}

/// The keys that differ, each with what it is in both, and in which sides; none where only what is
/// named has changed.
pub(in crate::study::sweep) fn changes(held: &Stated, asked: &Stated) -> Vec<String> {
    // What several sides say alike is told once.
    let mut all: BTreeMap<(String, String, String), Vec<&str>> = BTreeMap::new();
    let names: BTreeSet<&String> = held.keys().chain(asked.keys()).collect();
    for name in names {
        let [Some(held), Some(asked)] = [held.get(name), asked.get(name)] else {
            let is = |all: &Stated| {
                if all.contains_key(name) {
                    "present"
                } else {
                    "absent"
                }
            };
            let both = ("[[side]]".to_owned(), is(held).into(), is(asked).into());
            all.entry(both).or_default().push(name);
            continue;
        };
        let keys: BTreeSet<&String> = held.keys().chain(asked.keys()).collect();
        for key in keys {
            if held.get(key) != asked.get(key) {
                let [held, asked] = [held, asked].map(|all| all.get(key).map_or("", |it| it));
                let both = (key.clone(), shown(held), shown(asked));
                all.entry(both).or_default().push(name);
            }
        }
    }
    let differs = |((key, held, asked), sides): (&(String, String, String), &Vec<&str>)| {
        let of = match sides[..] {
            [STUDY] => String::new(),
            _ => format!(" ({})", sides.join("; ")),
        };
        format!("`{key}`{of} is {held} there, {asked} here")
    };
    all.iter().map(differs).collect()
}

/// A value for people: nothing is said to be so, and what is long is cut.
fn shown(value: &str) -> String {
    if value.is_empty() {
        return "left out".to_owned();
    }
    if value.chars().count() <= LONGEST {
        return value.to_owned();
    }
    let start: String = value.chars().take(LONGEST).collect();
    format!("{start}…")
}
