//! Where events go on the way to the chip.

use amacrine::{
    array::{Arithmetic, ArithmeticError},
    compile::DriveMemory,
    isa::Figure,
    kernel::Kernel,
    photoreceptor::Response,
    picture::svg,
    study::{
        design::Design,
        together,
        waterfall::{self as falls, Fall},
    },
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;
use serde::Serialize;

use super::{Named, Search, Shown, device, kernel, open_on, scan, within};
use crate::{
    chip::{effort, named, quantiser},
    error::{raised, refused},
    files::json,
    options, readout,
};

/// Both answers as one object.
#[derive(Serialize)]
struct Fallen<'a> {
    /// Where there are several kernels.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    /// What the program of several remembers.
    #[serde(skip_serializing_if = "Option::is_none")]
    memory: Option<String>,
    #[serde(flatten)]
    steps: &'a falls::Waterfall,
    #[serde(flatten)]
    rates: Option<&'a falls::Rates>,
}

/// Where the events of float sensors go on the way to the chip, those of several kernels in one
/// program: of each as JSON, and drawn.
#[pyfunction]
pub fn waterfall(
    py: Python<'_>,
    of: Vec<Named>,
    thresholds: Vec<f64>,
    how: (&str, &str, Option<&str>),
    search: Search<'_>,
    scene: Shown<'_>,
    within_us: Option<u64>,
    rates: Option<Vec<f64>>,
    sample: (u64, Option<usize>),
    sets: Vec<(String, f64)>,
    through: Option<readout::Asked>,
) -> PyResult<Vec<(String, String)>> {
    let ((to, domain, memory), (chips, tiles)) = (how, sample);
    let memory: Option<DriveMemory> = memory.map(named).transpose()?;
    let (sum_to, chip, seconds, seed) = search;
    let kernels: Vec<Kernel> = of.iter().map(kernel).collect::<PyResult<_>>()?;
    let to = quantiser(to)?;
    let (sum, mut device) = (named(sum_to)?, device(chip)?);
    let arithmetic: Arithmetic = domain.parse().map_err(|e: ArithmeticError| raised(e))?;
    let mut note = None;
    for (name, value) in sets {
        let figure = Figure::find(&name).map_err(raised)?;
        device = device.what_if(figure, value).map_err(raised)?;
        note = note.or_else(|| arithmetic.unused(figure, "--domain"));
    }
    if let Some(note) = note {
        options::note(py, &note)?;
    }
    let readout = through.map_or_else(|| scan().map_err(raised), readout::open)?;
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let designs = Design::each(&kernels, &thresholds, &device, (effort, seed));
    let [first, ..] = designs[..] else {
        return Err(refused("no kernel", "give one, or several"));
    };
    let answer = source.study(py, Response::IDENTITY, || {
        let mut shown = open_on(&source, &device)?;
        let choice = rates.map(|rates| falls::Choice {
            rates,
            chips,
            tiles,
            within: within_us.map(Micros),
        });
        if let (Some(choice), Some(frames)) = (&choice, shown.frames()) {
            choice.check(frames, shown.fps())?;
        }
        let question = falls::Question {
            design: first,
            to,
            sum,
            arithmetic: arithmetic.with_seed(seed),
            readout,
            within: within(within_us, shown.fps()),
        };
        falls::check_crossings(&designs, &mut *source.open()?)?;
        let falls = Fall::all(&designs, question, memory)?;
        let steps = falls::steps_together(&falls, &mut *shown, |_| ())?;
        let mut rates = Vec::new();
        if let Some(choice) = choice {
            for fall in &falls {
                rates.push(fall.rates(&choice, &|| source.open(), &|| ())?);
            }
        }
        let memory = falls.first().and_then(Fall::remembered);
        Ok((steps, rates, memory))
    })?;
    let (steps, rates, memory) = answer.map_err(|report: Report| raised(report))?;
    let title = |kind: usize| {
        let one = if of.len() > 1 {
            ", of one program,"
        } else {
            ""
        };
        format!(
            "Where the events of {}{one} went: {chip}, threshold {}, {}",
            of[kind].0,
            thresholds[kind],
            source.name()
        )
    };
    let told = |(kind, steps): (usize, &falls::Waterfall)| {
        let rates = rates.get(kind);
        let fallen = Fallen {
            name: (of.len() > 1).then(|| of[kind].0.as_str()),
            memory: memory.map(together::name),
            steps,
            rates,
        };
        let drawing = match rates {
            Some(rates) => rates.drawing(&title(kind)),
            None => steps.drawing(&title(kind)),
        };
        Ok((json(&fallen)?, svg(&drawing)))
    };
    steps.iter().enumerate().map(told).collect()
}
