//! `amacrine report`: which points of a sweep no other beats.

use std::{collections::BTreeMap, fmt::Write as _};

use miette::miette;
use serde_json::json;

use super::{
    arguments::light,
    output::{
        content::Content,
        files::{Input, Output},
    },
};
use crate::{
    picture::front::{Dot, FrontShow, fronts},
    study::{
        equivalent,
        sweep::{
            Report,
            key::Side,
            report::{Group, Refused, Standing, Without},
            store,
            study::COSTS,
        },
    },
    unit::{counted, signed},
};

/// What `report` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: amacrine report out/formats -o front.svg")]
pub struct Arguments {
    /// Folder that `amacrine sweep` or `amacrine merge` has written
    folder: Input,
    /// Draw error against cost (.svg or .png)
    #[arg(short, long, value_name = "FILE", value_parser = Content::Drawing)]
    output: Option<Output>,
    /// Cost to weigh against error
    #[arg(long, default_value = "seconds_per_frame", value_parser = COSTS)]
    cost: String,
    /// Compare all sensors, even those with different tasks
    ///
    /// Each kernel and each threshold is then a sensor of its own; means are taken over what else
    /// differs.
    #[arg(long)]
    pool: bool,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
///
/// # Errors
/// When the folder holds no results, or the picture cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let (manifest, rows, tables) = store::read(&arguments.folder)?;
    if rows.is_empty() {
        return Err(miette!(
            help = "run `amacrine sweep` first",
            "{} has no finished point",
            arguments.folder.display()
        ));
    }
    light::warn(&tables.warnings);
    let report = Report::new(&manifest, &rows, &arguments.cost, arguments.pool);
    if let Some(path) = &arguments.output {
        path.draw(&fronts(&shows(&report, arguments.pool)))?;
    }
    if arguments.json {
        let mut said = json!(report);
        if let Some(said) = said.as_object_mut() {
            said.insert("warnings".to_owned(), json!(tables.warnings));
            said.insert("computed_by".to_owned(), json!(tables.computed_by));
        }
        super::say(&format!("{said}\n"));
    } else {
        super::say(&table(&report, arguments));
    }
    Ok(())
}

/// A cost for people.
fn shown(cost: &str, value: f64) -> String {
    match cost {
        "seconds_per_frame" => format!("{:.3} ms", value * 1e3),
        _ => format!("{value:.0}"),
    }
}

/// An error in six characters. Where chance scores nearly 1 it can be far above 1: of that only
/// so much is told, so that columns stay apart.
fn error(error: f64) -> String {
    if error < 9.999_95 {
        format!("{error:.4}")
    } else {
        format!("{:>6}", ">10")
    }
}

/// The mean change of threshold that costs as much; a mean over points of which some are only known
/// to be more is more than that, too.
fn threshold(sensor: &Standing) -> String {
    let is_least = sensor.threshold_equivalent_least_at > 0;
    let least = if is_least { ">" } else { "" };
    sensor
        .threshold_equivalent_percent
        .map_or("-".to_owned(), |percent| {
            format!("{least}{} %", signed(percent, 1))
        })
}

/// What `>` before a mean of thresholds says.
fn beyond(group: &Group) -> String {
    let counts = { group.sensors.iter() }.map(|sensor| sensor.threshold_equivalent_least_at);
    let points = counts.sum::<usize>();
    if points == 0 {
        return String::new();
    }
    let most = (equivalent::RUNGS[equivalent::RUNGS.len() - 1] - 1.0) * 100.0;
    format!(
        "  threshold: {} lost more than the highest threshold that was tried, {most:+.0} %, and counts as that; a mean with such points is larger than the number after >\n",
        counted(points, "point")
    )
}

/// What a cost is called, with its unit.
fn label(cost: &str) -> &str {
    match cost {
        "seconds_per_frame" => "time per frame",
        "bits" => "bits of all events",
        "words" => "instruction words of a frame",
        _ => "bytes of state",
    }
}

/// What plainer models leave out of these sensors, each with its largest limit: lines below a table
/// or a chart, in which the sensors have a mark.
fn left_out(report: &Report, group: &Group) -> Vec<String> {
    let mut limits: BTreeMap<&str, f64> = BTreeMap::new();
    let marked = { group.sensors.iter() }.filter_map(|sensor| sensor.left_out.as_ref());
    let sensors = marked.clone().count();
    for left_out in marked {
        for what in &left_out.what {
            let limit = limits.entry(what).or_default();
            *limit = limit.max(left_out.limit);
        }
    }
    if sensors == 0 {
        return Vec::new();
    }
    let mut lines = vec![format!(
        "{MARK} {} with figures of a plainer model (fidelity = \"auto\"), in which at most so many events differ; left out:",
        counted(sensors, "sensor")
    )];
    let each = limits.iter();
    lines.extend(each.map(|(what, limit)| format!("  {what}: at most {:.1} %", 100.0 * limit)));
    if report.cost == "seconds_per_frame" {
        lines.push(
            "  their times are those of the plainer model, and are not used for the front"
                .to_owned(),
        );
    }
    if group.sensors.iter().any(|s| s.undecided_with.is_some()) {
        lines.push(
            "  open: because of what was left out, the sensor named may be better or not"
                .to_owned(),
        );
    }
    lines
}

/// Behind the name of a sensor that a plainer model stands for.
const MARK: &str = "*";

/// What a sensor is called in a table and a chart.
fn marked(sensor: &Standing) -> String {
    let mark = sensor.left_out.as_ref().map_or("", |_| MARK);
    format!("{} {mark}", sensor.name).trim_end().to_owned()
}

fn heading(group: &Group, number: usize, all: usize, pool: bool) -> String {
    let sensors = match group.sensors.len() {
        1 => "1 sensor".to_owned(),
        n => format!("{n} sensors"),
    };
    let tasks = match (group.tasks, pool) {
        (_, true) => "on tasks of their own, means over them".to_owned(),
        (1, _) => "on one task".to_owned(),
        (n, _) => format!("each on the same {n} tasks"),
    };
    let group_number = if all > 1 {
        format!("group {number}: ")
    } else {
        String::new()
    };
    let name = if group.name.is_empty() {
        String::new()
    } else {
        format!(": {}", group.name)
    };
    format!("{group_number}{sensors} {tasks}{name}")
}

fn table(report: &Report, arguments: &Arguments) -> String {
    let left = if report.finished < report.points {
        ": the others failed, are not computed yet, or were left out by a search"
    } else {
        ""
    };
    let mut text = format!(
        "study    {}\npoints   {} of {} finished{left}\n",
        report.title, report.finished, report.points
    );
    for (number, group) in (1..).zip(&report.groups) {
        let _ = writeln!(
            text,
            "\n{}; error is 1 - kept",
            heading(group, number, report.groups.len(), arguments.pool)
        );
        let width = group
            .sensors
            .iter()
            .map(|s| marked(s).len())
            .max()
            .unwrap_or(0);
        // What error is weighed against has a column of its own.
        let beside = |cost: &str, text: &str, width: usize| {
            if report.cost == cost {
                String::new()
            } else {
                format!("  {text:>width$}")
            }
        };
        let columns =
            |bits: &str, words: &str| beside("bits", bits, 10) + &beside("words", words, 5);
        let _ = writeln!(
            text,
            "  {:<width$}   error   worst  threshold  {:>14}{}  front",
            "sensor",
            label(&report.cost).split(" of ").next().unwrap_or_default(),
            columns("bits", "words"),
        );
        for sensor in &group.sensors {
            let words = sensor
                .words
                .map_or("-".to_owned(), |words| format!("{words:.0}"));
            let threshold = threshold(sensor);
            let front = match (&sensor.dominated_by, &sensor.undecided_with) {
                (Some(by), _) => format!("no, {by} is better"),
                (None, Some(by)) => format!("open, {by} may be better"),
                (None, None) => "yes".to_owned(),
            };
            let _ = writeln!(
                text,
                "  {:<width$}  {}  {}  {threshold:>9}  {:>14}{}  {front}",
                marked(sensor),
                error(sensor.error),
                error(sensor.worst_error),
                shown(&report.cost, sensor.cost),
                columns(&format!("{:.0}", sensor.bits), &words),
            );
        }
        text += &beyond(group);
        for line in left_out(report, group) {
            let _ = writeln!(text, "  {line}");
        }
    }
    for (what, list) in [("cannot", &report.refused), ("failed", &report.failed)] {
        for Refused {
            name,
            points,
            reason,
            reasons,
        } in list
        {
            let points = counted(*points, "point");
            let first = if *reasons > 1 {
                "the first of them: "
            } else {
                ""
            };
            let _ = writeln!(text, "\n{what}   {name} ({points}): {first}{reason}");
        }
    }
    if !report.without.is_empty() {
        text.push('\n');
    }
    for Without { name, no_error } in &report.without {
        let _ = match no_error {
            Some(why) => writeln!(text, "without  {name}: no error, since {why}"),
            None => writeln!(text, "without  {name}: no {}", label(&report.cost)),
        };
    }
    if let Some(path) = &arguments.output {
        let _ = writeln!(text, "\nwrote    {}", path.display());
    }
    text
}

fn shows(report: &Report, pool: bool) -> Vec<FrontShow<'_>> {
    let show = |(number, group): (usize, &Group)| {
        let dots = group.sensors.iter().map(|sensor| Dot {
            name: marked(sensor),
            cost: sensor.cost,
            error: sensor.error,
            dominated: sensor.dominated_by.is_some() || sensor.undecided_with.is_some(),
            side: Side::ALL
                .iter()
                .position(|side| side.name() == sensor.side)
                .unwrap_or(0),
        });
        FrontShow {
            heading: format!(
                "{}: {}",
                report.title,
                heading(group, number, report.groups.len(), pool)
            ),
            cost: label(&report.cost),
            seconds: report.cost == "seconds_per_frame",
            sides: Side::ALL.map(Side::name),
            dots: dots.collect(),
            notes: left_out(report, group),
        }
    };
    (1..).zip(&report.groups).map(show).collect()
}
