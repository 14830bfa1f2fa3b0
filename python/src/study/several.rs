//! Several kernels in one program, as `amacrine quantise` has it.

use amacrine::{
    compile::DriveMemory,
    kernel::quantise::{Quantiser, Sum},
    photoreceptor::Response,
    rig::guard::{Guard, Warning},
    study::{design::Design, joint::Joint},
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;
use serde::Serialize;

use super::{Named, Search, Shown, check, device, few::Row, kernel, open_on, quantisers, within};
use crate::{
    chip::{effort, named},
    error::raised,
    files::json,
    source::Source,
};

/// All kernels, and all of them in one program for each quantiser.
#[derive(Serialize)]
struct Answer {
    kernels: Vec<Kind>,
    together: Vec<Joint>,
    warnings: Vec<Warning>,
}

/// One kernel in few values.
#[derive(Serialize)]
struct Kind {
    name: String,
    kernel: Vec<Vec<f64>>,
    sum: f64,
    quantised: Vec<Row>,
}

/// What is asked of all kernels.
struct Question<'a> {
    names: Vec<String>,
    floats: Vec<Design<'a>>,
    sum: Sum,
    memory: Option<DriveMemory>,
    source: &'a Source,
    within: Micros,
}

/// Several kernels in one program, each quantiser compiled and run beside the float sensor; `how`: the
/// quantisers, and what the program remembers.
#[pyfunction]
pub fn on_chip_together(
    py: Python<'_>,
    of: Vec<Named>,
    how: (Vec<String>, Option<&str>),
    thresholds: Vec<f64>,
    search: Search<'_>,
    scene: Shown<'_>,
    within_us: Option<u64>,
) -> PyResult<String> {
    let (sum_to, chip, seconds, seed) = search;
    let kernels = of.iter().map(kernel).collect::<PyResult<Vec<_>>>()?;
    let (to, memory) = (quantisers(how.0)?, how.1.map(named).transpose()?);
    let (sum, device) = (named(sum_to)?, device(chip)?);
    thresholds.iter().try_for_each(|it| check(*it))?;
    let source = scene.source()?;
    let effort = effort(seconds, source.stop())?;
    let answer = source.study(py, Response::IDENTITY, || {
        let fps = open_on(&source, &device)?.fps();
        let question = Question {
            names: of.iter().map(|(name, _)| name.clone()).collect(),
            floats: Design::each(&kernels, &thresholds, &device, (effort, seed)),
            sum,
            memory,
            source: &source,
            within: within(within_us, fps),
        };
        question.answer(&to)
    })?;
    json(&answer.map_err(|report: Report| raised(report))?)
}

impl Question<'_> {
    fn answer(&self, to: &[Quantiser]) -> Result<Answer, Report> {
        let mut guard = Guard::new();
        let each = self.names.iter().zip(&self.floats);
        let kernels = each.map(|(name, float)| Kind {
            name: name.clone(),
            kernel: float.kernel.rows(),
            sum: float.kernel.sum(),
            quantised: { to.iter() }
                .map(|to| self.row(float, *to, &mut guard))
                .collect(),
        });
        let kernels = kernels.collect();
        let mut together = Vec::new();
        for to in to {
            let mut scene = self.source.open()?;
            together.push(Joint::new(
                &self.names,
                &self.floats,
                (*to, self.sum, self.memory),
                (self.within, &mut *scene),
                &mut guard,
                || (),
            )?);
        }
        Ok(Answer {
            kernels,
            together,
            warnings: guard.warnings(),
        })
    }

    /// One kernel in the values of one quantiser.
    fn row(&self, float: &Design<'_>, to: Quantiser, guard: &mut Guard) -> Row {
        let (row, erased) = Row::new(float.kernel, to, self.sum, float.seed);
        for erasure in erased {
            guard.warn(Warning::erased(&to.to_string(), erasure));
        }
        row
    }
}
