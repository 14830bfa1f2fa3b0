//! Kernels in few values, alone and on a chip.

use amacrine::{
    kernel::{
        Kernel,
        quantise::{Erasure, Quantiser, Sum, Summary},
    },
    photoreceptor::Response,
    rig::guard::Warning,
    study::{design::Design, quantisation},
};
use miette::Report;
use pyo3::prelude::*;
use serde::Serialize;

use super::{Named, Search, Shown, check, device, kernel, open_on, quantisers, within};
use crate::{
    chip::{effort, named},
    error::{raised, refused},
    files::json,
};

/// A kernel in few values.
#[derive(Serialize)]
struct Few {
    to: String,
    #[serde(flatten)]
    summary: Summary,
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
    let each = of.iter().map(|named| few(named, &to, sum, seed));
    json(&each.collect::<PyResult<Vec<_>>>()?)
}

/// A kernel in the values of each quantiser.
fn few(named: &Named, to: &[Quantiser], sum: Sum, seed: u64) -> PyResult<Vec<Few>> {
    let kernel = kernel(named)?;
    let mut all = Vec::new();
    for to in to {
        let quantised = to.quantise(&kernel, sum, seed).map_err(|error| {
            let what = format!("{} cannot be {to}", named.0);
            raised(Report::new(error).wrap_err(what))
        })?;
        all.push(Few {
            to: to.to_string(),
            summary: Summary::new(&kernel, &quantised),
            erased: { quantised.erasures(&kernel).into_iter() }
                .map(|erasure| erasure.to_string())
                .collect(),
        });
    }
    Ok(all)
}

/// A kernel in the values of one quantiser, or why it is not to be had in them.
#[derive(Serialize)]
pub struct Row {
    to: String,
    #[serde(flatten)]
    summary: Option<Summary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
}

impl Row {
    /// The row, and what few values have erased.
    pub fn new(kernel: &Kernel, to: Quantiser, sum: Sum, seed: u64) -> (Self, Vec<Erasure>) {
        let few = to.quantise(kernel, sum, seed);
        let erased = few.iter().flat_map(|few| few.erasures(kernel)).collect();
        let summary = few.as_ref().map(|few| Summary::new(kernel, few));
        let row = Self {
            to: to.to_string(),
            refused: summary.as_ref().err().map(ToString::to_string),
            summary: summary.ok(),
        };
        (row, erased)
    }
}

/// A kernel, each quantiser of it, and each on the chip.
#[derive(Serialize)]
struct OnChip {
    kernel: Vec<Vec<f64>>,
    sum: f64,
    quantised: Vec<Row>,
    chip: quantisation::Answer,
    warnings: Vec<Warning>,
}

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
    let (sum, device) = (named(sum_to)?, device(chip)?);
    check(threshold)?;
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let answer = source.study(py, Response::IDENTITY, || {
        let fps = open_on(&source, &device)?.fps();
        let question = quantisation::Question {
            design: Design {
                kernel: &kernel,
                threshold,
                device: &device,
                effort,
                seed,
            },
            quantisers: &quantisers,
            sum,
            within: within(within_us, fps),
        };
        quantisation::ask(&question, &|| source.open(), |_| ()).map_err(Report::new)
    })?;
    let answer = answer.map_err(|report: Report| raised(report))?;
    json(&OnChip {
        kernel: kernel.rows(),
        sum: kernel.sum(),
        quantised: { quantisers.iter() }
            .map(|to| Row::new(&kernel, *to, sum, seed).0)
            .collect(),
        warnings: answer.warnings.clone(),
        chip: answer,
    })
}
