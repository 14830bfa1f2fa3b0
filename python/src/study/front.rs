//! What plainer models of a sensor or a program change, and what they save.

use std::time::Instant;

use amacrine::{
    array::{Arithmetic, ArithmeticError},
    number::{Format, FormatError},
    photoreceptor::Response,
    picture::svg,
    reference::Effect,
    study::{
        pilot::{Choice, plan::KEPT},
        trade::{
            Setup,
            answer::{self, Answer, Held, Watch, of_program, of_sensor},
        },
    },
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;

use super::{Shown, open_on};
use crate::{
    error::{raised, refused},
    files::json,
    options::in_python,
    program::Program,
    sensor::Sensor,
    source::Source,
};

/// What is asked of a sensor or a program.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    upsample: Option<f64>,
    formats: Option<Vec<String>>,
    within_us: u64,
    sample: f64,
    runs: u32,
    verify: bool,
    seed: u64,
    /// What the caller writes for what was asked about.
    called: String,
    /// `, scale=…` where the frames were given one.
    scale: String,
}

/// Error against seconds, for every plainer model of a sensor in a scene: as JSON, and drawn.
#[pyfunction]
pub fn trade(
    py: Python<'_>,
    sensor: &Bound<'_, Sensor>,
    scene: Shown<'_>,
    asked: Asked,
) -> PyResult<(String, String)> {
    let description = &sensor.get().description;
    let formats = asked.formats()?;
    let in_words = asked.question(&description.name, formats.as_deref())?;
    let source = scene.source()?;
    let told = source.study(py, description.response, || {
        let start = Instant::now();
        let clock = || start.elapsed().as_secs_f64();
        let held = held(&source, &mut *source.open()?, &clock)?;
        let watch = watch(&source, &clock);
        let command = |choice: &Choice| asked.of_sensor(choice);
        let answer = of_sensor(description, &in_words, &held, &watch, &command)?;
        Ok(told(&answer))
    })?;
    told.map_err(|report: Report| raised(report))?
}

/// The same of a program, whose full model is in a domain.
#[pyfunction]
pub fn trade_program(
    py: Python<'_>,
    program: &Bound<'_, Program>,
    domain: &str,
    scene: Shown<'_>,
    asked: Asked,
) -> PyResult<(String, String)> {
    let program = program.get();
    program.check_steady()?;
    let arithmetic: Arithmetic = domain.parse().map_err(|e: ArithmeticError| raised(e))?;
    let formats = asked.formats()?;
    let in_words = asked.question(program.file(), formats.as_deref())?;
    let source = scene.source()?;
    let told = source.study(py, Response::IDENTITY, || {
        let start = Instant::now();
        let clock = || start.elapsed().as_secs_f64();
        let mut scene = open_on(&source, program.device())?;
        let held = held(&source, &mut *scene, &clock)?;
        let watch = watch(&source, &clock);
        let command = |setup: &Setup| asked.of_program(setup);
        let chips = program.chips(program.settings(), arithmetic);
        let answer = of_program(chips, &in_words, &held, &watch, &command)?;
        Ok(told(&answer))
    })?;
    told.map_err(|report: Report| raised(report))?
}

/// Keeps a scene.
fn held(
    source: &Source,
    scene: &mut dyn amacrine::scene::Scene,
    clock: &dyn Fn() -> f64,
) -> Result<Held, Report> {
    let held = Held::new(source.name(), scene, KEPT, source.observation(), clock);
    Ok(held?)
}

/// Nobody looks on but who wants to stop.
fn watch<'a>(source: &Source, clock: &'a (dyn Fn() -> f64 + Sync)) -> Watch<'a> {
    Watch {
        clock,
        begin: &|_| (),
        stop: source.stop(),
    }
}

/// An answer as JSON, and as a drawing.
fn told<M>(answer: &Answer<'_, M>) -> PyResult<(String, String)> {
    Ok((json(answer)?, in_python(&svg(&answer.drawing()))))
}

impl Asked {
    fn formats(&self) -> PyResult<Option<Vec<Format>>> {
        let named = |name: &String| name.parse().map_err(|e: FormatError| raised(e));
        let formats = { self.formats.as_ref() }.map(|all| all.iter().map(named).collect());
        formats.transpose()
    }

    fn question<'a>(
        &self,
        of: &'a str,
        formats: Option<&'a [Format]>,
    ) -> PyResult<answer::Asked<'a>> {
        let (sample, runs) = (self.sample, self.runs);
        if !(sample > 0.0 && sample <= 1.0) || runs == 0 {
            return Err(refused(
                format!("a sample of {sample}, {runs} runs"),
                "give a part above 0 and up to 1, and at least one run",
            ));
        }
        Ok(answer::Asked {
            of,
            upsample: self.upsample,
            formats,
            within: Micros(self.within_us),
            sample,
            runs,
            verify: self.verify,
            seed: self.seed,
        })
    }

    /// What makes the events of a model of a sensor.
    fn of_sensor(&self, choice: &Choice) -> String {
        let mut text = format!("{}.in_format(\"{}\")", self.called, choice.format);
        let without = choice.without.iter().map(|effect| effect.word());
        let without: Vec<_> = { without }
            .filter(|key| *key != Effect::InsertedFrames.word())
            .map(|key| format!("\"{key}\""))
            .collect();
        if !without.is_empty() {
            text = text + ".without(" + &without.join(", ") + ")";
        }
        let upsample = { self.upsample }.filter(|_| !choice.leaves_out(Effect::InsertedFrames));
        let upsample = upsample.map_or(String::new(), |contrast| format!(", upsample={contrast}"));
        text + &format!(".events(frames, fps{}{upsample})", self.scale)
    }

    /// What runs a model of a program.
    fn of_program(&self, setup: &Setup) -> String {
        let domain = match setup.machine.format {
            Some(format) => Arithmetic::Number(format),
            None => Arithmetic::Silicon { seed: 0 },
        };
        let without: Vec<_> = { setup.without().iter() }
            .map(|term| format!("\"{}\"", term.word()))
            .collect();
        let without = match without.len() {
            0 => String::new(),
            _ => format!(", without=[{}]", without.join(", ")),
        };
        let seed = match self.seed {
            0 => String::new(),
            seed => format!(", seed={seed}"),
        };
        let order = if setup.ordered {
            format!("  # {}: the command line has schedules", setup.schedule)
        } else {
            String::new()
        };
        let (program, scale) = (&self.called, &self.scale);
        format!("{program}.run(frames, fps{scale}, domain=\"{domain}\"{without}{seed}){order}")
    }
}
