//! The steps: one after the other switched on, at the clip's own frame rate.

use std::borrow::Cow;

use serde::Serialize;

use super::{
    Cause, Fall, Question, WaterfallError,
    sensor::{Setup, Switches},
};
use crate::{
    array::{Arithmetic, Unheld},
    compare::{
        Pair,
        fate::{Fate, Windows},
        window,
    },
    event::{Packet, readout::ReadOut},
    reference::MemoryRule,
    rig::{
        self,
        guard::{Guard, Warning},
    },
    scene::{Frame, Scene},
    sensor::Overflowed,
    study::{
        equivalent::{Ladder, Likeness, RUNGS},
        saturation,
    },
    unit::Micros,
};

/// Events of a cell that are at most this far apart are *kept* in a step's [`Fate`], though no
/// further than the window of the question.
const NARROW: Micros = Micros(1000);

/// The answer. Shares are of the float sensor's events.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waterfall {
    /// What leaves the chip against the float sensor that decides once a frame too: the number
    /// of `quantise` and `feasibility`.
    #[serde(flatten)]
    pub likeness: Likeness,
    /// Events of that float sensor, which `event_ratio` is for each of.
    pub reference_events: u64,
    /// Events of the float sensor at the times of its crossings, with which the steps begin.
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
    pub program: ProgramCost,
    /// In the order in which they are added.
    pub steps: Vec<Step>,
    /// The float sensor against what leaves the chip, at once.
    pub ends: Fate,
    /// What makes these figures mean something else than they seem to.
    pub warnings: Vec<Warning>,
}

/// What the chip's program takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProgramCost {
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
    /// The sensor with this step and those before it on, against the float sensor at the times
    /// of its crossings.
    #[serde(flatten)]
    pub likeness: Likeness,
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

/// The steps at the clip's own frame rate: shows the scene to all their sensors at once.
///
/// # Errors
/// When a sensor cannot be made, scene or sensor cannot go on, or the float sensor is silent.
pub fn ask(
    question: &Question<'_>,
    scene: &mut dyn Scene,
    seen: impl FnMut(&Frame),
) -> Result<Waterfall, WaterfallError> {
    Fall::new(*question)?.steps(scene, seen)
}

/// The steps of falls that end in one program, on all of a scene: every sensor has all kinds and
/// watches it at once.
///
/// # Errors
/// When scene or sensor cannot go on, or the float sensor of a kind is silent.
pub fn steps_together(
    falls: &[Fall<'_>],
    scene: &mut dyn Scene,
    mut seen: impl FnMut(&Frame),
) -> Result<Vec<Waterfall>, WaterfallError> {
    let Some(first) = falls.first() else {
        return Ok(Vec::new());
    };
    let (question, kinds) = (first.question, &first.kinds);
    let (size, fps) = (scene.size(), scene.fps());
    let plan = Plan::new(&question).ok_or(WaterfallError::Packet)?;
    let mut sensors = Vec::new();
    for setup in &plan.setups {
        sensors.push(setup.sensor(&question, kinds, size)?);
    }
    let (step, snap) = (MemoryRule::FilteredStep, MemoryRule::FilteredSnap);
    sensors.extend(kinds.ladder(step, size)?);
    sensors.push(kinds.float(false, snap, size)?);
    sensors.extend(kinds.ladder(snap, size)?);
    let mut guard = Guard::new();
    let (program, settings) = (&kinds.compiled, kinds.compiled.settings());
    let parts = [&program.code.init[..], &program.code.frame];
    let cells = question.arithmetic;
    let unheld = Unheld::of_program(cells, &parts, &program.device, &settings);
    if let Some(unheld) = &unheld {
        saturation::warn_unheld(&mut guard, "the chip", unheld);
    }
    let mut overflow = saturation::of_light(cells, &settings);
    let mut fired = rig::watch(scene, &mut rig::each(&mut sensors), |frame| {
        guard.frame(frame);
        overflow.see(frame);
        seen(frame);
    })?;
    guard.extend(overflow.warning("the chip", Overflowed::default()));
    let floats = fired.split_off(plan.setups.len());
    let read: Vec<Option<ReadOut>> = { fired.iter().enumerate() }
        .map(|(i, packet)| {
            plan.is_read((i, true))
                .then(|| question.readout.read(packet))
        })
        .collect();
    let of_chip = read.get(plan.chip.0).and_then(Option::as_ref);
    let mut stages = of_chip.into_iter().flat_map(|read| &read.statistics.stages);
    if let Some(stage) = stages.find(|stage| stage.falls_behind) {
        guard.warn(Warning::late("the chip", stage.name));
    }
    let read: Vec<Option<Packet>> = { read.into_iter() }
        .map(|read| read.map(|read| read.packet))
        .collect();
    let shown = Shown {
        plan: &plan,
        fired: &fired,
        read: &read,
        floats: &floats,
        fps,
        guard: &guard,
    };
    falls.iter().map(|fall| fall.told(&shown)).collect()
}

/// What all sensors said of all kinds.
struct Shown<'a> {
    plan: &'a Plan,
    fired: &'a [Packet],
    read: &'a [Option<Packet>],
    /// The ladders of both float sensors, the one that decides once a frame between them.
    floats: &'a [Packet],
    fps: f64,
    guard: &'a Guard,
}

impl Fall<'_> {
    /// The steps, on all of a scene: every sensor of them watches it at once.
    ///
    /// # Errors
    /// When scene or sensor cannot go on, or the float sensor is silent.
    pub fn steps(
        &self,
        scene: &mut dyn Scene,
        seen: impl FnMut(&Frame),
    ) -> Result<Waterfall, WaterfallError> {
        let all = steps_together(std::slice::from_ref(self), scene, seen)?;
        all.into_iter().next().ok_or(WaterfallError::Packet)
    }

    /// What became of this kind.
    fn told(&self, shown: &Shown<'_>) -> Result<Waterfall, WaterfallError> {
        let (question, plan, fps) = (self.question, shown.plan, shown.fps);
        let mut guard = shown.guard.clone();
        if let Some(quantised) = self.kinds.quantised(self.kind) {
            let to = question.to.to_string();
            let erasures = quantised.erasures(question.design.kernel).into_iter();
            guard.extend(erasures.map(|erasure| Warning::erased(&to, erasure)));
        }
        let floats: Cow<'_, [Packet]> = if self.kinds.count() == 1 {
            Cow::Borrowed(shown.floats)
        } else {
            let own = |packet| self.own(packet).into_owned();
            Cow::Owned(shown.floats.iter().map(own).collect())
        };
        let packets = Packets {
            fired: { shown.fired.iter() }
                .map(|packet| self.own(packet))
                .collect(),
            read: { shown.read.iter() }
                .map(|packet| packet.as_ref().map(|packet| self.own(packet)))
                .collect(),
            windows: Windows {
                narrow: question.within.min(NARROW),
                wide: window::interval(fps).max(question.within.min(NARROW)),
            },
        };
        if packets.at(plan.float)?.events.is_empty() {
            return Err(question.silent());
        }
        let ladder = |reference: &Packet, rungs: &[Packet]| {
            let seed = question.design.seed;
            Ladder::new(reference.clone(), rungs, question.within, fps, seed)
        };
        let (rungs, decided) = floats.split_at(RUNGS.len());
        let (once, decided) = decided.split_first().ok_or(WaterfallError::Packet)?;
        let ladders = [
            ladder(packets.at(plan.float)?, rungs)?,
            ladder(once, decided)?,
        ];
        let [_, decided] = &ladders;
        if !decided.reference().events.is_empty() {
            guard.extend(Warning::window(question.within, decided.floor()));
        }
        let events = packets.at(plan.float)?.events.len() as u64;
        guard.extend(Warning::few_events(events));
        guard.packet("the float sensor", packets.at(plan.float)?);
        guard.packet("the chip", packets.at(plan.chip)?);
        packets.assemble(self, plan, &ladders, guard)
    }
}

impl Plan {
    /// None in a sound build: the forward chain exists for every arithmetic.
    fn new(question: &Question<'_>) -> Option<Self> {
        let causes: &[Cause] = match question.arithmetic {
            Arithmetic::Number(_) => &Cause::NUMBERS,
            Arithmetic::Silicon { .. } => Cause::SILICON,
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
struct Packets<'a> {
    fired: Vec<Cow<'a, Packet>>,
    read: Vec<Option<Cow<'a, Packet>>>,
    windows: Windows,
}

impl Packets<'_> {
    fn at(&self, (sensor, read): Place) -> Result<&Packet, WaterfallError> {
        let packet = if read {
            self.read.get(sensor).and_then(Option::as_deref)
        } else {
            self.fired.get(sensor).map(|packet| &**packet)
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

    /// The ladders are those of the float sensor at the times of its crossings, and of the one
    /// that decides once a frame.
    fn assemble(
        &self,
        fall: &Fall<'_>,
        plan: &Plan,
        [ladder, decided]: &[Ladder; 2],
        guard: Guard,
    ) -> Result<Waterfall, WaterfallError> {
        let (question, program) = (&fall.question, fall.program());
        let float_events = self.at(plan.float)?.events.len() as u64;
        let mut steps = Vec::new();
        for pairs in &plan.steps {
            let forward = self.fate(pairs.forward)?;
            let backward = pairs.backward.map(|pair| self.fate(pair)).transpose()?;
            let share = |fate| Shares::new(fate, float_events);
            let (forward_share, backward_share) = (share(forward), backward.map(share));
            steps.push(Step {
                cause: pairs.cause,
                name: pairs.cause.name(),
                likeness: ladder.judge(self.at(pairs.forward[1])?)?,
                forward,
                backward,
                forward_share,
                backward_share,
                interaction: backward_share.map(|backward| backward.less(forward_share)),
            });
        }
        let filter = fall.kinds.filter(fall.kind);
        Ok(Waterfall {
            likeness: decided.judge(self.at(plan.chip)?)?,
            reference_events: decided.reference().events.len() as u64,
            float_events,
            chip_events: self.at(plan.chip)?.events.len() as u64,
            windows: self.windows,
            to: question.to.to_string(),
            arithmetic: question.arithmetic.to_string(),
            program: ProgramCost {
                words: program.cost.words.0,
                array_us: program.cost.array_us,
                registers: program.registers(),
                prescale_bits: filter.prescale,
                threshold_lsb: fall.threshold_lsb(),
            },
            steps,
            ends: self.fate([plan.float, plan.chip])?,
            warnings: guard.warnings(),
        })
    }
}
