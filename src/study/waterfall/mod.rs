//! The waterfall: where the events of the float sensor go on the way to the chip.
//!
//! Every [`Cause`] is a switch on a sensor that runs: the first three on the float model, the
//! others on the compiled program. Each step is measured in both orders:
//!
//! - **forward**: what adding it changes, given the steps before it. The sensors `f_0 … f_n`
//!   have the first 0 … n steps on; step i is `f_(i-1)` against `f_i`.
//! - **backward**: what it alone changes, given all the others. The sensor with every step on
//!   but this one, against the one with all on; for the float model's steps, among themselves.
//!
//! Where the two differ, steps interact. Not every set of steps is a sensor: `docs/waterfall.md`
//! says which are run, and what adds up and what does not.

mod cause;
mod chart;
mod question;
mod sensor;

pub use cause::Cause;
pub use question::Question;

use serde::Serialize;

use self::sensor::{Setup, Switches};
use super::design::{Compiled, Design, DesignError};
use crate::{
    array::Arithmetic,
    compare::{
        CompareError, Pair,
        fate::{Fate, Windows},
    },
    event::Packet,
    reference::MemoryRule,
    rig::{
        self, RigError,
        guard::{Guard, Warning},
    },
    scene::{Frame, Scene},
    sensor::Sensor,
    unit::Micros,
};

/// The answer. Shares are of the float sensor's events.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waterfall {
    /// Events of the float sensor.
    pub float_events: u64,
    /// Events that leave the chip.
    pub chip_events: u64,
    /// Which events are the same, and which are mistimed: the wide window is the time from
    /// frame to frame.
    pub windows: Windows,
    /// The quantiser.
    pub to: String,
    /// What the chip's cells hold.
    pub arithmetic: String,
    /// The chip's program.
    pub program: Words,
    /// In the order in which they are added.
    pub steps: Vec<Step>,
    /// The float sensor against what leaves the chip, at once.
    pub ends: Fate,
    /// What makes these figures mean something else than they seem to.
    pub warnings: Vec<Warning>,
}

/// What the chip's program takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Words {
    /// Instruction words of a frame.
    pub words: u64,
    /// Microseconds a frame on the array, without readout.
    pub array_us: f64,
    /// Analogue registers that its filter holds at a time.
    pub registers: usize,
    /// Halvings of the light before anything else, a bit each.
    pub prescale_bits: u32,
    /// The threshold, in LSB.
    pub threshold_lsb: f64,
}

/// What one step does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// The cause that this step switches on.
    pub cause: Cause,
    /// In a few words.
    pub name: &'static str,
    /// Given the steps before it.
    pub forward: Fate,
    /// Given all the others; none where there is no sensor without it.
    pub backward: Option<Fate>,
    /// Forward, as a part of the float sensor's events.
    pub forward_share: Shares,
    /// Backward.
    pub backward_share: Option<Shares>,
    /// Backward less forward.
    pub interaction: Option<Shares>,
}

/// A [`Fate`] as parts of the float sensor's events; 1 is as many.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shares {
    /// Within the wide window only.
    pub mistimed: f64,
    /// Of the opposite sign.
    pub wrong_sign: f64,
    /// No longer there.
    pub lost: f64,
    /// Not there before.
    pub extra: f64,
}

impl Waterfall {
    /// As parts of the float sensor's events.
    #[must_use]
    pub fn shares(&self, fate: Fate) -> Shares {
        Shares::new(fate, self.float_events)
    }
}

impl Shares {
    fn new(fate: Fate, events: u64) -> Self {
        let share = |n: u64| n as f64 / events as f64;
        Self {
            mistimed: share(fate.mistimed),
            wrong_sign: share(fate.wrong_sign),
            lost: share(fate.lost),
            extra: share(fate.extra),
        }
    }

    fn less(self, other: Self) -> Self {
        Self {
            mistimed: self.mistimed - other.mistimed,
            wrong_sign: self.wrong_sign - other.wrong_sign,
            lost: self.lost - other.lost,
            extra: self.extra - other.extra,
        }
    }

    /// All four together.
    #[must_use]
    pub fn changed(self) -> f64 {
        self.mistimed + self.wrong_sign + self.lost + self.extra
    }
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum WaterfallError {
    /// A sensor cannot be made.
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
    /// No event to follow.
    #[error("the float sensor has no event on this scene")]
    #[diagnostic(help(
        "lower the threshold, now {threshold}, or show a scene that moves, its light on the scale 0 to 255"
    ))]
    Silent {
        /// The threshold.
        threshold: f64,
    },
    /// Fewer packets than sensors.
    #[error("a packet is missing")]
    #[diagnostic(help("this is a fault of amacrine: please report the command"))]
    Packet,
}

/// Within this an event is where it was, unless the question asks for less.
const NARROW: Micros = Micros(1000);

/// A packet of the waterfall: a sensor, and whether its events went through the readout.
type Place = (usize, bool);

/// Which sensors there are, and which of them each step compares.
struct Plan {
    setups: Vec<Setup>,
    float: Place,
    chip: Place,
    steps: Vec<Pairs>,
}

struct Pairs {
    cause: Cause,
    forward: [Place; 2],
    backward: Option<[Place; 2]>,
}

/// Shows the scene to all sensors of the waterfall at once.
///
/// # Errors
/// When a sensor cannot be made, scene or sensor cannot go on, or the float sensor is silent.
pub fn ask(
    question: &Question<'_>,
    scene: &mut dyn Scene,
    mut seen: impl FnMut(&Frame),
) -> Result<Waterfall, WaterfallError> {
    let (size, fps) = (scene.size(), scene.fps());
    let design = question.design;
    // The threshold as it was given is what a message names, not the one in levels.
    design.description(MemoryRule::FilteredSnap)?;
    let quantised = design.quantise(question.to, question.sum)?;
    let levels = design.in_levels(&quantised);
    let program = levels.compile("levels")?;
    let plan = Plan::new(question).ok_or(WaterfallError::Packet)?;
    let mut sensors = Vec::new();
    for setup in &plan.setups {
        sensors.push(setup.sensor(question, &levels, &program, size)?);
    }
    let mut watching: Vec<&mut (dyn Sensor + Send)> = Vec::new();
    for sensor in &mut sensors {
        watching.push(sensor);
    }
    let mut guard = Guard::new();
    for erasure in quantised.erasures(design.kernel) {
        guard.warn(Warning::erased(&question.to.to_string(), erasure));
    }
    let packets = rig::watch(scene, &mut watching, |frame| {
        guard.frame(frame);
        seen(frame);
    })?;
    let packets = Packets {
        read: packets
            .iter()
            .enumerate()
            .map(|(i, packet)| {
                let read = || question.readout.read(packet).packet;
                plan.is_read((i, true)).then(read)
            })
            .collect(),
        fired: packets,
        windows: Windows {
            narrow: question.within.min(NARROW),
            // `as` saturates.
            wide: Micros((1e6 / fps).ceil() as u64).max(question.within),
        },
    };
    guard.packet("the float sensor", packets.at(plan.float)?);
    guard.packet("the chip", packets.at(plan.chip)?);
    packets.assemble(question, &plan, &levels, &program, guard)
}

impl Plan {
    /// None in a sound build: the forward chain exists for every arithmetic.
    fn new(question: &Question<'_>) -> Option<Self> {
        let causes: &[Cause] = match question.arithmetic {
            Arithmetic::Number(_) => &Cause::NUMBERS,
            Arithmetic::Silicon { .. } => &Cause::SILICON,
        };
        let mut setups = Vec::new();
        let mut place = |on: &Switches| -> Option<Place> {
            let setup = Setup::new(question, on)?;
            // The same sensor is run once.
            let at = setups.iter().position(|other| *other == setup);
            let at = at.unwrap_or_else(|| {
                setups.push(setup);
                setups.len() - 1
            });
            Some((at, on.contains(&Cause::Readout)))
        };
        let first = |n: usize| -> Switches { causes.iter().take(n).copied().collect() };
        let forward: Vec<Place> = (0..=causes.len())
            .map(|n| place(&first(n)))
            .collect::<Option<_>>()?;
        let floats = causes.iter().filter(|cause| cause.is_float()).count();
        let mut steps = Vec::new();
        for (i, &cause) in causes.iter().enumerate() {
            let all = if cause.is_float() {
                floats
            } else {
                causes.len()
            };
            let mut without = first(all);
            without.remove(&cause);
            steps.push(Pairs {
                cause,
                forward: [*forward.get(i)?, *forward.get(i + 1)?],
                backward: match place(&without) {
                    Some(without) => Some([without, *forward.get(all)?]),
                    None => None,
                },
            });
        }
        Some(Self {
            setups,
            float: *forward.first()?,
            chip: *forward.last()?,
            steps,
        })
    }

    fn is_read(&self, place: Place) -> bool {
        let of = |step: &Pairs| {
            let backward = step.backward.into_iter().flatten();
            step.forward.into_iter().chain(backward).any(|p| p == place)
        };
        self.steps.iter().any(of)
    }
}

/// What each sensor said, and what of it left through the readout.
struct Packets {
    fired: Vec<Packet>,
    read: Vec<Option<Packet>>,
    windows: Windows,
}

impl Packets {
    fn at(&self, (sensor, read): Place) -> Result<&Packet, WaterfallError> {
        let packet = if read {
            self.read.get(sensor).and_then(Option::as_ref)
        } else {
            self.fired.get(sensor)
        };
        packet.ok_or(WaterfallError::Packet)
    }

    fn fate(&self, [before, after]: [Place; 2]) -> Result<Fate, WaterfallError> {
        let (reference, judged) = (self.at(before)?, self.at(after)?);
        if before == after {
            let kept = reference.events.len() as u64;
            return Ok(Fate {
                kept,
                ..Fate::default()
            });
        }
        Ok(Fate::from_pair(
            &Pair::new(reference, judged)?,
            self.windows,
        ))
    }

    fn assemble(
        &self,
        question: &Question<'_>,
        plan: &Plan,
        levels: &Design<'_>,
        program: &Compiled,
        guard: Guard,
    ) -> Result<Waterfall, WaterfallError> {
        let float_events = self.at(plan.float)?.events.len() as u64;
        if float_events == 0 {
            return Err(WaterfallError::Silent {
                threshold: question.design.threshold,
            });
        }
        let mut steps = Vec::new();
        for pairs in &plan.steps {
            let forward = self.fate(pairs.forward)?;
            let backward = pairs.backward.map(|pair| self.fate(pair)).transpose()?;
            let share = |fate| Shares::new(fate, float_events);
            let (forward_share, backward_share) = (share(forward), backward.map(share));
            steps.push(Step {
                cause: pairs.cause,
                name: pairs.cause.name(),
                forward,
                backward,
                forward_share,
                backward_share,
                interaction: backward_share.map(|backward| backward.less(forward_share)),
            });
        }
        let filter = &program.program.filter;
        Ok(Waterfall {
            float_events,
            chip_events: self.at(plan.chip)?.events.len() as u64,
            windows: self.windows,
            to: question.to.to_string(),
            arithmetic: question.arithmetic.to_string(),
            program: Words {
                words: program.cost.words.0,
                array_us: program.cost.array_us,
                registers: program.registers(),
                prescale_bits: filter.prescale,
                threshold_lsb: levels.threshold * program.program.scale,
            },
            steps,
            ends: self.fate([plan.float, plan.chip])?,
            warnings: guard.warnings(),
        })
    }
}
