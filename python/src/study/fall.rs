//! Where events go on the way to the chip.

use amacrine::{
    array::{Arithmetic, ArithmeticError},
    photoreceptor::Response,
    picture::svg,
    study::{
        design::Design,
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
    error::raised,
    files::json,
    readout,
};

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
    through: Option<readout::Asked>,
) -> PyResult<(String, String)> {
    let ((to, domain), (chips, tiles)) = (how, sample);
    let (sum_to, chip, seconds, seed) = search;
    let (kernel, to) = (kernel(&of)?, quantiser(to)?);
    let (sum, device) = (named(sum_to)?, device(chip)?);
    let arithmetic: Arithmetic = domain.parse().map_err(|e: ArithmeticError| raised(e))?;
    let readout = through.map_or_else(|| scan().map_err(raised), readout::open)?;
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let title = format!(
        "Where the events of {} went: {chip}, threshold {threshold}, {}",
        of.0,
        source.name()
    );
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
            readout,
            within: within(within_us, shown.fps()),
        })?;
        let steps = fall.steps(&mut *shown, |_| ())?;
        let Some(choice) = choice else {
            let drawing = svg(&steps.drawing(&title));
            return Ok((steps, None, drawing));
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
