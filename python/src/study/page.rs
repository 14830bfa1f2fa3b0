//! Whether kernels can run on a chip.

use amacrine::{
    photoreceptor::Response,
    rig::guard::Warning,
    study::{
        WithLight, defaults,
        feasibility::{self as feasible, AtRate, readout::ReadoutOrder},
        report,
    },
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;

use super::{Named, Search, Shown, device, quantisers, scan, sighted, within};
use crate::{
    chip::{effort, named, quantiser},
    error::refused,
    files::json,
};

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
    let kernels = of.iter().map(sighted).collect::<PyResult<Vec<_>>>()?;
    let to = to.map(quantiser).transpose()?;
    let candidates = if candidates.is_empty() {
        defaults::CANDIDATES.split(',').map(quantiser).collect()
    } else {
        quantisers(candidates)
    }?;
    let (sum, device) = (named(sum_to)?, device(chip)?);
    if !(1..=1024).contains(&chips) {
        return Err(refused(format!("{chips} chips"), "give 1 to 1024"));
    }
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let (answer, page) = source.answer(py, Response::IDENTITY, || {
        let fps = source.open()?.fps();
        let (rate, thresholds) = aim;
        let found = if let Some(rate) = rate {
            let kernels = { of.iter() }.map(|named| named.0.as_str()).zip(&kernels);
            feasible::at_rate(kernels, (rate, seed), &device, &|| source.open())?
        } else {
            AtRate {
                thresholds,
                ..AtRate::default()
            }
        };
        let questions: Vec<_> = { of.iter().zip(&kernels).zip(&found.thresholds) }
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
        let mut reply = feasible::ask(&questions, &|| source.open(), |_| ())?;
        let observation = source.observation();
        let mut warnings = Warning::of_scene(observation, Response::IDENTITY);
        warnings.extend(found.missed);
        reply.saw(&warnings, observation.words().as_deref());
        let told = json(&WithLight::new(&reply, observation));
        Ok((told, report::page(&reply)))
    })?;
    Ok((answer?, page))
}
