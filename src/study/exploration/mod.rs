//! From kernels and a scene to sensors to choose from: the thresholds for a rate of events, and
//! for each quantiser and each way to remember a program, its readout, and what of the float
//! sensor's events it keeps on silicon.
//!
//! ```text
//! kernels ─┐              ┌─ thresholds ─┬─ quantiser × memory ─ compile ─ run ─┐
//! scene ───┴─ rate (study::rate)         └─ the float sensor it stands for ─────┴─ kept, words,
//!                                                                  frames/s ─ front ─ knee
//! ```
//!
//! Every candidate was compiled and has run. What a candidate has is read from the front: nothing
//! on it is beaten in all of kept, words and frames/s. The knee is the shortest program that keeps
//! at least [`NEARLY`] of the most that any keeps.

mod answer;
mod candidate;
mod doubts;
mod error;

pub use answer::Answer;
pub use candidate::{Candidate, Exploration, Kind, NEARLY, RatedThresholds, Refused};
pub use error::{ExplorationError, Untaken};

use super::{
    balance,
    design::{Compiled, Design, quantise_all},
    feasibility::time,
    rate::{self, RateError, four_digits},
    together::{self, Judged, memories},
};
use crate::{
    compare::window,
    compile::{CellKind, DriveMemory, Effort, EventReadout, SensorProgram},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    program::{
        Cost, Expectation, ExpectedWords, Program, Step,
        readout::{Demand, Scans, Way, choose},
    },
    reference::Description,
    scene::{Frame, Reopen},
    unit::Micros,
};

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// What the sensor is to be called.
    pub title: &'a str,
    /// What each kind is called; as many as kernels.
    pub names: &'a [String],
    /// The kernel of each kind of cell.
    pub kernels: &'a [Kernel],
    /// What the thresholds are to be.
    pub aim: Aim<'a>,
    /// Few values that are tried.
    pub quantisers: &'a [Quantiser],
    /// The one way to remember that is tried; else all that the chip has.
    pub memory: Option<DriveMemory>,
    /// What quantised kernels must sum to.
    pub sum: Sum,
    /// The chip.
    pub device: &'a Device,
    /// How long to search for each program.
    pub effort: Effort,
    /// Seed of the searches, of stochastic rounding and of the silicon.
    pub seed: u64,
    /// Events of one pixel, kind and sign that are closer than this match; else as headlines have
    /// it.
    pub within: Option<Micros>,
}

/// What the thresholds are to be.
#[derive(Clone, Copy, Debug)]
pub enum Aim<'a> {
    /// So many events per pixel and second, all kinds together, each an equal share.
    Rate(f64),
    /// In kernel times light (0 to 255), one for each kind.
    Thresholds(&'a [f64]),
}

/// Tries all of it on a scene that can be opened again: shown seven times for the thresholds, if a
/// rate is asked for (at most nineteen times more for kinds that share a memory), and then once for
/// each float sensor with its candidates. `seen` is called after each frame of those, and
/// `searching` before each search, with its number and how many there are.
///
/// # Errors
/// When the thresholds are not to be had, the scene cannot be read, or the chip takes none.
pub fn explore(
    question: &Question<'_>,
    open: &Reopen<'_>,
    searching: &dyn Fn(usize, usize),
    mut seen: impl FnMut(&Frame),
) -> Result<Exploration, ExplorationError> {
    question.check()?;
    let scene = open()?;
    let fps = scene.fps();
    drop(scene);
    let mut all = Exploration {
        candidates: Vec::new(),
        refused: Vec::new(),
        rated: Vec::new(),
        knee: None,
        fps,
        frames: 0,
        window_us: question.within.unwrap_or_else(|| window::headline(fps)),
    };
    let every = match question.memory {
        Some(memory) => vec![memory],
        None => memories(question.kernels.len()),
    };
    let searches = every.len() * question.quantisers.len();
    let mut begun = 0;
    let shared = |memory: &DriveMemory| *memory == DriveMemory::Shared;
    let (of_pixel, of_drives): (Vec<_>, Vec<_>) = every.into_iter().partition(shared);
    let apart = question.thresholds(open)?;
    let mut silent = None;
    for memories in [of_drives, of_pixel] {
        let Some(first) = memories.first() else {
            continue;
        };
        let thresholds = question.thresholds_with(*first, &apart, open)?;
        let floats = question.designs(&thresholds);
        let mut found = Vec::new();
        for to in question.quantisers {
            for memory in &memories {
                begun += 1;
                searching(begun, searches);
                match question.compile(*to, *memory, &floats)? {
                    Ok(program) => found.push(program),
                    Err(refused) => all.refused.push(refused),
                }
            }
        }
        if found.is_empty() {
            continue;
        }
        let description = together::description(*first, &floats)?;
        let programs: Vec<&Compiled> = found.iter().map(|it| &it.every_event).collect();
        let mut scene = open()?;
        let size = scene.size();
        let within = (all.window_us, question.seed, together::CHIPS);
        let shown = together::judge(&programs, &description, within, &mut *scene, &mut seen)?;
        all.frames = shown.frames;
        let seconds = shown.frames.saturating_sub(1) as f64 / fps;
        let mut events = vec![0_u64; thresholds.len()];
        for event in &shown.float.events {
            events[usize::from(event.channel)] += 1;
        }
        let per = |events: u64| events as f64 / (size.pixels() as f64 * seconds).max(1e-9);
        all.rated.push(RatedThresholds {
            memory: if shared(first) { "pixel" } else { "drives" },
            rate: per(shown.float.events.len() as u64),
            rates: events.iter().map(|own| per(*own)).collect(),
            events,
            thresholds: thresholds.clone(),
        });
        if shown.float.events.is_empty() {
            let why = ExplorationError::Silent { thresholds };
            let none = found.iter().map(|it| Refused {
                to: it.to.to_string(),
                memory: Some(together::name(it.memory)),
                why: why.to_string(),
            });
            all.refused.extend(none);
            silent = Some(why);
            continue;
        }
        let sensor = question.sensor(description);
        let judged = shown.programs.iter().zip(&shown.demands);
        for (found, (judged, demand)) in found.into_iter().zip(judged) {
            let candidate = found.judged(question, (&sensor, &thresholds), judged, demand)?;
            all.candidates.push(candidate);
        }
    }
    if all.candidates.is_empty() {
        if let Some(silent) = silent {
            return Err(silent);
        }
        let refused = all.refused.into_iter().map(|it| Untaken(it.to_string()));
        return Err(ExplorationError::Nothing {
            refused: refused.collect(),
        });
    }
    all.choose();
    Ok(all)
}

/// A program that was found, before it has run.
struct Found {
    to: Quantiser,
    memory: DriveMemory,
    kinds: Vec<CellKind>,
    /// What the levels of each kind are to be multiplied by.
    scales: Vec<f64>,
    program: SensorProgram,
    /// With a readout that loses no event, whatever the scene.
    every_event: Compiled,
}

impl Question<'_> {
    fn check(&self) -> Result<(), ExplorationError> {
        let kernels = self.kernels.len();
        let thresholds = match self.aim {
            Aim::Rate(_) => kernels,
            Aim::Thresholds(all) => all.len(),
        };
        let names = self.names.len();
        if kernels == 0 || names != kernels || thresholds != kernels {
            return Err(ExplorationError::Numbers {
                kernels,
                names,
                thresholds,
            });
        }
        Ok(())
    }

    /// The cells with these thresholds, before they are brought to few values.
    fn designs(&self, thresholds: &[f64]) -> Vec<Design<'_>> {
        let search = (self.effort, self.seed);
        Design::each(self.kernels, thresholds, self.device, search)
    }

    /// The thresholds of kinds that each have a memory of their own.
    fn thresholds(&self, open: &Reopen<'_>) -> Result<Vec<f64>, ExplorationError> {
        let rate = match self.aim {
            Aim::Thresholds(all) => return Ok(all.to_vec()),
            Aim::Rate(rate) => rate,
        };
        let starts: Vec<f64> = self.kernels.iter().map(rate::start).collect();
        let start = self.designs(&starts);
        let apart = together::description(DriveMemory::Analogue, &start)?;
        let each = rate / self.kernels.len() as f64;
        let found = match rate::factors(&apart, each, self.seed, open) {
            Err(error @ RateError::Unreachable { .. }) if self.kernels.len() > 1 => {
                return Err(self.unreachable((rate, error), &start, open)?);
            }
            found => found?,
        };
        Ok(starts
            .iter()
            .zip(&found)
            .map(|(start, it)| start * it.factor)
            .collect())
    }

    /// Which kernel does not reach its share of a rate.
    fn unreachable(
        &self,
        (rate, error): (f64, RateError),
        start: &[Design<'_>],
        open: &Reopen<'_>,
    ) -> Result<ExplorationError, ExplorationError> {
        let share = rate / start.len() as f64;
        for (design, name) in start.iter().zip(self.names) {
            let alone = together::description(DriveMemory::Analogue, &[*design])?;
            match rate::factor(&alone, share, self.seed, open) {
                Err(RateError::Unreachable { least, most, .. }) => {
                    return Ok(ExplorationError::Share {
                        rate,
                        share,
                        kernels: start.len(),
                        name: name.clone(),
                        least,
                        most,
                    });
                }
                Err(other) => return Err(other.into()),
                Ok(_) => {}
            }
        }
        Ok(error.into())
    }

    /// The thresholds of the float sensor that programs with this memory stand for, from those
    /// of kinds with a memory each.
    fn thresholds_with(
        &self,
        memory: DriveMemory,
        apart: &[f64],
        open: &Reopen<'_>,
    ) -> Result<Vec<f64>, ExplorationError> {
        let Aim::Rate(rate) = self.aim else {
            return Ok(apart.to_vec());
        };
        if memory != DriveMemory::Shared {
            return Ok(apart.iter().map(|it| four_digits(*it)).collect());
        }
        // An event of any kind renews the memory of the pixel, which all look at: first the shares
        // are made equal, then their sum is the rate.
        let shared = together::description(memory, &self.designs(apart))?;
        let shares = balance::balanced(&shared, rate, self.seed, open)?;
        let level =
            { apart.iter().zip(&shares) }.map(|(threshold, share)| threshold * share.factor);
        let level: Vec<f64> = level.collect();
        let shared = together::description(memory, &self.designs(&level))?;
        let factor = rate::factor(&shared, rate, self.seed, open)?.factor;
        Ok(level.iter().map(|it| four_digits(it * factor)).collect())
    }

    /// All kernels in few values in one program; or why there is none.
    fn compile(
        &self,
        to: Quantiser,
        memory: DriveMemory,
        floats: &[Design<'_>],
    ) -> Result<Result<Found, Refused>, ExplorationError> {
        let refused = |memory: Option<DriveMemory>, why: String| Refused {
            to: to.to_string(),
            memory: memory.map(together::name),
            why,
        };
        let few = match quantise_all(floats, to, self.sum)? {
            Ok(few) => few,
            Err(why) => return Ok(Err(refused(None, why))),
        };
        let named = self.names.iter().zip(floats.iter().zip(&few));
        let kinds = named.map(|(name, (float, few))| {
            let threshold = float.in_levels(few).threshold;
            CellKind {
                name: Some(name.clone()),
                kernel: few.levels.clone(),
                on: threshold,
                off: threshold,
            }
        });
        let kinds: Vec<CellKind> = kinds.collect();
        let search = (self.effort, self.seed);
        let compiled = Compiled::new(self.title, (&kinds, memory), self.device, search);
        let compiled = match compiled {
            Ok(compiled) => compiled,
            Err(error) if error.is_refusal() => {
                return Ok(Err(refused(Some(memory), error.to_string())));
            }
            Err(error) => return Err(error.into()),
        };
        let every_event = compiled.reading(&kinds, EventReadout::BitPlanes(0, u16::MAX))?;
        let program = compiled.program;
        Ok(Ok(Found {
            to,
            memory,
            kinds,
            scales: few.iter().map(|few| few.scale).collect(),
            program,
            every_event,
        }))
    }

    /// The float sensor with names for its kinds.
    fn sensor(&self, mut description: Description) -> Description {
        self.title.clone_into(&mut description.name);
        for (kind, name) in description.channels.iter_mut().zip(self.names) {
            kind.name = Some(name.clone());
        }
        description
    }
}

impl Found {
    fn judged(
        self,
        question: &Question<'_>,
        (sensor, thresholds): (&Description, &[f64]),
        judged: &[Judged],
        demand: &Demand,
    ) -> Result<Candidate, ExplorationError> {
        let device = question.device;
        let slots = Compiled::from_program(question.title, self.program.clone(), device)?;
        let frame = &slots.code.frame;
        let array_us =
            time::array_us(frame, device).unwrap_or([Cost::of(frame, device).array_us; 2]);
        let plans = Scans::new(frame, device).plans(Some(demand), device);
        let plan = choose(&plans).and_then(|at| plans.get(at));
        let readout = plan.map_or_else(|| EventReadout::most_slots(device), EventReadout::from);
        let text = self
            .program
            .text_with(&self.kinds, question.title, device, readout);
        let compiled = Compiled::from_text(question.title, self.program.clone(), &text, device)?;
        let stored_words = compiled.stored.0;
        let kinds = judged.iter().enumerate().map(|(i, judged)| {
            let threshold = thresholds[i];
            let scales = &self.program.scales;
            let scale = scales.get(i).copied().unwrap_or(self.program.scale());
            Kind {
                name: question.names[i].clone(),
                threshold,
                threshold_lsb: threshold / self.scales[i] * scale,
                exact: judged.exact,
                silicon: judged.silicon,
            }
        });
        let kinds: Vec<Kind> = kinds.collect();
        let kept: Vec<f64> = { kinds.iter() }
            .filter_map(|kind| kind.silicon.kept)
            .collect();
        let filters = self.program.each_filter().iter();
        let filters: Vec<u32> = filters.map(|filter| filter.prescale).collect();
        Ok(Candidate {
            to: self.to,
            memory: together::name(self.memory),
            remembers: self.memory,
            kept: (!kept.is_empty()).then(|| kept.iter().sum::<f64>() / kept.len() as f64),
            kept_kinds: kept.len(),
            least_kept: kept.iter().copied().min_by(f64::total_cmp),
            words: compiled.cost.words.0,
            stored_words,
            array_us,
            halvings: filters,
            readout: plan.map_or(Way::AsProgrammed, |plan| plan.way),
            frames_s: plan.map_or([0.0; 2], |plan| plan.frames_s(array_us)),
            carried: crate::compile::carried(self.memory, device, (kinds.len(), stored_words)),
            kinds,
            on_front: false,
            sensor: sensor.clone(),
            program: blessed(&text, &compiled)?,
        })
    }
}

/// A program's text with the words that it takes, which `asm` holds it to.
fn blessed(text: &str, compiled: &Compiled) -> Result<String, ExplorationError> {
    let words = |steps: &[Step]| Cost::of(steps, &compiled.device).words.0;
    let expectation = Expectation {
        words: Some(ExpectedWords {
            init: words(&compiled.code.init),
            frame: words(&compiled.code.frame),
        }),
        ..Expectation::default()
    };
    let program = Program::parse(&compiled.title, text)?;
    // Numbers of words can be written as TOML.
    Ok(program
        .blessed(&expectation)
        .unwrap_or_else(|_| text.to_owned()))
}
