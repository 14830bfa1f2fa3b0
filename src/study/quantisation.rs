//! What a kernel in few values loses on the chip, and what it costs there: the float kernel in
//! the reference against each quantised one as a compiled program, on one scene.
//!
//! Every row is the same sensor (memory `filtered-snap`, one decision a frame, zeros beyond the
//! border) but for its kernel. In `exact` arithmetic the row shows what few values do; in
//! `silicon` what the chip does besides.

use crate::{
    array::{Arithmetic, Array},
    compare::{self, CompareError, Comparison},
    compile::Effort,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    number::Format,
    plane::Size,
    reference::MemoryRule,
    rig::{
        self, RigError,
        guard::{Guard, Warning},
    },
    scene::{Frame, Scene},
    sensor::Sensor,
    unit::Micros,
};

use super::design::{Compiled, Design, DesignError};

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
    /// What makes these figures mean something else than they seem to.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum QuantisationError {
    /// A kernel cannot be quantised as asked, or a sensor not be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Design(#[from] DesignError),
    /// Scene or sensor cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rig(#[from] RigError),
    /// The packets have nothing in common.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compare(#[from] CompareError),
    /// Fewer packets than sensors.
    #[error("{0}: a packet is missing")]
    #[diagnostic(help("this is a fault of amacrine: please report the kernel and the command"))]
    Packet(String),
}

/// Shows the scene to all of them at once.
///
/// # Errors
/// When a kernel cannot be quantised as asked, or the scene or a sensor cannot go on.
pub fn ask(
    question: &Question<'_>,
    scene: &mut dyn Scene,
    mut seen: impl FnMut(&Frame),
) -> Result<Answer, QuantisationError> {
    let size = scene.size();
    let design = question.design();
    let mut reference = design.reference(size, MemoryRule::FilteredSnap, Format::F64)?;
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
    let mut guard = Guard::new();
    let mut packets = rig::watch(scene, &mut sensors, |frame| {
        guard.frame(frame);
        seen(frame);
    })?
    .into_iter();
    let missing = |of: &str| QuantisationError::Packet(of.to_owned());
    let truth = packets.next().ok_or_else(|| missing("float"))?;
    guard.packet("the float sensor", &truth);
    let mut rows = Vec::new();
    for Built {
        to,
        relative_error,
        program,
    } in built
    {
        let outcome = match program {
            Err(why) => Outcome::Refused(why),
            Ok(Chips { cost, chips }) => {
                let mut domains = chips.iter().map(|chip| chip.domain());
                let mut score = || -> Result<Score, QuantisationError> {
                    let packet = packets.next().ok_or_else(|| missing(&to))?;
                    let domain = domains.next().unwrap_or_default();
                    guard.packet(&format!("{to} {domain}"), &packet);
                    let comparison = compare::compare(&truth, &packet, question.within)?;
                    Ok(Score::of(&comparison))
                };
                Outcome::OnChip(OnChip {
                    exact: score()?,
                    silicon: score()?,
                    ..cost
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
        warnings: guard.warnings(),
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

impl Question<'_> {
    fn design(&self) -> Design<'_> {
        Design {
            kernel: self.kernel,
            threshold: self.threshold,
            device: self.device,
            effort: self.effort,
            seed: self.seed,
        }
    }

    fn build(&self, to: Quantiser, size: Size) -> Result<Built, DesignError> {
        let design = self.design();
        let quantised = design.quantise(to, self.sum)?;
        let program = match design.in_levels(&quantised).compile("quantised") {
            Err(error) if error.is_refusal() => Err(error.to_string()),
            Err(error) => return Err(error),
            Ok(compiled) => Ok(self.chips(&compiled, size)?),
        };
        Ok(Built {
            to: to.to_string(),
            relative_error: quantised.relative_error(self.kernel),
            program,
        })
    }

    fn chips(&self, compiled: &Compiled, size: Size) -> Result<Chips, DesignError> {
        let chip = |arithmetic| compiled.chip(arithmetic, size, compiled.settings());
        let empty = Score {
            f1: 0.0,
            event_ratio: None,
        };
        let filter = &compiled.program.filter;
        Ok(Chips {
            cost: OnChip {
                filter_words: filter.words.len() as u64,
                words: compiled.cost.words.0,
                array_us: compiled.cost.array_us,
                registers: compiled.registers(),
                prescale_bits: filter.prescale,
                exact: empty,
                silicon: empty,
            },
            chips: [
                chip(Arithmetic::Number(Format::F64))?,
                chip(Arithmetic::Silicon { seed: self.seed })?,
            ],
        })
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
