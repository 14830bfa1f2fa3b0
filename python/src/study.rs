//! Studies: what a kernel loses on a chip. Answers are the library's own, as JSON.

use std::time::Instant;

use amacrine::{
    array::{Arithmetic, ArithmeticError},
    compare::window,
    compile::SLOTS,
    event::readout::{
        Readout,
        settings::{Description as ReadoutDescription, ReadoutError},
    },
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Change, Quantiser},
    },
    number::{Format, FormatError},
    picture::svg,
    plane::Plane,
    reference::Description,
    scene::kept::Kept,
    study::{
        design::Design,
        feasibility::{self as feasible, readout::ReadoutOrder},
        pilot::{Choice, Effect, Floats, Survey, plan::KEPT, rule},
        quantisation, report,
        trade::{Ask, Trade, trade as survey_all},
        waterfall::{self as falls, Fall},
    },
    unit::Micros,
};
use miette::{Report, miette};
use pyo3::prelude::*;
use serde::Serialize;

use crate::{
    chip::{effort, quantiser, sum},
    error::{raised, refused},
    files::json,
    pool,
    sensor::Sensor,
    source::Source,
};

/// A kernel by name, or the bytes of its file.
type Named = (String, Option<Vec<u8>>);

fn kernel((name, bytes): &Named) -> PyResult<Kernel> {
    let kernel = match bytes {
        Some(bytes) => Kernel::from_bytes(name, bytes).map_err(|error| {
            use amacrine::kernel::KernelFileError::Wrong;
            match error {
                Wrong(faults) => raised(faults),
                other => refused(
                    format!("{name}: {other}"),
                    "give an array of shape (k,k) or (K,k,k), k odd, of floats or integers",
                ),
            }
        })?,
        None => Kernel::builtin(name).ok_or_else(|| {
            let known: Vec<_> = Kernel::builtin_names().collect();
            refused(
                format!("cannot read the kernel {name}: no such file"),
                format!(
                    "give a kernel file (.toml, .npy) or one of {}",
                    known.join(", ")
                ),
            )
        })?,
    };
    kernel.workable().map_err(|error| {
        refused(
            format!("{name}: {error}"),
            "multiply the kernel by a number, and the threshold with it",
        )
    })?;
    Ok(kernel)
}

fn quantisers(names: Vec<String>) -> PyResult<Vec<Quantiser>> {
    names.iter().map(|name| quantiser(name)).collect()
}

fn device(name: &str) -> PyResult<Device> {
    Device::find(name).map_err(raised)
}

fn rows(weights: &Plane<f64>) -> Vec<Vec<f64>> {
    weights.rows().into_iter().map(|row| row.to_vec()).collect()
}

/// The scan that a compiled program asks for.
fn scan() -> Result<Readout, ReadoutError> {
    let mut scan = ReadoutDescription::shipped("scan")?;
    scan.set("slots", &SLOTS.to_string())?;
    scan.readout()
}

/// A kernel in few values.
#[derive(Serialize)]
struct Few {
    to: String,
    levels: Vec<Vec<f64>>,
    scale: f64,
    relative_error: f64,
    sum: f64,
    taps: usize,
    response: Change,
    erased: Vec<String>,
}

/// A kernel in few values, each quantiser with what is lost.
#[pyfunction]
pub fn quantise(of: Named, to: Vec<String>, sum_to: &str, seed: u64) -> PyResult<String> {
    let kernel = kernel(&of)?;
    let sum = sum(sum_to)?;
    let mut all = Vec::new();
    for to in quantisers(to)? {
        let quantised = to.quantise(&kernel, sum, seed).map_err(|error| {
            let what = format!("{} cannot be {to}", of.0);
            raised(Report::new(error).wrap_err(what))
        })?;
        let levels = quantised.levels.weights();
        all.push(Few {
            to: to.to_string(),
            levels: rows(levels),
            scale: quantised.scale,
            relative_error: quantised.relative_error(&kernel),
            sum: quantised.kernel().sum(),
            taps: levels.iter().filter(|level| **level != 0.0).count(),
            response: Change::between(&kernel, &quantised.kernel()),
            erased: { quantised.erasures(&kernel).into_iter() }
                .map(|erasure| erasure.to_string())
                .collect(),
        });
    }
    json(&all)
}

/// How long to search, on which chip, with which seed.
type Search<'a> = (&'a str, &'a str, f64, u64);

/// Each quantiser compiled and run beside the float kernel.
#[pyfunction]
pub fn on_chip(
    py: Python<'_>,
    of: Named,
    to: Vec<String>,
    threshold: f64,
    search: Search<'_>,
    scene: Shown<'_>,
    within_us: Option<u64>,
) -> PyResult<String> {
    let (sum_to, chip, seconds, seed) = search;
    let (kernel, quantisers) = (kernel(&of)?, quantisers(to)?);
    let (sum, device, effort) = (sum(sum_to)?, device(chip)?, effort(seconds)?);
    check(threshold)?;
    let source = scene.source()?;
    let answer = pool::work(py, || {
        let fps = source.open()?.fps();
        let question = quantisation::Question {
            kernel: &kernel,
            threshold,
            quantisers: &quantisers,
            sum,
            device: &device,
            effort,
            seed,
            within: within(within_us, fps),
        };
        quantisation::ask(&question, &|| source.open(), |_| ()).map_err(Report::new)
    })?;
    json(&answer.map_err(|report: Report| raised(report))?)
}

fn check(threshold: f64) -> PyResult<()> {
    if threshold > 0.0 && threshold.is_finite() {
        return Ok(());
    }
    Err(refused(
        format!("the threshold is {threshold}"),
        "give a positive number, in units of kernel times light (0 to 255)",
    ))
}

fn within(asked: Option<u64>, fps: f64) -> Micros {
    asked.map_or_else(|| window::headline(fps), Micros)
}

/// What is shown: a name, or frames; frames a second, and the scale.
#[derive(FromPyObject)]
pub struct Shown<'py>(
    Option<String>,
    Option<Bound<'py, PyAny>>,
    Option<f64>,
    Option<f64>,
);

impl Shown<'_> {
    fn source(&self) -> PyResult<Source> {
        Source::new(self.0.clone(), self.1.as_ref(), self.2, self.3)
    }
}

/// Whether kernels can run on a chip: the answer as JSON, and as a page.
#[pyfunction]
pub fn feasibility(
    py: Python<'_>,
    of: Vec<Named>,
    thresholds: Vec<f64>,
    levels: (Option<&str>, Vec<String>),
    search: Search<'_>,
    scene: Shown<'_>,
    times: (Option<u64>, Option<u64>),
    link: ([f64; 2], bool),
    chips: u64,
) -> PyResult<(String, String)> {
    let (to, candidates) = levels;
    let (sum_to, chip, seconds, seed) = search;
    let (within_us, exposure_us) = times;
    let (link, overlapped) = link;
    let kernels = of.iter().map(kernel).collect::<PyResult<Vec<_>>>()?;
    let to = to.map(quantiser).transpose()?;
    let candidates = match candidates.is_empty() {
        true => feasible::CANDIDATES.split(',').map(quantiser).collect(),
        false => quantisers(candidates),
    }?;
    let (sum, device, effort) = (sum(sum_to)?, device(chip)?, effort(seconds)?);
    if !(1..=1024).contains(&chips) {
        return Err(refused(format!("{chips} chips"), "give 1 to 1024"));
    }
    let source = scene.source()?;
    let answer = pool::work(py, || {
        let fps = source.open()?.fps();
        let questions: Vec<_> = { of.iter().zip(&kernels).zip(&thresholds) }
            .map(|((named, kernel), threshold)| {
                Ok(feasible::Question {
                    name: &named.0,
                    kernel,
                    threshold: *threshold,
                    to,
                    candidates: &candidates,
                    sum,
                    device: &device,
                    exposure: exposure_us.map(Micros),
                    order: if overlapped {
                        ReadoutOrder::Overlapped
                    } else {
                        ReadoutOrder::Sequential
                    },
                    link,
                    effort,
                    seed,
                    readout: scan()?,
                    within: within(within_us, fps),
                    chips,
                    scene: source.name(),
                    command: "amacrine.feasibility, in Python",
                })
            })
            .collect::<Result<_, Report>>()?;
        let open = || source.open();
        if let [question] = &questions[..] {
            let (answer, snapshot) = feasible::ask(question, &open, |_| ())?;
            return Ok((
                serde_json::to_string(&answer),
                report::page(&answer, &snapshot),
            ));
        }
        let several = feasible::ask_several(&questions, &open, |_| ())?;
        let (several, snapshots) =
            several.ok_or_else(|| miette!("there is no kernel to ask about"))?;
        Ok((
            serde_json::to_string(&several),
            report::page_of_several(&several, &snapshots),
        ))
    })?;
    let (answer, page) = answer.map_err(|report: Report| raised(report))?;
    let answer = answer.map_err(|cause| refused(cause, "report this"))?;
    Ok((answer, page))
}

/// Both answers as one object.
#[derive(Serialize)]
struct Fallen<'a> {
    #[serde(flatten)]
    steps: &'a falls::Waterfall,
    #[serde(flatten)]
    rates: Option<&'a falls::Rates>,
}

/// Where the events of the float sensor go on the way to the chip: as JSON, and drawn.
#[pyfunction]
pub fn waterfall(
    py: Python<'_>,
    of: Named,
    threshold: f64,
    how: (&str, &str),
    search: Search<'_>,
    scene: Shown<'_>,
    within_us: Option<u64>,
    rates: Option<Vec<f64>>,
    sample: (u64, Option<usize>),
) -> PyResult<(String, String)> {
    let ((to, domain), (chips, tiles)) = (how, sample);
    let (sum_to, chip, seconds, seed) = search;
    let (kernel, to) = (kernel(&of)?, quantiser(to)?);
    let (sum, device, effort) = (sum(sum_to)?, device(chip)?, effort(seconds)?);
    let arithmetic: Arithmetic = domain.parse().map_err(|e: ArithmeticError| raised(e))?;
    let source = scene.source()?;
    let title = format!(
        "Where the events of {} went: {chip}, threshold {threshold}, {}",
        of.0,
        source.name()
    );
    let answer = pool::work(py, || {
        let mut shown = source.open()?;
        let fall = Fall::new(falls::Question {
            design: Design {
                kernel: &kernel,
                threshold,
                device: &device,
                effort,
                seed,
            },
            to,
            sum,
            arithmetic: arithmetic.with_seed(seed),
            readout: scan()?,
            within: within(within_us, shown.fps()),
        })?;
        let steps = fall.steps(&mut *shown, |_| ())?;
        let Some(rates) = rates else {
            let drawing = svg(&steps.drawing(&title));
            return Ok((steps, None, drawing));
        };
        let choice = falls::Choice {
            rates,
            chips,
            tiles,
            within: within_us.map(Micros),
        };
        let rates = fall.rates(&choice, &|| source.open(), &|| ())?;
        let drawing = svg(&rates.drawing(&title));
        Ok((steps, Some(rates), drawing))
    })?;
    let (steps, rates, drawing) = answer.map_err(|report: Report| raised(report))?;
    let fallen = Fallen {
        steps: &steps,
        rates: rates.as_ref(),
    };
    Ok((json(&fallen)?, drawing))
}

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
    tiles: Option<amacrine::study::pilot::Sampled>,
    no_tiles: Option<&'a str>,
    knee: Option<&'a str>,
}

/// A model, and where it stands.
#[derive(Serialize)]
struct Placed<'a> {
    #[serde(flatten)]
    point: &'a amacrine::study::trade::Point<Choice>,
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
) -> Result<Trade<Choice>, amacrine::study::pilot::PlanError> {
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
    let free = |choice: &Choice, look: &amacrine::study::pilot::Look| {
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
