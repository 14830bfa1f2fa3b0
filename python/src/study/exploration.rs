//! From kernels and a scene to sensors to choose from.

use amacrine::{
    compile::DriveMemory,
    photoreceptor::Response,
    study::exploration::{Aim, Question, explore},
    unit::Micros,
};
use miette::{IntoDiagnostic, Report};
use pyo3::prelude::*;

use super::{Named, Search, Shown, device, open_on, quantisers, sighted};
use crate::chip::{effort, named};

/// Sensors, each compiled and run: as JSON, with the texts of their files.
#[pyfunction]
pub fn design(
    py: Python<'_>,
    of: Vec<Named>,
    rate: Option<f64>,
    thresholds: Vec<f64>,
    how: (Vec<String>, Option<&str>),
    search: Search<'_>,
    scene: Shown<'_>,
    within_us: Option<u64>,
) -> PyResult<String> {
    let (sum_to, chip, seconds, seed) = search;
    let kernels = of.iter().map(sighted).collect::<PyResult<Vec<_>>>()?;
    let names: Vec<String> = of.iter().map(|(name, _)| name.clone()).collect();
    let quantisers = quantisers(how.0)?;
    let memory: Option<DriveMemory> = how.1.map(named).transpose()?;
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let (sum, device) = (named(sum_to)?, device(chip)?);
    source.answer(py, Response::IDENTITY, || {
        open_on(&source, &device)?;
        let question = Question {
            title: "design",
            names: &names,
            kernels: &kernels,
            aim: rate.map_or(Aim::Thresholds(&thresholds), Aim::Rate),
            quantisers: &quantisers,
            memory,
            sum,
            device: &device,
            effort,
            seed,
            within: within_us.map(Micros),
        };
        let found = explore(&question, &|| source.open(), &|_, _| (), |_| ())?;
        let picked = found.knee.unwrap_or(0);
        let answer = found.answer(&question, picked, source.name(), source.observation())?;
        let mut json = serde_json::to_value(&answer).into_diagnostic()?;
        for (i, candidate) in found.candidates.iter().enumerate() {
            json["candidates"][i]["sensor"] = candidate.sensor.to_toml().into();
            json["candidates"][i]["program"] = candidate.program.clone().into();
        }
        Ok::<_, Report>(json.to_string())
    })
}
