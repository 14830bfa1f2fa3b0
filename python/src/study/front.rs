//! What plainer models of a sensor change, and what they save.

use std::time::Instant;

use amacrine::{
    array::{Arithmetic, ArithmeticError, Schedule},
    isa::Device,
    number::{Format, FormatError},
    photoreceptor::Response,
    picture::svg,
    reference::{Description, Effect},
    scene::{Scene as _, kept::Kept},
    study::{
        pilot::{Chips, Choice, Floats, Look, NoLimit, PlanError, Sampled, Survey, plan::KEPT},
        trade::{Ask, Point, Programs, Setup, Trade, told::Told, trade as survey_all},
    },
    unit::{Micros, counted},
};
use miette::{Report, miette};
use pyo3::prelude::*;
use serde::Serialize;

use super::{Shown, open_on};
use crate::{
    error::{raised, refused},
    files::json,
    options::in_python,
    program::Program,
    sensor::Sensor,
    source::Source,
};

/// Microseconds by which an event is changed, the part of the sensor that is run, and how many runs
/// share what it took to know the error.
type Sample = (u64, f64, u32);

/// The contrast that frames are inserted for, the sample, and whether all is run whole, and the seed.
type Asked = (Option<f64>, Sample, (bool, u64));

/// What the caller writes for what was asked about, and `, scale=…` where the frames were given one.
#[derive(FromPyObject)]
pub struct Called(String, String);

/// What was asked about, its full model, and what runs a model of it.
type Telling<'a, M> = (&'a str, &'a str, &'a (dyn Fn(&M) -> String + Sync));

/// Error against seconds, for every plainer model of a sensor in a scene.
#[pyfunction]
pub fn trade(
    py: Python<'_>,
    sensor: &Bound<'_, Sensor>,
    scene: Shown<'_>,
    upsample: Option<f64>,
    formats: Vec<String>,
    sample: Sample,
    how: (bool, u64),
    called: Called,
) -> PyResult<(String, String)> {
    let description = &sensor.get().description;
    let formats = numbers(&formats)?;
    let source = scene.source()?;
    let response = description.response;
    let command = |choice: &Choice| of_sensor(choice, upsample, &called);
    let told = (
        &*description.name,
        "f64, with all its effects",
        &command as &_,
    );
    let asked = (upsample, sample, how);
    let trade = |survey: Survey<'_>| traded(description, survey, &formats, (how.0, sample.2));
    surveyed(py, (&source, response, None), asked, trade, told)
}

/// The same of a program, whose full model is in a domain.
#[pyfunction]
pub fn trade_program(
    py: Python<'_>,
    program: &Bound<'_, Program>,
    domain: &str,
    scene: Shown<'_>,
    formats: Vec<String>,
    sample: Sample,
    how: (bool, u64),
    called: Called,
) -> PyResult<(String, String)> {
    let program = program.get();
    program.check_steady()?;
    let arithmetic: Arithmetic = domain.parse().map_err(|e: ArithmeticError| raised(e))?;
    let formats = numbers(&formats)?;
    let source = scene.source()?;
    let shown = (&source, Response::IDENTITY, Some(program.device()));
    let (verify, seed) = how;
    let command = |setup: &Setup| of_program(setup, seed, &called);
    let told = (program.file(), domain, &command as &_);
    let trade = |survey: Survey<'_>| {
        let mut settings = program.settings();
        settings.threads = Some(rayon::current_num_threads());
        let arithmetic = arithmetic.with_seed(survey.seed);
        let chips = program.chips(settings, arithmetic);
        programmed(chips, survey, &formats, (verify, sample.2))
    };
    surveyed(py, shown, (None, sample, how), trade, told)
}

/// What makes the events of a model, of the `sensor` that was asked about.
fn of_sensor(choice: &Choice, upsample: Option<f64>, called: &Called) -> String {
    let mut text = format!("{}.in_format(\"{}\")", called.0, choice.format);
    let without = choice.without.iter().map(|effect| effect.word());
    let without: Vec<_> = { without }
        .filter(|key| *key != Effect::InsertedFrames.word())
        .map(|key| format!("\"{key}\""))
        .collect();
    if !without.is_empty() {
        text = text + ".without(" + &without.join(", ") + ")";
    }
    let upsample = upsample.filter(|_| !choice.leaves_out(Effect::InsertedFrames));
    let upsample = upsample.map_or(String::new(), |contrast| format!(", upsample={contrast}"));
    text + &format!(".events(frames, fps{}{upsample})", called.1)
}

/// What runs a model, of the `program` that was asked about.
fn of_program(setup: &Setup, seed: u64, called: &Called) -> String {
    let domain = match setup.machine.format {
        Some(format) => Arithmetic::Number(format),
        None => Arithmetic::Silicon { seed: 0 },
    };
    let without: Vec<_> = { setup.without().iter() }
        .map(|term| format!("\"{}\"", term.word()))
        .collect();
    let without = match without.len() {
        0 => String::new(),
        _ => format!(", without=[{}]", without.join(", ")),
    };
    let seed = match seed {
        0 => String::new(),
        seed => format!(", seed={seed}"),
    };
    let order = if setup.ordered {
        format!("  # {}: the command line has schedules", setup.schedule)
    } else {
        String::new()
    };
    let Called(program, scale) = called;
    format!("{program}.run(frames, fps{scale}, domain=\"{domain}\"{without}{seed}){order}")
}

fn numbers(formats: &[String]) -> PyResult<Vec<Format>> {
    formats
        .iter()
        .map(|name| name.parse().map_err(|e: FormatError| raised(e)))
        .collect()
}

/// Keeps the scene and surveys it; the answer as JSON, and as a drawing.
fn surveyed<M: Send>(
    py: Python<'_>,
    (source, response, device): (&Source, Response, Option<&Device>),
    (upsample, (within_us, sample, runs), (verify, seed)): Asked,
    trade: impl FnOnce(Survey<'_>) -> Result<Trade<M>, PlanError> + Send,
    (of, full, command): Telling<'_, M>,
) -> PyResult<(String, String)> {
    if !(sample > 0.0 && sample <= 1.0) || runs == 0 {
        return Err(refused(
            format!("a sample of {sample}, {runs} runs"),
            "give a part above 0 and up to 1, and at least one run",
        ));
    }
    let answer = source.study(py, response, || {
        let mut shown = match device {
            Some(device) => open_on(source, device)?,
            None => source.open()?,
        };
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
                "{}: {}, in which nothing can be measured",
                source.name(),
                counted(kept.len(), "frame")
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
            stop: source.stop(),
        };
        let trade = trade(survey)?;
        let told = Told {
            of,
            scene: source.name(),
            fps: kept.scene().fps(),
            full,
            verify,
            runs,
            command,
        };
        let drawing = svg(&told.drawing(&trade));
        Ok((as_json(&trade, command), drawing))
    })?;
    let (answer, drawing) = answer.map_err(|report: Report| raised(report))?;
    Ok((answer?, in_python(&drawing)))
}

/// A trade as JSON.
fn as_json<M>(trade: &Trade<M>, command: &dyn Fn(&M) -> String) -> PyResult<String> {
    let points: Vec<_> = { trade.points.iter() }
        .map(|point| {
            let seconds = point.known().map(|known| known.seconds);
            Placed {
                error: point.error(),
                no_limit: point.no_limit(),
                seconds: seconds.map(|seconds| seconds.median),
                seconds_range: seconds.map(|seconds| [seconds.least, seconds.most]),
                planning_seconds: point.planning(),
                command: command(&point.model),
                point,
            }
        })
        .collect();
    json(&Traded {
        tiles: trade.tiles,
        no_tiles: trade.no_tiles.as_deref(),
        without_slot: trade.without_slot,
        knee: trade.knee().map(|knee| knee.name.as_str()),
        no_knee: trade.no_knee(),
        command: trade.knee().map(|knee| command(&knee.model)),
        points,
    })
}

/// What is told of a trade.
#[derive(Serialize)]
#[serde(bound = "")]
struct Traded<'a, M> {
    points: Vec<Placed<'a, M>>,
    tiles: Option<Sampled>,
    no_tiles: Option<&'a str>,
    without_slot: u64,
    knee: Option<&'a str>,
    no_knee: Option<&'a str>,
    command: Option<String>,
}

/// A model, and where it stands.
#[derive(Serialize)]
#[serde(bound = "")]
struct Placed<'a, M> {
    #[serde(flatten)]
    point: &'a Point<M>,
    error: Option<f64>,
    no_limit: Option<NoLimit>,
    seconds: Option<f64>,
    seconds_range: Option<[f64; 2]>,
    planning_seconds: f64,
    command: String,
}

/// Every arithmetic, error and schedule by itself.
fn programmed(
    chips: Chips<'_>,
    survey: Survey<'_>,
    formats: &[Format],
    (verify, runs): (bool, u32),
) -> Result<Trade<Setup>, PlanError> {
    let family = Programs {
        chips,
        schedule: Schedule::for_size(survey.kept.size()),
    };
    let ask = Ask {
        survey,
        models: family.models(formats),
        alternative: &|setup: &Setup| family.alternative(setup),
        free: &|setup: &Setup, _: &Look| family.free(setup),
        verify,
        runs,
        begin: &|_| (),
    };
    survey_all(&family, &ask)
}

/// Every effect left out by itself, and other number formats.
fn traded(
    description: &Description,
    survey: Survey<'_>,
    formats: &[Format],
    (verify, runs): (bool, u32),
) -> Result<Trade<Choice>, PlanError> {
    let full = Choice::full();
    let family = Floats {
        description,
        seed: survey.seed,
        base: &full,
    };
    let ask = Ask {
        survey,
        models: family.models(formats, survey.upsample.is_some()),
        alternative: &|choice: &Choice| family.alternative(choice),
        free: &|choice: &Choice, look: &Look| family.free(choice, look),
        verify,
        runs,
        begin: &|_| (),
    };
    survey_all(&family, &ask)
}
