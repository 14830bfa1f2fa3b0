//! Kernels in few values, alone and on a chip.

use amacrine::{
    compile::DriveMemory,
    kernel::{
        Kernel,
        quantise::{Quantised, Quantiser, Sum},
    },
    photoreceptor::Response,
    study::quantised::{self, Answer, Row, Watch},
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;
use serde::Serialize;

use super::{Named, Search, Shown, device, kernel, open_on, quantisers};
use crate::{
    chip::{effort, named},
    error::{raised, refused},
    files::json,
};

/// A kernel in few values.
#[derive(Clone, Serialize)]
struct Few {
    #[serde(flatten)]
    row: Row,
    erased: Vec<String>,
}

/// Each kernel in few values, each quantiser with what is lost.
#[pyfunction]
pub fn quantise(
    of: Vec<Named>,
    to: Vec<String>,
    sum_to: &str,
    seed: Option<u64>,
) -> PyResult<String> {
    let sum = named(sum_to)?;
    let to = quantisers(to)?;
    if seed.is_some() && !to.iter().any(Quantiser::is_random) {
        return Err(refused(
            "seed has no effect without stochastic rounding or thresholds: these levels are the same under every seed",
            "leave seed out, round by chance (to=\"q3.4:stochastic\"), or give thresholds, too",
        ));
    }
    let seed = seed.unwrap_or(0);
    let few = |named: &Named| {
        let kernel = kernel(named)?;
        let each = to
            .iter()
            .map(|to| few((&named.0, &kernel), (*to, sum, seed)));
        Ok(each.collect::<PyResult<Vec<_>>>()?.concat())
    };
    json(&of.iter().map(few).collect::<PyResult<Vec<_>>>()?)
}

/// A kernel in the values of one quantiser; an error where it is not to be had in them.
fn few(
    (name, kernel): (&String, &Kernel),
    (to, sum, seed): (Quantiser, Sum, u64),
) -> PyResult<Vec<Few>> {
    let asked = quantised::Asked {
        names: std::slice::from_ref(name),
        kernels: std::slice::from_ref(kernel),
        to: &[to],
        sum,
        seed,
    };
    let kinds = asked.kinds().map_err(raised)?;
    let rows = kinds
        .iter()
        .flat_map(|kind| kind.quantised.iter().zip(kind.good()));
    let few = |(row, few): (&Row, &Quantised)| Few {
        row: row.clone(),
        erased: { few.erasures(kernel).into_iter() }
            .map(|erasure| erasure.to_string())
            .collect(),
    };
    Ok(rows.map(few).collect())
}

/// What is asked of kernels on a chip.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    kernels: Vec<Named>,
    thresholds: Vec<f64>,
    to: Vec<String>,
    memory: Option<String>,
    within_us: Option<u64>,
}

/// Each quantiser compiled and run beside the float kernel; several kernels in one program.
#[pyfunction]
pub fn on_chip(
    py: Python<'_>,
    asked: Asked,
    search: Search<'_>,
    scene: Shown<'_>,
) -> PyResult<String> {
    let (sum_to, chip, seconds, seed) = search;
    let kernels: Vec<Kernel> = asked.kernels.iter().map(kernel).collect::<PyResult<_>>()?;
    let names: Vec<String> = { asked.kernels.iter() }
        .map(|(name, _)| name.clone())
        .collect();
    let memory: Option<DriveMemory> = asked.memory.as_deref().map(named).transpose()?;
    let (to, sum, device) = (quantisers(asked.to)?, named(sum_to)?, device(chip)?);
    let source = scene.source()?;
    let chip = quantised::OnChip {
        thresholds: &asked.thresholds,
        device: &device,
        effort: effort(seconds, source.stop())?,
        memory,
        within: asked.within_us.map(Micros),
    };
    let question = quantised::Asked {
        names: &names,
        kernels: &kernels,
        to: &to,
        sum,
        seed,
    };
    let answer: Answer = source.answer(py, Response::IDENTITY, || {
        open_on(&source, &device)?;
        let watch = Watch {
            open: &|| source.open(),
            observation: source.observation(),
            frame: &|| (),
        };
        quantised::answer(&question, Some(&chip), &watch).map_err(Report::new)
    })?;
    json(&answer)
}
