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
        waterfall::{self as falls, Watch, answer},
    },
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;

use super::{Named, Search, Shown, device, kernel, open_on, scan};
use crate::{
    chip::{effort, named, quantiser},
    error::{raised, refused},
    files::json,
    options, readout,
};

/// What is asked of kernels.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    kernels: Vec<Named>,
    thresholds: Vec<f64>,
    to: String,
    domain: String,
    memory: Option<String>,
    sets: Vec<(String, f64)>,
    readout: Option<readout::Asked>,
    within_us: Option<u64>,
    rates: Vec<f64>,
    chips: u64,
    tiles: Option<usize>,
    steps: bool,
}

/// Where the events of float sensors go on the way to the chip, those of several kernels in one
/// program: of each as JSON, and drawn.
#[pyfunction]
pub fn waterfall(
    py: Python<'_>,
    asked: Asked,
    search: Search<'_>,
    scene: Shown<'_>,
) -> PyResult<Vec<(String, String)>> {
    let memory: Option<DriveMemory> = asked.memory.as_deref().map(named).transpose()?;
    let (sum_to, chip, seconds, seed) = search;
    let kernels: Vec<Kernel> = asked.kernels.iter().map(kernel).collect::<PyResult<_>>()?;
    let names: Vec<String> = { asked.kernels.iter() }
        .map(|(name, _)| name.clone())
        .collect();
    let (to, sum, mut device) = (quantiser(&asked.to)?, named(sum_to)?, device(chip)?);
    let arithmetic: Arithmetic =
        { asked.domain.parse() }.map_err(|e: ArithmeticError| raised(e))?;
    let mut note = None;
    for (name, value) in asked.sets {
        let figure = Figure::find(&name).map_err(raised)?;
        device = device.what_if(figure, value).map_err(raised)?;
        note = note.or_else(|| arithmetic.unused(figure, "--domain"));
    }
    if let Some(note) = note {
        options::note(py, &note)?;
    }
    let readout = { asked.readout }.map_or_else(|| scan().map_err(raised), readout::open)?;
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let designs = Design::each(&kernels, &asked.thresholds, &device, (effort, seed));
    if designs.is_empty() {
        return Err(refused("no kernel", "give one, or several"));
    }
    let asked = falls::Asked {
        names: &names,
        designs: &designs,
        to,
        sum,
        arithmetic,
        readout,
        memory,
        choice: falls::Choice {
            rates: asked.rates,
            chips: asked.chips,
            tiles: asked.tiles,
            within: asked.within_us.map(Micros),
        },
        steps_alone: asked.steps,
    };
    let all = source.answer(py, Response::IDENTITY, || {
        open_on(&source, &device)?;
        let open = || source.open();
        let watch = Watch {
            open: &open,
            observation: source.observation(),
            frame: &|| (),
            chip: &|| (),
        };
        answer(&asked, &watch).map_err(Report::new)
    })?;
    let told = |(kind, answer): (usize, &falls::Answer)| {
        let drawing = answer.drawing(&asked.title(kind, source.name()));
        Ok((json(answer)?, svg(&drawing)))
    };
    all.iter().enumerate().map(told).collect()
}
