//! What a sweep says: which sensors no other beats in both error and cost.
//!
//! A sensor is all of a point but its task (scene, receptive field, thresholds) and its seed.
//! Its error and its costs are means over its points. Only sensors that were given the same
//! tasks are compared: each set of tasks has a front of its own. Pooled, a sensor also has its
//! kernel and its thresholds, and all are compared.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::LazyLock,
};

use serde::Serialize;

use super::{
    column::Part,
    left_out::LeftOut,
    table::{self, Row},
    task_name::{self, Columns},
};
use crate::{
    order::Order,
    rig::guard::{About, Warning},
    study::{
        front::{Between, Cost, dominators, sure_dominators},
        sweep::{
            points::thresholds::Thresholds,
            results::{manifest::Manifest, record::is_failed},
        },
    },
    unit::Micros,
};

/// The columns that make a sensor. The mismatch of its thresholds is told behind its noise.
static SENSOR: LazyLock<Vec<&str>> = LazyLock::new(|| {
    let own = table::columns_of(&[Part::Model, Part::Sensor]);
    own.flat_map(|column| match column {
        "noise" => vec![column, "threshold_sigma"],
        _ => vec![column],
    })
    .collect()
});

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// What the study is called.
    pub title: String,
    /// The column that error is weighed against.
    pub cost: String,
    /// Points of the study.
    pub points: usize,
    /// Of which results are there.
    pub finished: usize,
    /// Sensors that were given the same tasks, the largest group first.
    pub groups: Vec<Group>,
    /// Sensors that cannot be, each with the first reason.
    pub refused: Vec<Refused>,
    /// Sensors with points that failed, each with the first reason.
    pub failed: Vec<Refused>,
    /// Sensors without this cost (only programs have words), or without an error.
    pub without: Vec<Without>,
}

/// A sensor that has no place among the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Without {
    /// What sets it apart.
    pub name: String,
    /// Why it has no error; none: it does not have this cost.
    pub no_error: Option<String>,
}

/// Sensors that can be compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Tasks that all of them were given; 0 where all sensors are pooled.
    pub tasks: usize,
    /// What sets these tasks apart from each other and from those of other groups; empty where
    /// nothing does.
    pub name: String,
    /// The values of the columns that make the tasks.
    pub on: Columns,
    /// In order of cost.
    pub sensors: Vec<Standing>,
}

/// One sensor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// What sets it apart.
    pub name: String,
    /// Reference, array or mesh.
    pub side: String,
    /// Its points.
    pub points: usize,
    /// Mean error.
    pub error: f64,
    /// Its worst error.
    pub worst_error: f64,
    /// The mean change of the f64 sensor's threshold that costs as much, in per cent; none where
    /// the study does not ask for it. A mean over points that are at least something is at least
    /// that, too.
    pub threshold_equivalent_percent: Option<f64>,
    /// Points of which it is only known that the change is more than what stands there.
    pub threshold_equivalent_least_at: usize,
    /// Mean cost.
    pub cost: f64,
    /// Mean bits of a scene.
    pub bits: f64,
    /// Instruction words of a frame, the mean over kernels; of arrays only.
    pub words: Option<f64>,
    /// The sensor on the front that beats it; none: it is on the front.
    pub dominated_by: Option<String>,
    /// The sensor that would beat it by figures that may be off by more than what they differ in,
    /// since plainer models stand for one of both.
    pub undecided_with: Option<String>,
    /// What plainer models leave out of it; none: nothing.
    pub left_out: Option<LeftOut>,
}

/// A sensor with points that cannot be, or failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refused {
    /// What sets it apart.
    pub name: String,
    /// How many points.
    pub points: usize,
    /// Why, of the first of them.
    pub reason: String,
    /// How many different reasons they have.
    pub reasons: usize,
}

/// What makes the figures of these rows mean something else than they seem to.
#[must_use]
pub fn warnings(rows: &[Row]) -> Vec<Warning> {
    let all = [by_chance(rows), silent(rows), slots(rows), saturated(rows)];
    all.into_iter().flatten().collect()
}

/// Points of which a run has warned of this.
fn warned(rows: &[Row], about: About) -> impl Iterator<Item = &Row> {
    rows.iter().filter(move |row| {
        let told = row.get("warnings").and_then(serde_json::Value::as_str);
        { told.unwrap_or_default().split(' ') }.any(|name| name == about.word())
    })
}

/// That events found no slot of the readout at some points, told of the point that lost most.
fn slots(rows: &[Row]) -> Option<Warning> {
    let points = warned(rows, About::Slots).count();
    let lost = warned(rows, About::Slots).filter_map(|row| {
        let number = |name: &str| row.get(name).and_then(serde_json::Value::as_u64);
        Some((number("dropped")?, number("events")?))
    });
    let part = |(lost, kept): &(u64, u64)| *lost as f64 / (lost + kept).max(1) as f64;
    let (lost, kept) = lost.max_by(|a, b| part(a).total_cmp(&part(b)))?;
    let subject = format!("{points} of {} points (here the worst)", rows.len());
    Some(Warning::slots(&subject, lost, kept))
}

/// That signals lie at the end of what a number format holds, at some points.
fn saturated(rows: &[Row]) -> Option<Warning> {
    let points = warned(rows, About::Saturation).count();
    (points > 0).then(|| Warning::saturated_points(points, rows.len()))
}

/// That neither sensor has an event at some points, which have no error to tell.
fn silent(rows: &[Row]) -> Option<Warning> {
    let none = |row: &&Row| {
        let number = |name: &str| row.get(name).and_then(serde_json::Value::as_f64);
        number("events") == Some(0.0) && number("reference_events") == Some(0.0)
    };
    let (points, of) = (rows.iter().filter(none).count(), rows.len());
    (points > 0).then(|| {
        let subject = format!("the error at {points} of {of} points");
        Warning::nothing_to_compare(&subject)
    })
}

/// That chance scores as much as anything at some points of these rows, told of the point where
/// it scores most.
fn by_chance(rows: &[Row]) -> Option<Warning> {
    let warned = rows.iter().filter_map(|row| {
        let number = |name: &str| row.get(name).and_then(serde_json::Value::as_f64);
        let floor = number("floor").filter(|_| number("reference_events") > Some(0.0))?;
        let window = Micros(number("window_us")? as u64);
        Some((floor, Warning::window(window, floor)?))
    });
    let warned: Vec<_> = warned.collect();
    let (points, of) = (warned.len(), rows.len());
    let (_, warning) = warned.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Warning {
        subjects: vec![format!("what is kept at {points} of {of} points")],
        ..warning
    })
}

impl Report {
    /// Weighs error against a cost, a column of [`COSTS`](crate::study::sweep::study::COSTS). `pool` compares all sensors,
    /// whatever their tasks.
    #[must_use]
    pub fn new(manifest: &Manifest, rows: &[Row], cost: &str, pool: bool) -> Self {
        let varying = varying(rows);
        let field = || task_name::field_columns().filter(|_| pool);
        let mut sensors: BTreeMap<Vec<String>, Vec<&Row>> = BTreeMap::new();
        for row in rows {
            let own = SENSOR.iter().copied().chain(field());
            let key = own.map(|column| value(row, column)).collect();
            sensors.entry(key).or_default().push(row);
        }
        let differing: Vec<&str> = field()
            .filter(|column| task_name::varies(rows, column))
            .collect();
        let mut groups: BTreeMap<BTreeSet<String>, Compared<'_>> = BTreeMap::new();
        let (mut refused, mut failed, mut without) = (Vec::new(), Vec::new(), Vec::new());
        for (key, rows) in &sensors {
            let field = rows.first().map_or_else(String::new, |first| {
                task_name::field(first, |column| differing.contains(&column))
            });
            let name = format!("{} {field}", name(key, &varying));
            let name = name.trim_end().to_owned();
            let of = |outcome: &str| -> Vec<&Row> {
                let rows = rows.iter().copied();
                rows.filter(|row| table::cell(row, "outcome") == outcome)
                    .collect()
            };
            let done = of("done");
            for (outcome, list) in [("refused", &mut refused), ("failed", &mut failed)] {
                let without = of(outcome);
                if let Some(first) = without.first() {
                    list.push(Refused {
                        name: name.clone(),
                        points: without.len(),
                        reason: table::cell(first, "reason"),
                        reasons: { without.iter() }
                            .map(|row| table::cell(row, "reason"))
                            .collect::<BTreeSet<_>>()
                            .len(),
                    });
                }
            }
            if done.is_empty() {
                continue;
            }
            let Some(standing) = standing(&name, key, &done, cost) else {
                let no_error = no_error(&done);
                without.push(Without { name, no_error });
                continue;
            };
            let tasks = done.iter().map(|row| table::cell(row, "task"));
            let tasks = if pool {
                BTreeSet::new()
            } else {
                tasks.collect()
            };
            let group = groups.entry(tasks).or_default();
            group.sensors.push(standing);
            group.rows.extend(done);
        }
        let mut groups: Vec<Group> = groups
            .into_iter()
            .map(|(tasks, Compared { sensors, rows })| Group {
                tasks: tasks.len(),
                name: String::new(),
                on: task_name::columns(&rows),
                sensors: judged(cost, sensors),
            })
            .collect();
        groups.order_by_key(|group| std::cmp::Reverse(group.sensors.len()));
        let on: Vec<Columns> = groups.iter().map(|group| group.on.clone()).collect();
        let on: Vec<&Columns> = on.iter().collect();
        for group in &mut groups {
            group.name = task_name::name(&group.on, &on);
        }
        Self {
            title: manifest.title.clone(),
            cost: cost.to_owned(),
            points: manifest.points.len(),
            finished: rows.iter().filter(|row| !is_failed(row)).count(),
            groups,
            refused,
            failed,
            without,
        }
    }
}

/// What was given the same tasks.
#[derive(Default)]
struct Compared<'a> {
    sensors: Vec<Standing>,
    rows: Vec<&'a Row>,
}

/// For each side the columns in which its sensors differ.
fn varying(rows: &[Row]) -> BTreeMap<String, Vec<bool>> {
    let mut seen: BTreeMap<String, Vec<BTreeSet<String>>> = BTreeMap::new();
    for row in rows {
        let own = seen.entry(table::cell(row, "side")).or_default();
        own.resize(SENSOR.len(), BTreeSet::new());
        for (values, column) in own.iter_mut().zip(&*SENSOR) {
            values.insert(value(row, column));
        }
    }
    let several = |values: Vec<BTreeSet<String>>| values.iter().map(|v| v.len() > 1).collect();
    seen.into_iter()
        .map(|(side, values)| (side, several(values)))
        .collect()
}

/// What a row has in one of [`SENSOR`]; the mismatch of kinds that differ is in another column.
fn value(row: &Row, column: &str) -> String {
    let own = table::cell(row, column);
    if column != "threshold_sigma" || !own.is_empty() {
        return own;
    }
    let thresholds = Thresholds::written(&table::cell(row, "thresholds"));
    thresholds.map_or_else(String::new, |thresholds| thresholds.sigma.to_string())
}

/// The side, its arithmetic, and what else differs among its sensors.
fn name(key: &[String], varying: &BTreeMap<String, Vec<bool>>) -> String {
    let side = key.first().map_or("", String::as_str);
    let own = varying.get(side);
    let mut words = vec![side.to_owned()];
    for (i, (column, value)) in SENSOR.iter().zip(key).enumerate().skip(1) {
        let differs = own.and_then(|own| own.get(i)).copied().unwrap_or(false);
        let always = ["format", "domain"].contains(column);
        if value.is_empty() || !(differs || always) {
            continue;
        }
        words.push(match *column {
            "refractory_us" => format!("dead {value} us"),
            "threshold_sigma" => format!("sigma {value}"),
            "shared" => "shared".to_owned(),
            "noise" if value == "none" => "no noise".to_owned(),
            "noise" => format!("noise {value}"),
            "sum" if value == "kept" => continue,
            "sum" => format!("sum {value}"),
            "readout" => format!("readout {value}"),
            "quantise" if value == "none" => "as is".to_owned(),
            _ => value.clone(),
        });
    }
    words.join(" ")
}

/// Why a sensor with these points has no error, told of the first that has none; none where all
/// have one.
pub(in crate::study::sweep) fn no_error(rows: &[&Row]) -> Option<String> {
    let number = |row: &Row, column: &str| row.get(column).and_then(serde_json::Value::as_f64);
    let mut bare = rows.iter().filter(|row| number(row, "error").is_none());
    let first = bare.next()?;
    let why = match number(first, "events") {
        Some(0.0) if number(first, "reference_events") == Some(0.0) => {
            "neither the float sensor nor this one has an event".to_owned()
        }
        Some(events) if number(first, "reference_events") == Some(0.0) => {
            format!("the float sensor has no event, this one has {events}")
        }
        _ => "chance alone scores 1".to_owned(),
    };
    let (some, all) = (bare.count() + 1, rows.len());
    Some(match all {
        1 => why,
        _ => format!("{why} (at {some} of {all} points, the first of them)"),
    })
}

fn standing(name: &str, key: &[String], rows: &[&Row], cost: &str) -> Option<Standing> {
    let numbers = |column: &str| -> Vec<f64> {
        let numbers = rows.iter().filter_map(|row| row.get(column)?.as_f64());
        numbers.filter(|number| number.is_finite()).collect()
    };
    let mean = |column: &str| {
        let numbers = numbers(column);
        let all = numbers.len();
        (all == rows.len() && all > 0).then(|| numbers.iter().sum::<f64>() / all as f64)
    };
    Some(Standing {
        name: name.to_owned(),
        side: key.first().cloned().unwrap_or_default(),
        points: rows.len(),
        error: mean("error")?,
        worst_error: numbers("error").into_iter().fold(0.0, f64::max),
        threshold_equivalent_percent: mean("threshold_equivalent_percent"),
        threshold_equivalent_least_at: { rows.iter() }
            .filter(|row| table::cell(row, "threshold_equivalent_is_least") == "true")
            .count(),
        cost: mean(cost)?,
        bits: mean("bits")?,
        words: mean("words"),
        dominated_by: None,
        undecided_with: None,
        left_out: LeftOut::of(rows),
    })
}

/// Marks each sensor with the one that dominates it, or would if their figures were their own.
fn judged(cost: &str, mut sensors: Vec<Standing>) -> Vec<Standing> {
    sensors.order_by(|a, b| a.cost.total_cmp(&b.cost).then(a.error.total_cmp(&b.error)));
    let costs: Vec<Cost> = sensors
        .iter()
        .map(|s| Cost {
            x: s.cost,
            y: s.error,
        })
        .collect();
    let all: Vec<Between> = { sensors.iter().zip(&costs) }
        .map(|(sensor, at)| match &sensor.left_out {
            Some(left_out) => left_out.between(cost, *at),
            None => Between::from(*at),
        })
        .collect();
    let names: Vec<String> = sensors.iter().map(|s| s.name.clone()).collect();
    let named = |by: Option<usize>| names.get(by?).cloned();
    let sure = sure_dominators(&all).into_iter().zip(dominators(&costs));
    let own = sensors.iter_mut().zip(&all).enumerate();
    for ((i, (sensor, at)), (sure, seeming)) in own.zip(sure) {
        // What has figures of another model may cost the most that they allow.
        let at_most = || {
            let mut others = all.iter().enumerate().filter(|(other, _)| *other != i);
            Some(others.find(|(_, it)| it.low.dominates(at.high))?.0)
        };
        let open = seeming.or_else(|| sensor.left_out.as_ref().and_then(|_| at_most()));
        sensor.dominated_by = named(sure);
        sensor.undecided_with = named(open).filter(|_| sure.is_none());
    }
    sensors
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn row(side: &str, format: &str, task: &str, error: f64, seconds: f64) -> Row {
        let row = json!({
            "side": side, "format": format, "task": task, "outcome": "done", "error": error,
            "bits": 10, "seconds_per_frame": seconds, "border": "zero",
        });
        row.as_object().unwrap().clone()
    }

    fn manifest(points: usize) -> Manifest {
        Manifest {
            amacrine: String::new(),
            schema: 1,
            numerics: 1,
            study: String::new(),
            title: "t".to_owned(),
            columns: Vec::new(),
            points: vec![String::new(); points],
            stated: BTreeMap::new(),
        }
    }

    #[test]
    fn only_sensors_with_the_same_tasks_are_compared() {
        let rows = [
            row("reference", "f64", "a", 0.0, 2.0),
            row("reference", "f64", "b", 0.2, 4.0),
            row("reference", "f32", "a", 0.2, 1.0),
            row("reference", "f32", "b", 0.2, 1.0),
            row("reference", "f16", "a", 0.3, 3.0),
            row("reference", "f16", "b", 0.5, 5.0),
            row("reference", "bf16", "a", 0.9, 9.0),
        ];
        let report = Report::new(&manifest(8), &rows, "seconds_per_frame", false);
        assert_eq!((report.points, report.finished), (8, 7));
        let names = |group: &Group| -> Vec<(String, Option<String>)> {
            let both = |s: &Standing| (s.name.clone(), s.dominated_by.clone());
            group.sensors.iter().map(both).collect()
        };
        let f = |format: &str| format!("reference {format}");
        assert_eq!(
            names(&report.groups[0]),
            [
                (f("f32"), None),
                (f("f64"), None),
                (f("f16"), Some(f("f64"))),
            ]
        );
        assert_eq!(names(&report.groups[1]), [(f("bf16"), None)]);
        let pooled = Report::new(&manifest(8), &rows, "seconds_per_frame", true);
        assert_eq!(pooled.groups.len(), 1);
        assert_eq!(names(&pooled.groups[0])[3].1, Some(f("f64")));
    }

    #[test]
    fn a_sensor_without_an_error_says_why() {
        let bare = |reference: u64| {
            let mut row = row("array", "f16", "a", 0.5, 1.0);
            row.insert("error".to_owned(), json!(null));
            row.insert("events".to_owned(), json!(7));
            row.insert("reference_events".to_owned(), json!(reference));
            row
        };
        let why = |rows: &[Row], cost: &str| {
            let report = Report::new(&manifest(1), rows, cost, false);
            report.without[0].no_error.clone()
        };
        let mut neither = bare(0);
        neither.insert("events".to_owned(), json!(0));
        assert_eq!(
            why(&[neither], "bits").as_deref(),
            Some("neither the float sensor nor this one has an event")
        );
        let silent = "the float sensor has no event, this one has 7";
        assert_eq!(
            why(&[bare(0)], "seconds_per_frame").as_deref(),
            Some(silent)
        );
        let chance = "chance alone scores 1";
        assert_eq!(
            why(&[bare(9)], "seconds_per_frame").as_deref(),
            Some(chance)
        );
        let some = why(&[row("array", "f16", "a", 0.5, 1.0), bare(0)], "bits").unwrap();
        assert_eq!(
            some,
            format!("{silent} (at 1 of 2 points, the first of them)")
        );
        assert_eq!(why(&[row("array", "f16", "a", 0.5, 1.0)], "words"), None);
    }

    #[test]
    fn a_mean_with_points_beyond_the_ladder_says_so() {
        let with = |task: &str, percent: f64, is_least: bool| {
            let mut row = row("reference", "f16", task, 0.5, 1.0);
            row.insert("threshold_equivalent_percent".to_owned(), json!(percent));
            let least = json!(is_least.then_some("true"));
            row.insert("threshold_equivalent_is_least".to_owned(), least);
            row
        };
        let standing = |rows: &[Row]| {
            let report = Report::new(&manifest(2), rows, "seconds_per_frame", false);
            let standing = &report.groups[0].sensors[0];
            let percent = standing.threshold_equivalent_percent.unwrap();
            (percent, standing.threshold_equivalent_least_at)
        };
        let known = with("a", 100.0, false);
        assert_eq!(
            standing(&[known.clone(), with("b", 900.0, true)]),
            (500.0, 1)
        );
        assert_eq!(standing(&[known, with("b", 900.0, false)]), (500.0, 0));
    }

    /// f16 with the figures of f64 and half the bytes is not better than f64.
    #[test]
    fn figures_of_a_plainer_model_claim_no_victory_within_its_limit() {
        let with = |format: &str, error: f64, bytes: u64, limit: Option<f64>| {
            let mut row = row("reference", format, "a", error, 1.0);
            row.insert("state_memory_bytes".to_owned(), json!(bytes));
            row.insert("floor".to_owned(), json!(0.5));
            if let Some(limit) = limit {
                row.insert("left_out".to_owned(), json!(format));
                row.insert("left_out_limit".to_owned(), json!(limit));
            }
            row
        };
        let rows = [
            with("f64", 0.0, 8, None),
            with("f16", 0.0, 2, Some(0.1)),
            with("q4.4", 0.3, 9, None),
            with("q8.8", 0.1, 9, None),
        ];
        let report = |cost: &str| Report::new(&manifest(4), &rows, cost, false);
        let told = report("state_memory_bytes");
        let [f16, f64, q8, q4] = &told.groups[0].sensors[..] else {
            panic!("{told:?}");
        };
        let f = |format: &str| Some(format!("reference {format}"));
        assert_eq!((&f16.dominated_by, &f16.undecided_with), (&None, &None));
        assert_eq!((&f64.dominated_by, &f64.undecided_with), (&None, &f("f16")));
        // 0.3 is beyond what f16 may be off by, 0.1 / (1 - 0.5), and so is 0.1 above f64.
        assert_eq!(q4.dominated_by, f("f64"));
        assert_eq!(q8.dominated_by, f("f64"));
        assert_eq!(f16.left_out.as_ref().unwrap().error_off, 0.2);
        // Its time is that of f64.
        let told = report("seconds_per_frame");
        let f16 = { told.groups[0].sensors.iter() }.find(|it| it.name == "reference f16");
        let f16 = f16.unwrap();
        assert!(f16.left_out.is_some());
        assert_eq!((&f16.dominated_by, &f16.undecided_with), (&None, &f("f64")));
    }

    #[test]
    fn groups_and_pooled_sensors_are_told_apart_by_kernel_and_threshold() {
        let with = |kernel: &str, threshold: f64| {
            let mut row = row(
                "reference",
                "f64",
                &format!("{kernel}{threshold}"),
                0.1,
                1.0,
            );
            for (column, value) in [
                ("kernel", json!(kernel)),
                ("threshold_on", json!(threshold)),
                ("threshold_off", json!(threshold)),
                ("scene", json!("s")),
            ] {
                row.insert(column.to_owned(), value);
            }
            row
        };
        let rows = [with("dog", 8.0), with("dvs", 8.0), with("dvs", 9.0)];
        let report = |pool: bool| Report::new(&manifest(3), &rows, "seconds_per_frame", pool);
        let told = report(false);
        let [group] = &told.groups[..] else {
            panic!("one sensor on three tasks: {told:?}");
        };
        assert_eq!(group.name, "kernel dog | dvs, threshold 8 | 9");
        assert_eq!(group.on["threshold_on"], [json!(8.0), json!(9.0)]);
        assert_eq!(group.on["scene"], [json!("s")]);
        let told = report(true);
        let names: Vec<&str> = { told.groups[0].sensors.iter() }
            .map(|s| &*s.name)
            .collect();
        let want = ["dog threshold 8", "dvs threshold 8", "dvs threshold 9"];
        assert_eq!(names, want.map(|field| format!("reference f64 {field}")));
    }
}
