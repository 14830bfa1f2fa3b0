//! What plainer models of a sensor change, and what they save.

use std::time::Instant;

use amacrine::{
    number::{Format, FormatError},
    reference::Description,
    scene::kept::Kept,
    study::{
        pilot::{Choice, Effect, Floats, Look, PlanError, Sampled, Survey, plan::KEPT, rule},
        trade::{Ask, Point, Trade, trade as survey_all},
    },
    unit::Micros,
};
use miette::{Report, miette};
use pyo3::prelude::*;
use serde::Serialize;

use super::Shown;
use crate::{
    error::{raised, refused},
    files::json,
    pool,
    sensor::Sensor,
};

/// Error against seconds, for every plainer model of a sensor in a scene.
#[pyfunction]
pub fn trade(
    py: Python<'_>,
    sensor: &Bound<'_, Sensor>,
    scene: Shown<'_>,
    upsample: Option<f64>,
    formats: Vec<String>,
    sample: (u64, f64, u32),
    how: (bool, u64),
) -> PyResult<String> {
    let ((within_us, sample, runs), (verify, seed)) = (sample, how);
    let description = &sensor.get().description;
    let formats: Vec<Format> = { formats.iter() }
        .map(|name| name.parse().map_err(|e: FormatError| raised(e)))
        .collect::<PyResult<_>>()?;
    if !(sample > 0.0 && sample <= 1.0) || runs == 0 {
        return Err(refused(
            format!("a sample of {sample}, {runs} runs"),
            "give a part above 0 and up to 1, and at least one run",
        ));
    }
    let source = scene.source()?;
    let answer = pool::work(py, || {
        let mut shown = source.open()?;
        let kept = Kept::new(&mut *shown, KEPT)?.ok_or_else(|| {
            miette!(
                help = "take a shorter or smaller scene, such as the first seconds of this one",
                "{} is too long to be kept in memory, and every model looks at all of it",
                source.name()
            )
        })?;
        if kept.len() < 3 {
            return Err(miette!(
                help = "give a scene of at least three frames",
                "{} has {} frames: nothing can be measured",
                source.name(),
                kept.len()
            ));
        }
        let start = Instant::now();
        let survey = Survey {
            kept: &kept,
            upsample,
            within: Micros(within_us),
            seed,
            clock: &|| start.elapsed().as_secs_f64(),
            sample,
        };
        Ok(traded(description, survey, formats, (verify, runs))?)
    })?;
    let trade: Trade<Choice> = answer.map_err(|report: Report| raised(report))?;
    let points: Vec<_> = { trade.points.iter() }
        .map(|point| Placed {
            error: point.error(),
            seconds: point.known().map(|known| known.seconds),
            planning_seconds: point.planning(),
            point,
        })
        .collect();
    json(&Traded {
        tiles: trade.tiles,
        no_tiles: trade.no_tiles.as_deref(),
        knee: trade.knee().map(|knee| knee.name.as_str()),
        points,
    })
}

/// What is told of a trade.
#[derive(Serialize)]
struct Traded<'a> {
    points: Vec<Placed<'a>>,
    tiles: Option<Sampled>,
    no_tiles: Option<&'a str>,
    knee: Option<&'a str>,
}

/// A model, and where it stands.
#[derive(Serialize)]
struct Placed<'a> {
    #[serde(flatten)]
    point: &'a Point<Choice>,
    error: Option<f64>,
    seconds: Option<f64>,
    planning_seconds: f64,
}

/// Every effect left out by itself, and other number formats.
fn traded(
    description: &Description,
    survey: Survey<'_>,
    formats: Vec<Format>,
    (verify, runs): (bool, u32),
) -> Result<Trade<Choice>, PlanError> {
    let full = Choice::full();
    let family = Floats {
        description,
        seed: survey.seed,
        base: &full,
    };
    let inserts = survey.upsample.is_some();
    let effects = Effect::ALL.into_iter();
    let effects = effects.filter(|effect| effect.is_in(description, inserts));
    let mut models: Vec<Choice> = effects.map(|it| Choice::full().and_without(it)).collect();
    models.extend(formats.into_iter().map(|format| Choice {
        format,
        without: Vec::new(),
    }));
    let free = |choice: &Choice, look: &Look| {
        // What rules say holds in double precision.
        let is_free = |effect: &Effect| match effect {
            Effect::DeadTime => rule::has_no_close_crossings(description, look),
            Effect::InsertedFrames => {
                rule::needs_no_inserted_frames(&choice.plainer(description)).is_some()
            }
            _ => false,
        };
        let left_out = !choice.without.is_empty() && choice.without.iter().all(is_free);
        (choice.format == Format::F64 && left_out)
            .then_some("the light and the sensor's rules say so")
    };
    let ask = Ask {
        survey,
        models,
        alternative: &|choice: &Choice| choice.format != Format::F64,
        free: &free,
        verify,
        runs,
        begin: &|_| (),
    };
    survey_all(&family, &ask)
}
