//! Several kernels in one program, as `amacrine quantise` has it.

use amacrine::{
    isa::{Device, Figure},
    kernel::quantise::{Quantised, Quantiser, Sum, Summary},
    program::stored,
    rig::guard::{Guard, Warning},
    study::{
        design::{Design, DesignError},
        equivalent::Likeness,
        together::{self, Together},
    },
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;
use serde::Serialize;

use super::{Named, Search, Shown, check, device, kernel, quantisers, within};
use crate::{
    chip::{effort, sum},
    error::raised,
    files::json,
    pool,
    source::Source,
};

/// All kernels, and all of them in one program for each quantiser.
#[derive(Serialize)]
struct Answer {
    kernels: Vec<Kind>,
    together: Vec<Program>,
    warnings: Vec<Warning>,
}

/// One kernel in few values.
#[derive(Serialize)]
struct Kind {
    name: String,
    quantised: Vec<Row>,
}

/// A kernel in the values of one quantiser, or why it is not to be had in them.
#[derive(Serialize)]
struct Row {
    to: String,
    #[serde(flatten)]
    summary: Option<Summary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
}

/// All kernels in one program, for one quantiser.
#[derive(Serialize)]
struct Program {
    to: String,
    #[serde(flatten)]
    outcome: Outcome,
}

#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Outcome {
    OnChip(Box<OnChip>),
    Refused(Vec<String>),
}

/// What a program of all kernels costs and says.
#[derive(Serialize)]
struct OnChip {
    memory: String,
    against: &'static str,
    filter_words: u64,
    words: u64,
    stored_words: u64,
    store: u64,
    array_us: f64,
    frames_per_s: f64,
    frames_per_s_of_compute: f64,
    carried: usize,
    kinds: Vec<Judged>,
}

/// One kind of it.
#[derive(Serialize)]
struct Judged {
    name: String,
    exact: Likeness,
    silicon: Likeness,
}

/// What is asked of all kernels.
struct Question<'a> {
    names: Vec<&'a str>,
    floats: Vec<Design<'a>>,
    sum: Sum,
    source: &'a Source,
    within: Micros,
}

/// Several kernels in one program, each quantiser compiled and run beside the float sensor.
#[pyfunction]
pub fn on_chip_together(
    py: Python<'_>,
    of: Vec<Named>,
    to: Vec<String>,
    thresholds: Vec<f64>,
    search: Search<'_>,
    scene: Shown<'_>,
    within_us: Option<u64>,
) -> PyResult<String> {
    let (sum_to, chip, seconds, seed) = search;
    let kernels = of.iter().map(kernel).collect::<PyResult<Vec<_>>>()?;
    let to = quantisers(to)?;
    let (sum, device, effort) = (sum(sum_to)?, device(chip)?, effort(seconds)?);
    thresholds.iter().try_for_each(|it| check(*it))?;
    let source = scene.source()?;
    let answer = pool::work(py, || {
        let floats = kernels.iter().zip(&thresholds);
        let question = Question {
            names: of.iter().map(|(name, _)| name.as_str()).collect(),
            floats: floats
                .map(|(kernel, threshold)| Design {
                    kernel,
                    threshold: *threshold,
                    device: &device,
                    effort,
                    seed,
                })
                .collect(),
            sum,
            source: &source,
            within: within(within_us, source.open()?.fps()),
        };
        question.answer(&to, &device)
    })?;
    json(&answer.map_err(|report: Report| raised(report))?)
}

impl Question<'_> {
    fn answer(&self, to: &[Quantiser], device: &Device) -> Result<Answer, Report> {
        let mut guard = Guard::new();
        let each = self.names.iter().zip(&self.floats);
        let kernels = each.map(|(name, float)| Kind {
            name: (*name).to_owned(),
            quantised: { to.iter() }
                .map(|to| self.row(float, *to, &mut guard))
                .collect(),
        });
        let kernels = kernels.collect();
        let mut together = Vec::new();
        for to in to {
            let outcome = match self.few(*to)? {
                Err(why) => Outcome::Refused(vec![why]),
                Ok(few) => self.run(*to, &few, device, &mut guard)?,
            };
            together.push(Program {
                to: to.to_string(),
                outcome,
            });
        }
        Ok(Answer {
            kernels,
            together,
            warnings: guard.warnings(),
        })
    }

    /// One kernel in the values of one quantiser.
    fn row(&self, float: &Design<'_>, to: Quantiser, guard: &mut Guard) -> Row {
        let few = to.quantise(float.kernel, self.sum, float.seed);
        for erasure in few.iter().flat_map(|few| few.erasures(float.kernel)) {
            guard.warn(Warning::erased(&to.to_string(), erasure));
        }
        let summary = { few.as_ref() }.map(|few| Summary::new(float.kernel, few));
        Row {
            to: to.to_string(),
            refused: summary.as_ref().err().map(ToString::to_string),
            summary: summary.ok(),
        }
    }

    /// All kernels in these few values; or why one of them is not to be had in them.
    fn few(&self, to: Quantiser) -> Result<Result<Vec<Quantised>, String>, DesignError> {
        let mut all = Vec::new();
        for float in &self.floats {
            match float.quantise(to, self.sum) {
                Ok(few) => all.push(few),
                Err(error @ DesignError::Quantise(_)) => return Ok(Err(error.to_string())),
                Err(error) => return Err(error),
            }
        }
        Ok(Ok(all))
    }

    /// Compiles all kernels into one program, and runs it beside the float sensor.
    fn run(
        &self,
        to: Quantiser,
        few: &[Quantised],
        device: &Device,
        guard: &mut Guard,
    ) -> Result<Outcome, Report> {
        let levels: Vec<Design<'_>> = { self.floats.iter().zip(few) }
            .map(|(float, few)| float.in_levels(few))
            .collect();
        let program = match Together::compile(&levels, "together", None)? {
            Err(why) => return Ok(Outcome::Refused(why)),
            Ok(program) => program,
        };
        let mut scene = self.source.open()?;
        // The frames of this run alone.
        let mut own = Guard::new();
        let seed = self.floats.first().map_or(0, |float| float.seed);
        let how = (self.within, seed);
        let (judged, _) = program.judge(&self.floats, how, &mut *scene, |frame| {
            own.frame(frame);
        })?;
        for (name, kind) in self.names.iter().zip(&judged) {
            own.packet(&format!("{to} silicon, {name}"), &kind.packet);
            if let Some(warning) = kind.exact.warning(name) {
                own.warn(warning);
            }
        }
        own.warnings().into_iter().for_each(|it| guard.warn(it));
        let cost = program.compiled.cost;
        let code = &program.compiled.code;
        Ok(Outcome::OnChip(Box::new(OnChip {
            memory: together::name(program.memory),
            against: program.against(),
            filter_words: program.compiled.program.filter.words.len() as u64,
            words: cost.words.0,
            stored_words: (stored(&code.init, device) + stored(&code.frame, device)).0,
            store: device.value(Figure::Store) as u64,
            array_us: cost.array_us,
            frames_per_s: 1e6 / cost.micros(),
            frames_per_s_of_compute: 1e6 / cost.array_us,
            carried: program.carried(),
            kinds: { self.names.iter().zip(judged) }
                .map(|(name, kind)| Judged {
                    name: (*name).to_owned(),
                    exact: kind.exact,
                    silicon: kind.silicon,
                })
                .collect(),
        })))
    }
}
