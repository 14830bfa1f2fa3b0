//! Whether kernels can run on a chip.

use amacrine::{
    study::{
        feasibility::{self as feasible, readout::ReadoutOrder},
        report,
    },
    unit::Micros,
};
use miette::{Report, miette};
use pyo3::prelude::*;

use super::{Named, Search, Shown, device, kernel, quantisers, scan, within};
use crate::{
    chip::{effort, memory_named, quantiser, sum},
    error::{raised, refused},
};

/// Whether kernels can run on a chip: the answer as JSON, and as a page.
#[pyfunction]
pub fn feasibility(
    py: Python<'_>,
    of: Vec<Named>,
    thresholds: Vec<f64>,
    levels: (Option<&str>, Vec<String>, Option<&str>),
    search: Search<'_>,
    scene: Shown<'_>,
    times: (Option<u64>, Option<u64>),
    link: ([f64; 2], bool),
    chips: u64,
) -> PyResult<(String, String)> {
    let (to, candidates, memory) = levels;
    let memory = memory.map(memory_named).transpose()?;
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
    let (sum, device, effort) = (sum(sum_to)?, device(chip)?, effort(seconds)?);
    if !(1..=1024).contains(&chips) {
        return Err(refused(format!("{chips} chips"), "give 1 to 1024"));
    }
    let source = scene.source()?;
    let answer = source.work(py, || {
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
