//! Measuring a point: its sensor is made, watches its scene, and is compared.

use std::sync::Arc;

use serde_json::json;

use super::{
    fidelity,
    ground_truth::Truth,
    limits::Limits,
    memo::Shared,
    refusal::Refusal,
    watch::{Seen, watch},
};
use crate::{
    compare::{metric::Measured, voxel::Bins, window::Point},
    event::{Polarity, address},
    number::Format,
    plane::Size,
    reference::Description,
    rig::guard::Warning,
    study::sweep::{
        points::plan::{Entry, Plan},
        sensor::build::{Float, array_of, float},
        study_file::{key::Side, study::Settings},
        tables::table::{self, Row},
    },
};

/// Bins of the voxel grids.
const BINS: usize = 8;

/// A point as a row, before anything has come of it.
pub(in crate::study::sweep) fn described(plan: &Plan, entry: &Entry) -> Row {
    let settings = &plan.study.settings;
    let mut row = entry.point.columns();
    row.insert("id".to_owned(), json!(entry.id));
    row.insert("task".to_owned(), json!(entry.task));
    row.insert("against".to_owned(), json!(settings.against));
    row.insert("kinds".to_owned(), json!(entry.kernels.len()));
    let Size { height, width } = entry.scene.size;
    row.insert("width".to_owned(), json!(width));
    row.insert("height".to_owned(), json!(height));
    row.insert("frames_seen".to_owned(), json!(entry.scene.frames));
    row.insert("fps".to_owned(), json!(entry.scene.fps));
    row
}

/// The longest reason that is kept, in characters.
const REASON: usize = 2000;

/// A point of which nothing came, as a row.
pub(in crate::study::sweep) fn without_figures(mut row: Row, outcome: &str, why: &str) -> Row {
    let why: String = why.chars().take(REASON).collect();
    row.insert("reason".to_owned(), json!(why));
    row.insert("outcome".to_owned(), json!(outcome));
    row
}

/// Computes a point; what came of it, as a row.
pub(in crate::study::sweep) fn measure(
    plan: &Plan,
    entry: &Entry,
    shared: &Shared,
    limits: Limits<'_>,
) -> Row {
    let mut row = described(plan, entry);
    match run(plan, entry, shared, limits, &mut row) {
        Ok(()) => {
            row.insert("outcome".to_owned(), json!("done"));
            row
        }
        Err(Refusal::Cannot(why)) => without_figures(row, "refused", &why),
        // Figures of a half-watched scene are none.
        Err(Refusal::GivenUp(why)) => without_figures(described(plan, entry), "failed", &why),
    }
}

fn run(
    plan: &Plan,
    entry: &Entry,
    shared: &Shared,
    limits: Limits<'_>,
    row: &mut Row,
) -> Result<(), Refusal> {
    let settings = &plan.study.settings;
    let fits = limits.fits(entry.scene.size, entry.kernels.len());
    fits.map_err(|exhausted| exhausted.given_up())?;
    if let Some(plain) = fidelity::plain(plan, entry, shared, limits, row)? {
        // What a point is measured against is the same for points of one task.
        let key = format!("{} {}", entry.task, plain.key);
        let mut seen = plain.seen;
        let figures = shared.figures(&key, || {
            let mut figures = Row::new();
            measured(settings, entry, shared, limits, (&mut seen, &mut figures))?;
            Ok(figures)
        });
        let figures = match figures.get() {
            Some(Ok(figures)) => figures,
            Some(Err(refusal)) => return Err(refusal.clone()),
            None => return Err(Refusal::Cannot("nothing was measured".to_owned())),
        };
        // What is kept is told as a part of what chance leaves.
        let floor = figures.get("floor").and_then(serde_json::Value::as_f64);
        let most = settings.tolerance.unwrap_or(0.0) * (1.0 - floor.unwrap_or(0.0));
        if plain.limit <= most {
            row.extend(figures.clone());
            row.insert("left_out".to_owned(), json!(plain.left_out));
            row.insert("left_out_limit".to_owned(), json!(plain.limit));
            return Ok(());
        }
    }
    let mut seen = match entry.point.side() {
        Side::Reference | Side::Mesh => {
            let Float {
                description,
                format,
                seed,
            } = float(entry, row)?;
            Seen::float(entry, (&description, seed, format), shared, limits)?
        }
        Side::Array => {
            let made = array_of(settings, entry, shared, row)?;
            Seen::chip(&made, made.arithmetic, Arc::clone(&entry.scene))?
        }
    };
    measured(settings, entry, shared, limits, (&mut seen, row))
}

/// Fills in the figures of a sensor on the scene of a point.
fn measured(
    settings: &Settings,
    entry: &Entry,
    shared: &Shared,
    limits: Limits<'_>,
    (seen, row): (&mut Seen, &mut Row),
) -> Result<(), Refusal> {
    let (packet, seconds, mut warnings) = watch(seen, limits)?;
    let watched = |description: &Description| {
        let seen = Seen::float(entry, (description, 0, Format::F64), shared, limits);
        Ok(watch(&mut seen?, limits)?.0)
    };
    let made = shared.truth(&entry.task, || Truth::new(settings, entry, &watched));
    let truth = match made.get() {
        Some(Ok(truth)) => truth,
        Some(Err(refusal)) => return Err(refusal.clone()),
        None => return Err(Refusal::Cannot("the f64 sensor was not made".to_owned())),
    };
    let ladder = truth.ladder();
    let pair = ladder.pair(&packet)?;
    let headline = Point::new(&pair, ladder.redraws(), ladder.window());
    if !ladder.reference().events.is_empty() {
        warnings.extend(Warning::window(headline.window_us, headline.floor));
    }
    let frames = entry.scene.frames as f64;
    let on = packet
        .events
        .iter()
        .filter(|e| e.polarity == Polarity::On)
        .count();
    let erased = row.get("warnings").and_then(serde_json::Value::as_str);
    let erased = erased.map(str::to_owned);
    let mut put = |name: &str, value: serde_json::Value| row.insert(name.to_owned(), value);
    put("events", json!(packet.events.len()));
    put("on", json!(on));
    put("off", json!(packet.events.len() - on));
    put("dropped", json!(packet.dropped.total()));
    if !warnings.is_empty() {
        let mut names: Vec<&str> = erased.iter().map(String::as_str).collect();
        names.extend(warnings.iter().map(|w| w.about.word()));
        put("warnings", json!(names.join(" ")));
    }
    put("bits", json!(address::bits(&packet)));
    put("reference_events", json!(ladder.reference().events.len()));
    put("window_us", json!(headline.window_us));
    // Of two packets without an event nothing is kept and nothing lost.
    let told = !ladder.reference().events.is_empty();
    let kept = headline.kept.filter(|_| told);
    put("kept", json!(kept));
    let of_kinds = truth.kept_of_kinds(&packet)?;
    if !of_kinds.is_empty() {
        put("kept_of_kinds", json!(json!(of_kinds).to_string()));
    }
    put("floor", json!(headline.floor));
    put("error", json!(kept.map(|kept| 1.0 - kept)));
    if settings.threshold_equivalent && told {
        let (percent, is_least) = truth.equivalent(headline.f1, &watched)?;
        put("threshold_equivalent_percent", json!(percent));
        put(
            "threshold_equivalent_is_least",
            json!(is_least.then_some("true")),
        );
    }
    let measured = Measured::new(&pair, Bins::over(&pair, BINS), ladder.redraws());
    for metric in table::metrics(settings) {
        put(&metric.key(), json!(metric.value(&measured)));
    }
    put("seconds_per_frame", json!(seconds / frames));
    put("frames_per_s", json!(frames / seconds));
    put("events_per_s", json!(packet.events.len() as f64 / seconds));
    Ok(())
}
