//! What a kernel in few values loses on the chip, and what it costs there: the float kernel in
//! the reference against each quantised one as a compiled program, on one scene.
//!
//! Every row is the same sensor (memory `filtered-snap`, one decision a frame, zeros beyond the
//! border) but for its kernel. In `exact` arithmetic the row shows what few values do; in
//! `silicon` what the chip does besides.

use crate::{
    array::{Arithmetic, Array, Settings},
    compare::{self, Comparison},
    compile::{CompileError, Effort, Kind, Memory, Request, SensorProgram},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{QuantiseError, Quantiser, Sum},
    },
    number::Format,
    plane::Size,
    program::{Cost, Overrides, Program},
    reference::{Description, Reference},
    rig::{self, RigError},
    scene::{Frame, Scene},
    sensor::Sensor,
    unit::Micros,
};

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The float kernel.
    pub kernel: &'a Kernel,
    /// Events where kernel times light (0 to 255) moved by more than this.
    pub threshold: f64,
    /// One row each.
    pub quantisers: &'a [Quantiser],
    /// What quantised kernels must sum to.
    pub sum: Sum,
    /// The chip.
    pub device: &'a Device,
    /// How long to search for each program.
    pub effort: Effort,
    /// Seed of the search, of stochastic rounding and of the silicon.
    pub seed: u64,
    /// Events of one pixel and sign that are closer than this match.
    pub within: Micros,
}

/// What became of one quantised kernel.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Row {
    /// The quantiser.
    pub to: String,
    /// `|w - scale l| / |w|`.
    pub relative_error: f64,
    /// What its program costs and says; or why there is none.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// A program, or none.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It runs.
    OnChip(OnChip),
    /// It does not fit; what is short, and by how much.
    Refused(String),
}

/// A compiled program and its events.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OnChip {
    /// Instruction words of the filter.
    pub filter_words: u64,
    /// Instruction words of a frame.
    pub words: u64,
    /// Microseconds a frame on the array, without readout.
    pub array_us: f64,
    /// Analogue registers that the filter holds at a time.
    pub registers: usize,
    /// Halvings of the light before anything else, a bit each.
    pub prescale_bits: u32,
    /// Without errors of the chip.
    pub exact: Score,
    /// With its errors.
    pub silicon: Score,
}

/// Events against the float reference's.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Score {
    /// Harmonic mean of precision and recall.
    pub f1: f64,
    /// Events for each of the reference's; none where it has none.
    pub event_ratio: Option<f64>,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Answer {
    /// Events of the float reference.
    pub reference_events: u64,
    /// A row for each quantiser.
    pub rows: Vec<Row>,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum QuantisationError {
    /// A kernel cannot be quantised as asked.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Quantise(#[from] QuantiseError),
    /// Scene or sensor cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rig(#[from] RigError),
    /// A sensor cannot be made.
    #[error("{what}: {why}")]
    #[diagnostic(help("{help}"))]
    Sensor {
        /// Which.
        what: String,
        /// Why.
        why: String,
        /// What to do.
        help: String,
    },
}

/// Shows the scene to all of them at once.
///
/// # Errors
/// When a kernel cannot be quantised as asked, or the scene or a sensor cannot go on.
pub fn ask(
    question: &Question<'_>,
    scene: &mut dyn Scene,
    seen: impl FnMut(&Frame),
) -> Result<Answer, QuantisationError> {
    let size = scene.size();
    let mut reference = question.reference(size)?;
    let mut built = Vec::new();
    for to in question.quantisers {
        built.push(question.build(*to, size)?);
    }
    let mut sensors: Vec<&mut (dyn Sensor + Send)> = vec![&mut reference];
    for one in &mut built {
        if let Ok(program) = &mut one.program {
            sensors.extend(
                program
                    .chips
                    .iter_mut()
                    .map(|c| c as &mut (dyn Sensor + Send)),
            );
        }
    }
    let mut packets = rig::watch(scene, &mut sensors, seen)?.into_iter();
    let truth = packets
        .next()
        .ok_or_else(|| failed("the rig", "it gave no packet"))?;
    let mut rows = Vec::new();
    for Built {
        to,
        relative_error,
        program,
    } in built
    {
        let outcome = match program {
            Err(why) => Outcome::Refused(why),
            Ok(program) => {
                let mut scores = Vec::new();
                for packet in packets.by_ref().take(program.chips.len()) {
                    let comparison = compare::compare(&truth, &packet, question.within);
                    scores.push(Score::of(&comparison.map_err(|e| failed(&to, &e))?));
                }
                let [exact, silicon] = scores[..] else {
                    return Err(failed(&to, "a packet is missing"));
                };
                Outcome::OnChip(OnChip {
                    exact,
                    silicon,
                    ..program.cost
                })
            }
        };
        rows.push(Row {
            to,
            relative_error,
            outcome,
        });
    }
    Ok(Answer {
        reference_events: truth.events.len() as u64,
        rows,
    })
}

struct Built {
    to: String,
    relative_error: f64,
    /// Or why there is none.
    program: Result<Chips, String>,
}

struct Chips {
    /// The scores are still to come.
    cost: OnChip,
    /// In exact arithmetic, and as silicon.
    chips: [Box<dyn Array + Send>; 2],
}

fn failed(what: &str, why: &(impl ToString + ?Sized)) -> QuantisationError {
    QuantisationError::Sensor {
        what: what.to_owned(),
        why: why.to_string(),
        help: "this is a fault of amacrine: please report the kernel and the command".to_owned(),
    }
}

impl Question<'_> {
    fn reference(&self, size: Size) -> Result<Reference, QuantisationError> {
        let rows = self.kernel.weights().rows();
        let rows: Vec<Vec<f64>> = rows.into_iter().map(|row| row.to_vec()).collect();
        let text = format!(
            "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n[[channel]]\nkernel = {rows:?}\nthreshold = {{ on = {t:?}, off = {t:?} }}\n",
            t = self.threshold
        );
        let none = |name: &str| Err(std::io::Error::other(format!("{name} is not needed")));
        let description = Description::parse("float", &text, &none);
        let description = description.map_err(|e| failed("the float sensor", &e))?;
        Reference::new(description, size, self.seed).map_err(|e| failed("the float sensor", &e))
    }

    fn build(&self, to: Quantiser, size: Size) -> Result<Built, QuantisationError> {
        let quantised = to.quantise(self.kernel, self.sum, self.seed)?.within_one();
        let threshold = self.threshold / quantised.scale;
        let kind = Kind {
            kernel: quantised.levels.clone(),
            on: threshold,
            off: threshold,
        };
        let program = match self.program(kind) {
            Err(error) => Err(error.to_string()),
            Ok(program) => self.chips(&to.to_string(), &program, size)?,
        };
        Ok(Built {
            to: to.to_string(),
            relative_error: quantised.relative_error(self.kernel),
            program,
        })
    }

    fn program(&self, kind: Kind) -> Result<SensorProgram, CompileError> {
        let kernels = [kind.kernel.clone()];
        let mut request = Request::new(&kernels, self.device)?;
        request.effort = self.effort;
        request.seed = self.seed;
        SensorProgram::new(&[kind], Memory::Analogue, "quantised", &request)
    }

    fn chips(
        &self,
        name: &str,
        program: &SensorProgram,
        size: Size,
    ) -> Result<Result<Chips, String>, QuantisationError> {
        let text = Program::parse(name, &program.text).map_err(|e| failed(name, &e))?;
        let code = match text.expand(self.device, &Overrides::default()) {
            Ok(expansion) => expansion.code,
            // A few words more than the chip stores.
            Err(faults) => return Ok(Err(faults.to_string())),
        };
        let settings = Settings {
            clip: true,
            ..Settings::of(self.device)
        };
        let chip = |arithmetic: Arithmetic| {
            arithmetic
                .chip(name, code.clone(), self.device, size, settings)
                .map_err(|e| failed(name, &e))
        };
        let exact = chip(Arithmetic::Number(Format::F64))?;
        let silicon = chip(Arithmetic::Silicon { seed: self.seed })?;
        let cost = Cost::of(&code.frame, self.device);
        let empty = Score {
            f1: 0.0,
            event_ratio: None,
        };
        Ok(Ok(Chips {
            cost: OnChip {
                filter_words: program.filter.words.len() as u64,
                words: cost.words.0,
                array_us: cost.array_us,
                registers: program.filter.live.iter().map(Vec::len).max().unwrap_or(1),
                prescale_bits: program.filter.prescale,
                exact: empty,
                silicon: empty,
            },
            chips: [exact, silicon],
        }))
    }
}

impl Score {
    fn of(comparison: &Comparison) -> Self {
        let [reference, judged] = comparison.events.map(|events| events as f64);
        Self {
            f1: comparison.f1,
            event_ratio: (reference > 0.0).then(|| judged / reference),
        }
    }
}
