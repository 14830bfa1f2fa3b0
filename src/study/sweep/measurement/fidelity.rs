//! `fidelity = "auto"`: points that a pilot finds alike within the tolerance are computed once.
//!
//! The plain model of a float point is its sensor in f64, that of an array point the same program
//! on exact cells: every study has them, so whatever may stand for them costs nothing more. One
//! pilot on the tiles of a scene serves all formats of a sensor; it is kept by content in the
//! folder of results. How the array's work is ordered changes no event, and needs no pilot.

use std::sync::Arc;

use serde_json::json;
use sha2::{Digest, Sha256};

use super::{limits::Limits, memo::Shared, refusal::Refusal, watch::Seen};
use crate::{
    array::{Arithmetic, Schedule},
    compare::metric,
    number::Format,
    reference::{Description, Effect},
    study::{
        design,
        pilot::{ChangeEstimate, Chips, Choice, Family, Floats, Machine, Measure, look},
        sweep::{
            points::plan::{Entry, Plan},
            results::pilot_file::{Found, PilotFile},
            scene::{
                cached_scene::{CachedScene, hex},
                drive::driven,
            },
            sensor::build,
            study_file::{key::Side, study::Settings},
            tables::table::Row,
        },
    },
    unit::Micros,
};

/// What is left out of a point, and what stands for it.
pub(super) struct Plain {
    /// The same for all points that the same sensor stands for.
    pub key: String,
    /// What is left out.
    pub left_out: String,
    /// The upper confidence limit of the change (95 %); 0 where no event changes.
    pub limit: f64,
    pub seen: Seen,
}

/// The part of a sensor that a pilot runs: its cost is shared by many points.
const PART: f64 = 0.15;

/// What may stand for a point; none where it is computed as it is. What is known of the point itself
/// goes into the row.
pub(super) fn plain(
    plan: &Plan,
    entry: &Entry,
    shared: &Shared,
    limits: Limits<'_>,
    row: &mut Row,
) -> Result<Option<Plain>, Refusal> {
    let settings = &plan.study.settings;
    let Some(tolerance) = settings.tolerance else {
        return Ok(None);
    };
    match entry.point.side() {
        Side::Reference | Side::Mesh => float(plan, entry, shared, (limits, tolerance), row),
        Side::Array => array(plan, entry, shared, (limits, tolerance), row),
    }
}

/// Words of a key that the points of a study have on a side, each once.
fn words(plan: &Plan, side: Side, key: &str) -> Vec<String> {
    let entries = plan
        .entries
        .iter()
        .filter(|entry| entry.point.side() == side);
    let mut words: Vec<String> = entries
        .filter_map(|entry| entry.point.word(key).map(str::to_owned))
        .collect();
    words.sort_unstable();
    words.dedup();
    words
}

fn float(
    plan: &Plan,
    entry: &Entry,
    shared: &Shared,
    (limits, tolerance): (Limits<'_>, f64),
    row: &mut Row,
) -> Result<Option<Plain>, Refusal> {
    let build::Float {
        description: own,
        format,
        seed,
    } = build::float(entry, row)?;
    // Resistor sheets reach over the whole sensor and run whole, once; tiles are of their drive.
    let has_sheets = own.channels.iter().any(|c| c.surrounds.is_some());
    let (mut description, scene, seconds) = if has_sheets {
        let format = (&own, seed, format);
        match driven(&entry.scene, format, shared, limits) {
            Some(driven) => (driven.description, driven.scene, driven.seconds),
            None => return Ok(None),
        }
    } else {
        (own.clone(), Arc::clone(&entry.scene), 0.0)
    };
    let name = format.to_string();
    let has_dead_time = Effect::DeadTime.is_in(&description, false);
    let mut limit = 0.0;
    let mut left = vec![left_out(format != Format::F64, &name)];
    if format != Format::F64 || has_dead_time {
        let base = Choice::full();
        let family = Floats {
            description: &description,
            seed,
            base: &base,
        };
        let formats = words(plan, entry.point.side(), "format").into_iter();
        let formats = formats.filter_map(|name| name.parse::<Format>().ok());
        let candidates = formats
            .filter(|format| *format != Format::F64)
            .filter(|format| !has_sheets || own.behind_sheets(*format).is_some())
            .map(|format| {
                let without = Vec::new();
                (format.to_string(), Choice { format, without })
            });
        let mut candidates: Vec<_> = candidates.collect();
        let dead_time = Effect::DeadTime.to_string();
        if has_dead_time {
            let without = Choice::full().and_without(Effect::DeadTime);
            candidates.push((dead_time.clone(), without));
        }
        // A large kernel is not written out whole there; the task has all of its weights.
        let key = format!("{} {}", entry.task, key_of(&description, seed, &scene));
        let place = (&*scene, shared, limits);
        let limits = pilot(plan, place, (&key, &family), &candidates)?;
        if format != Format::F64 {
            limit = match limits.get(&name) {
                Some(limit) if *limit <= tolerance => *limit,
                _ => return Ok(None),
            };
        }
        // An event that both change counts twice at most.
        let both = limits.get(&dead_time).map(|without| limit + without);
        if let Some(both) = both.filter(|both| *both <= tolerance) {
            limit = both;
            description = Choice::full()
                .and_without(Effect::DeadTime)
                .plainer(&description);
            left.push(dead_time);
        }
    }
    left.retain(|word| !word.is_empty());
    Ok(Some(Plain {
        left_out: left.join(", "),
        limit,
        key: key_of(&description, seed, &scene),
        seen: Seen::plain(
            design::float(description, scene.size, seed, Format::F64)?,
            scene,
            seconds,
        ),
    }))
}

/// The same for sensors that say the same of a scene.
fn key_of(description: &Description, seed: u64, scene: &CachedScene) -> String {
    format!("{} {seed} {description:?}", scene.digest)
}

fn left_out(is_left_out: bool, what: &str) -> String {
    if is_left_out { what } else { "" }.to_owned()
}

fn array(
    plan: &Plan,
    entry: &Entry,
    shared: &Shared,
    (limits, tolerance): (Limits<'_>, f64),
    row: &mut Row,
) -> Result<Option<Plain>, Refusal> {
    let settings = &plan.study.settings;
    let point = &entry.point;
    let name = point.word("domain").unwrap_or("exact").to_owned();
    let seed = point.whole("seed").unwrap_or(0);
    let mut made = build::array_of(settings, entry, shared, row)?;
    let (arithmetic, all) = (made.arithmetic, made.all);
    // They are alike to the bit, and this one is the quicker.
    made.settings.schedule = Some(Schedule::Tiled { rows: 0 });
    // All that changes an event, the schedule left out.
    let program = format!(
        "{} {:?} {all} {:?} {:?}",
        entry.scene.digest, made.compiled.code, made.settings.clip, made.compiled.device
    );
    let program = hex(&Sha256::digest(program.as_bytes())[..16]);
    let mut limit = 0.0;
    let mut stands = arithmetic;
    let exact = Arithmetic::Number(Format::F64);
    if all && matches!(arithmetic, Arithmetic::Number(format) if format != Format::F64) {
        let family = Chips {
            name: &made.compiled.title,
            code: &made.compiled.code,
            device: &made.compiled.device,
            settings: made.settings,
            arithmetic: exact,
            reads_all: true,
        };
        let domains = words(plan, Side::Array, "domain").into_iter();
        let candidates = domains.filter_map(|name| match name.parse().ok()? {
            Arithmetic::Number(format) if format != Format::F64 => {
                let without = Vec::new();
                let format = Some(format);
                Some((name, Machine { format, without }))
            }
            Arithmetic::Number(_) | Arithmetic::Silicon { .. } => None,
        });
        let candidates: Vec<_> = candidates.collect();
        let place = (&*entry.scene, shared, limits);
        let limits = pilot(plan, place, (&program, &family), &candidates)?;
        if let Some(found) = limits.get(&name).filter(|found| **found <= tolerance) {
            (limit, stands) = (*found, exact);
        }
    }
    let mut left = vec![left_out(stands == exact && arithmetic != exact, &name)];
    left.push(format!(
        "schedule {}",
        point.word("schedule").unwrap_or_default()
    ));
    left.retain(|word| !word.is_empty());
    Ok(Some(Plain {
        key: format!("{program} {stands} {seed}"),
        left_out: left.join(", "),
        limit,
        seen: Seen::chip(&made, stands, Arc::clone(&entry.scene))?,
    }))
}

/// The limits of candidates against the plain model of a family on a scene: of what is kept, of
/// this run, or measured now.
fn pilot<F: Family>(
    plan: &Plan,
    (scene, shared, limits): (&CachedScene, &Shared, Limits<'_>),
    (key, family): (&str, &F),
    candidates: &[(String, F::Model)],
) -> Result<Found, Refusal> {
    let settings = &plan.study.settings;
    let tolerance = settings.tolerance.unwrap_or(0.0);
    let within = within(settings, scene.fps, tolerance);
    let names: Vec<&str> = candidates.iter().map(|(name, _)| name.as_str()).collect();
    let question = json!([
        key,
        names,
        within,
        tolerance,
        scene.digest,
        crate::study::sweep::SCHEMA
    ]);
    let question = question.to_string();
    let id = hex(&Sha256::digest(question.as_bytes())[..16]);
    let made = shared.pilot(&id, || {
        let kept = shared
            .pilots()
            .and_then(|folder| PilotFile::read(folder, &id));
        if let Some(kept) = kept {
            return Ok(kept.figures);
        }
        let begin = (limits.clock)();
        let figures = measured(scene, family, candidates, (within, tolerance))?;
        shared.count_pilot((limits.clock)() - begin);
        if let Some(folder) = shared.pilots() {
            let file = PilotFile {
                id: id.clone(),
                figures: figures.clone(),
                reason: None,
            };
            if let Err(error) = file.write(folder) {
                shared.cannot_keep(error);
            }
        }
        Ok(figures)
    });
    match made.get() {
        Some(Ok(limits)) => Ok(limits.clone()),
        Some(Err(refusal)) => Err(refusal.clone()),
        None => Ok(Found::new()),
    }
}

/// By how much an event may move and count as the same: a part of the narrowest window in which
/// anything is measured, or of the shortest time constant, as large as the tolerance. A distance of
/// spike trains grows by about as much for each event that moves.
fn within(settings: &Settings, fps: f64, tolerance: f64) -> Micros {
    let named = { settings.metrics.iter() }.filter_map(|name| metric::Entry::in_studies(name));
    let scales = named.flat_map(|metric| settings.scales(metric.scale));
    let all = settings.windows().iter().chain(scales).copied();
    let narrowest = all.fold(settings.headline(fps), Micros::min);
    Micros((narrowest.0 as f64 * tolerance) as u64)
}

fn measured<F: Family>(
    scene: &CachedScene,
    family: &F,
    candidates: &[(String, F::Model)],
    (within, tolerance): (Micros, f64),
) -> Result<Found, Refusal> {
    let kept = { scene.kept() }.map_err(|error| Refusal::given_up(&error))?;
    let (Some(kept), Ok(halo)) = (kept, family.halo()) else {
        return Ok(Found::new());
    };
    let tile = look::side(halo) + 2 * halo;
    // `as` saturates.
    let tiles = (PART * kept.size().pixels() as f64 / (tile * tile) as f64).ceil() as usize;
    // Those that are always looked at come besides: they say little of the others.
    let tiles = tiles.max(12) + look::EXTREMES;
    let measure = Measure {
        kept: &kept,
        upsample: None,
        tolerance,
        within,
        seed: 0,
        // What is measured is to be the same everywhere, so no clock decides.
        clock: &|| 0.0,
        budget: (0.0, 0.0),
        tiles: Some(tiles),
        look: None,
        limits_only: true,
    };
    let answer = measure.ask(family, candidates)?;
    let limit = |change: ChangeEstimate| {
        let limit = change.limit.filter(|limit| *limit < 1.0)?;
        // For each event of the point, not of the plain model.
        Some(limit / (1.0 - limit))
    };
    let offers = answer.offers.into_iter();
    Ok(offers
        .filter_map(|offer| Some((offer.what, limit(offer.change?)?)))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::sweep::study_file::study::Study;

    #[test]
    fn the_window_is_that_of_the_finest_metric() {
        for (keys, fps, want) in [
            ("metrics = [\"f1\"]", 100.0, 1_000),
            (
                "metrics = [\"f1\"]\nwithin = [\"20ms\", \"1ms\"]",
                100.0,
                10,
            ),
            ("", 100.0, 50),
            ("van-rossum = [\"5ms\", \"1ms\"]", 100.0, 10),
            (
                "metrics = [\"victor-purpura\"]\nvictor-purpura = \"2ms\"",
                2.0,
                20,
            ),
        ] {
            let text = format!(
                "{keys}\nscene = \"pattern:disc\"\nkernel = \"dvs\"\nthreshold = 20\n[[side]]\nside = \"reference\"\n"
            );
            let study = Study::parse("study.toml", &text).unwrap();
            assert_eq!(within(&study.settings, fps, 0.01), Micros(want), "{keys}");
        }
    }
}
