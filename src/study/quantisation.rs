//! What a kernel in few values loses on the chip, and what it costs there: the float kernel in
//! the reference against each quantised one as a compiled program, on one scene.
//!
//! Every row is the same sensor (memory `filtered-snap`, one decision a frame, zeros beyond the
//! border) but for its kernel. In `exact` arithmetic the row shows what few values do; in
//! `silicon` what the chip does besides.

use crate::{
    array::Arithmetic,
    event::Packet,
    kernel::quantise::{Erasure, Quantiser, Sum},
    number::Format,
    plane::Size,
    reference::MemoryRule,
    rig::{
        self,
        guard::{Guard, Warning},
    },
    scene::{Frame, Reopen, Scene},
    unit::Micros,
};

use super::{
    StudyError,
    all_events::AllEvents,
    design::{Compiled, Design, DesignError},
    equivalent::{self, Ladder, Likeness},
    saturation,
};

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The float cell, and the chip, whose seed is that of the silicon, too.
    pub design: Design<'a>,
    /// One row each.
    pub quantisers: &'a [Quantiser],
    /// What quantised kernels must sum to.
    pub sum: Sum,
    /// Events of one pixel and sign that are closer than this match.
    pub within: Micros,
}

/// What became of one quantised kernel.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Row {
    /// The quantiser.
    pub to: String,
    /// `|w - scale l| / |w|`; none where the kernel is not to be had in these values.
    pub relative_error: Option<f64>,
    /// How the chip compares with the float kernel; none without a program.
    #[serde(flatten)]
    pub headline: Option<Headline>,
    /// What its program costs and says; or why there is none.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// What of a chip's [`Likeness`] a row begins with.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Headline {
    /// What of F1 is more than chance; none where nothing can be kept.
    pub kept: Option<f64>,
    /// The window of the matches, in microseconds.
    pub window_us: Micros,
    /// Frames a second that were shown.
    pub fps: f64,
    /// The change of the float sensor's threshold that costs as much, in per cent; none where
    /// the float sensor has no event, or chance scores as much as anything.
    pub threshold_equivalent_percent: Option<f64>,
}

impl From<Likeness> for Headline {
    fn from(of: Likeness) -> Self {
        Self {
            kept: of.kept,
            window_us: of.window_us,
            fps: of.fps,
            threshold_equivalent_percent: of.threshold_equivalent_percent,
        }
    }
}

/// A program, or none.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It runs.
    OnChip(Box<OnChip>),
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
    /// The most analogue registers of the filter that are live at a time.
    pub registers: usize,
    /// Halvings of the light before anything else, a bit each.
    pub prescale_bits: u32,
    /// Without errors of the chip.
    pub exact: Likeness,
    /// With its errors.
    pub silicon: Likeness,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Answer {
    /// Events of the float reference.
    pub reference_events: u64,
    /// Frames a second that were shown.
    pub fps: f64,
    /// Events of one pixel and sign match within this, in microseconds.
    pub window_us: Micros,
    /// A row for each quantiser.
    pub rows: Vec<Row>,
    /// What makes these figures mean something else than they seem to.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum QuantisationError {
    /// What any study can end with.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(StudyError),
    /// Fewer packets than sensors.
    #[error("{0}: a packet is missing")]
    #[diagnostic(help("this is a fault of amacrine: please report the kernel and the command"))]
    Packet(String),
}

impl<E: Into<StudyError>> From<E> for QuantisationError {
    fn from(cause: E) -> Self {
        Self::Study(cause.into())
    }
}

/// Shows the scene to all of them at once, and once more to float sensors of as many events as
/// each.
///
/// # Errors
/// When a kernel cannot be quantised as asked, or the scene or a sensor cannot go on.
pub fn ask(
    question: &Question<'_>,
    open: &Reopen<'_>,
    seen: impl FnMut(&Frame),
) -> Result<Answer, QuantisationError> {
    Ok(ask_keeping(question, open, seen)?.0)
}

/// What has run for an answer.
pub(super) struct Kept {
    /// The packets of the float sensors: the reference's, and those of the ladder that all were
    /// judged by, in the order of [`equivalent::RUNGS`].
    pub floats: Vec<Packet>,
    /// For each row its program; none where there is none.
    pub ran: Vec<Option<Ran>>,
}

/// A program that has run.
pub(super) struct Ran {
    /// The program.
    pub compiled: Compiled,
    /// It in exact arithmetic, and as silicon, after the last frame.
    pub chips: [AllEvents; 2],
    /// What these said: all of their events.
    pub packets: [Packet; 2],
}

/// As [`ask`], with what has run for it.
pub(super) fn ask_keeping(
    question: &Question<'_>,
    open: &Reopen<'_>,
    mut seen: impl FnMut(&Frame),
) -> Result<(Answer, Kept), QuantisationError> {
    let mut scene = open()?;
    let (size, fps) = (scene.size(), scene.fps());
    let design = &question.design;
    let mut built = Vec::new();
    for to in question.quantisers {
        built.push(question.build(*to, size)?);
    }
    let mut guard = Guard::new();
    let mut subjects = Vec::new();
    for one in &built {
        let erasures = one.erasures.iter();
        guard.extend(erasures.map(|erasure| Warning::erased(&one.to, *erasure)));
        let chips = one.program.iter().flat_map(|program| &program.both);
        subjects.extend(chips.map(|it| format!("{} {}", one.to, it.chip().domain())));
    }
    let mut floats = vec![design.reference(size, MEMORY, Format::F64)?];
    floats.extend(equivalent::sensors(design, size, MEMORY)?);
    let mut sensors = rig::each(&mut floats);
    for chip in { built.iter_mut() }
        .filter_map(|one| one.program.as_mut().ok())
        .flat_map(|program| &mut program.both)
    {
        sensors.push(chip);
    }
    let mut packets = rig::watch(&mut *scene, &mut sensors, |frame| {
        guard.frame(frame);
        seen(frame);
    })?;
    let (rungs, chips) = packets.split_at(floats.len());
    let [truth, rungs @ ..] = rungs else {
        return Err(QuantisationError::Packet("float".to_owned()));
    };
    let ladder = Ladder::new(truth.clone(), rungs, question.within, fps, design.seed)?;
    guard.packet("the float sensor", truth);
    if !truth.events.is_empty() {
        guard.extend(Warning::window(question.within, ladder.floor()));
    }
    guard.extend(Warning::few_events(truth.events.len() as u64));
    let mut judged = Vec::new();
    let ran = { built.iter() }
        .filter_map(|one| one.program.as_ref().ok())
        .flat_map(|program| program.both.iter().zip(program.ends));
    for ((packet, subject), (chip, ends)) in chips.iter().zip(subjects).zip(ran) {
        guard.packet(&subject, packet);
        let (lost, all) = (chip.lost().total(), packet.events.len() as u64);
        if lost > 0 {
            guard.warn(Warning::own_slots(&subject, lost, all));
        }
        saturation::warn(&mut guard, &subject, chip.chip(), ends);
        judged.push(ladder.judge(packet)?);
    }
    let mut pairs: Vec<_> = chips.iter().zip(&mut judged).collect();
    equivalent::tune(
        &ladder,
        design,
        MEMORY,
        &mut *open()?,
        &mut pairs,
        &mut seen,
    )?;
    let reference_events = truth.events.len() as u64;
    let mut said = packets.split_off(floats.len()).into_iter();
    let mut judged = judged.into_iter();
    let (mut rows, mut ran) = (Vec::new(), Vec::new());
    for one in built {
        let (row, chips) = one.judged(&mut judged)?;
        let one = chips.map(|Chips { compiled, both, .. }| {
            let packets = [said.next()?, said.next()?];
            Some(Ran {
                compiled,
                chips: both,
                packets,
            })
        });
        rows.push(row);
        ran.push(one.flatten());
    }
    let answer = Answer {
        reference_events,
        fps,
        window_us: question.within,
        rows,
        warnings: guard.warnings(),
    };
    let kept = Kept {
        floats: packets,
        ran,
    };
    Ok((answer, kept))
}

/// The memory of all sensors: a chip has one shot a frame, and its memory snaps.
const MEMORY: MemoryRule = MemoryRule::FilteredSnap;

struct Built {
    to: String,
    relative_error: Option<f64>,
    erasures: Vec<Erasure>,
    /// Or why there is none.
    program: Result<Chips, String>,
}

impl Built {
    /// The row of it, with the next two judgements: in exact arithmetic, and as silicon. Also what
    /// has run.
    fn judged(
        self,
        all: &mut impl Iterator<Item = Likeness>,
    ) -> Result<(Row, Option<Chips>), QuantisationError> {
        let (headline, outcome, chips) = match self.program {
            Err(why) => (None, Outcome::Refused(why), None),
            Ok(chips) => {
                let cost = &chips.cost;
                let mut next = || all.next().ok_or(QuantisationError::Packet(self.to.clone()));
                let (exact, silicon) = (next()?, next()?);
                let on_chip = OnChip {
                    filter_words: cost.filter_words,
                    words: cost.words,
                    array_us: cost.array_us,
                    registers: cost.registers,
                    prescale_bits: cost.prescale_bits,
                    exact,
                    silicon,
                };
                let outcome = Outcome::OnChip(Box::new(on_chip));
                (Some(silicon.into()), outcome, Some(chips))
            }
        };
        let row = Row {
            to: self.to,
            relative_error: self.relative_error,
            headline,
            outcome,
        };
        Ok((row, chips))
    }
}

struct Chips {
    compiled: Compiled,
    cost: Costs,
    /// In exact arithmetic, and as silicon: every event, however many slots the program has.
    both: [AllEvents; 2],
    /// The ends of their registers' range.
    ends: [Option<[f64; 2]>; 2],
}

/// What of [`OnChip`] is known before it runs.
struct Costs {
    filter_words: u64,
    words: u64,
    array_us: f64,
    registers: usize,
    prescale_bits: u32,
}

impl Question<'_> {
    fn build(&self, to: Quantiser, size: Size) -> Result<Built, DesignError> {
        let design = &self.design;
        let mut built = Built {
            to: to.to_string(),
            relative_error: None,
            erasures: Vec::new(),
            program: Err(String::new()),
        };
        let quantised = match design.quantise(to, self.sum) {
            Err(error @ DesignError::Quantise(_)) => {
                built.program = Err(error.to_string());
                return Ok(built);
            }
            quantised => quantised?,
        };
        built.relative_error = Some(quantised.relative_error(design.kernel));
        built.erasures = quantised.erasures(design.kernel);
        built.program = match design.in_levels(&quantised).compile("quantised") {
            Err(error) if error.is_refusal() => Err(error.to_string()),
            Err(error) => return Err(error),
            Ok(compiled) => Ok(self.chips(compiled, size)?),
        };
        Ok(built)
    }

    fn chips(&self, compiled: Compiled, size: Size) -> Result<Chips, DesignError> {
        let settings = compiled.settings();
        let chip = |arithmetic| {
            let chip = compiled.chip(arithmetic, size, settings)?;
            Ok::<_, DesignError>(compiled.all_events(chip))
        };
        let exact = Arithmetic::Number(Format::F64);
        let silicon = Arithmetic::Silicon {
            seed: self.design.seed,
        };
        let both = [chip(exact)?, chip(silicon)?];
        let filter = &compiled.program.filter;
        Ok(Chips {
            cost: Costs {
                filter_words: filter.word_count(&compiled.device),
                words: compiled.cost.words.0,
                array_us: compiled.cost.array_us,
                registers: compiled.registers(),
                prescale_bits: filter.prescale,
            },
            both,
            ends: [exact, silicon].map(|domain| domain.ends(self.design.device, &settings)),
            compiled,
        })
    }
}
