//! Whether kernels can run on a chip.

use amacrine::{
    compile::Effort,
    isa::Device,
    kernel::Kernel,
    photoreceptor::Response,
    reference::MemoryRule,
    study::{
        design::Design,
        feasibility::{self as feasible, readout::ReadoutOrder},
        rate, report,
    },
    unit::Micros,
};
use miette::{Report, miette};
use pyo3::prelude::*;

use super::{Named, Search, Shown, device, kernel, quantisers, scan, within};
use crate::{
    chip::{effort, named, quantiser},
    error::{raised, refused},
    source::Source,
};

/// The threshold at which the float sensor of a kernel has so many events per pixel and second, to
/// four digits.
fn rated(
    kernel: &Kernel,
    asked: f64,
    (device, effort, seed): (&Device, Effort, u64),
    source: &Source,
) -> Result<f64, Report> {
    let design = Design {
        kernel,
        threshold: rate::start(kernel),
        device,
        effort,
        seed,
    };
    let description = design.description(MemoryRule::FilteredSnap)?;
    let found = rate::factor(&description, asked, seed, &|| source.open())?;
    Ok(rate::four_digits(design.threshold * found.factor))
}

/// Whether kernels can run on a chip: the answer as JSON, and as a page.
#[pyfunction]
pub fn feasibility(
    py: Python<'_>,
    of: Vec<Named>,
    aim: (Option<f64>, Vec<f64>),
    levels: (Option<&str>, Vec<String>, Option<&str>),
    search: Search<'_>,
    scene: Shown<'_>,
    times: (Option<u64>, Option<u64>),
    link: ([f64; 2], bool),
    chips: u64,
) -> PyResult<(String, String)> {
    let (to, candidates, memory) = levels;
    let memory = memory.map(named).transpose()?;
    let (sum_to, chip, seconds, seed) = search;
    let (within_us, exposure_us) = times;
    let (link, overlapped) = link;
    let kernels = of.iter().map(kernel).collect::<PyResult<Vec<_>>>()?;
    let to = to.map(quantiser).transpose()?;
    let candidates = if candidates.is_empty() {
        feasible::CANDIDATES.split(',').map(quantiser).collect()
    } else {
        quantisers(candidates)
    }?;
    let (sum, device) = (named(sum_to)?, device(chip)?);
    if !(1..=1024).contains(&chips) {
        return Err(refused(format!("{chips} chips"), "give 1 to 1024"));
    }
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let answer = source.study(py, Response::IDENTITY, || {
        let fps = source.open()?.fps();
        let (rate, mut thresholds) = aim;
        if let Some(rate) = rate {
            let share = rate / kernels.len().max(1) as f64;
            let rated = |kernel| rated(kernel, share, (&device, effort, seed), &source);
            thresholds = kernels.iter().map(rated).collect::<Result<_, _>>()?;
        }
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
                    memory,
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
        if let Some(question) = feasible::alone(&questions) {
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
