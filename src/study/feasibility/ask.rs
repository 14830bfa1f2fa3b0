//! Answering a question: the sensors run, and all parts of the answer are put together.

use super::{
    Assumption, ChipSummary, Chosen, Estimate, Feasibility, FeasibilityError, Fit, KernelSummary,
    Question, SceneSummary, Snapshot, Streams,
    chip::OnChip,
    chips::{OverChips, Trial},
    choice::Few,
    named::{FigureSummary, Named},
    power::{Link, Load, Power},
    runs::{MEMORY, Runs},
    time::{self, FrameWords},
    verdict::Verdict,
};
use crate::{
    array::Arithmetic,
    compare::window,
    event::Packet,
    event::readout::{Ideal, Readout},
    isa::{Evidence, Figure},
    kernel::{
        Kernel,
        quantise::{Quantised, Quantiser},
    },
    limit::STORE_WORDS,
    mesh::{self, Fitting},
    plane::Size,
    program::readout::Demand,
    rig::guard::Warning,
    scene::{Frame, Reopen, Scene},
    study::{
        design::{Compiled, Design},
        equivalent::Ladder,
        waterfall::{self, Fall, Rates, Waterfall, WaterfallError},
    },
};

/// The ridge of the mesh fits: added to the squared relative error for each squared gain.
const RIDGE: f64 = 1e-4;

/// Asks the question of a scene that can be opened again: it is watched once for the number of
/// crossings, twice for the table and twice for the sensors, for the waterfall, by the drawn chips
/// some at a time, and up to the moment of the pictures. `seen` is called after each frame of all
/// but the last.
pub(super) fn ask_one(
    question: &Question<'_>,
    open: &Reopen<'_>,
    seen: impl FnMut(&Frame),
) -> Result<(Feasibility, Snapshot), FeasibilityError> {
    waterfall::check_crossings(&[question.design()], &mut *open()?)?;
    answered(question, open, seen)
}

/// The same of a threshold that is known to be crossed seldom enough.
pub(super) fn answered(
    question: &Question<'_>,
    open: &Reopen<'_>,
    mut seen: impl FnMut(&Frame),
) -> Result<(Feasibility, Snapshot), FeasibilityError> {
    let design = question.design();
    design.description(MEMORY)?;
    let mut few = question.first(&design)?;
    let mut table = question.table(open, &mut seen)?;
    if question.to.is_none()
        && let Some(best) = Question::best(&table.rows)
    {
        few = Few::new(best, question, &design)?;
    }
    let Few { to, quantised } = few;
    let (ran, judged) = (table.take(to), table.judged(to));
    let (table, floats) = (table.rows, table.floats);
    let compiled = { ran.as_ref() }.map(|ran| ran.compiled.clone());
    let compiled = compiled.map_err(String::clone);
    let program = compiled.as_ref().ok();

    let mut scene = open()?;
    let ladder = question.ladder(&floats, &*scene)?;
    let float = ladder.reference().clone();
    let (runs, frames) = question.watch(&design, float, ran.ok(), &mut *scene, &mut seen)?;
    let scene = SceneSummary::new(question.scene, &*scene, frames, &runs.float);
    let by = (&design, &ladder);
    let streams = runs.streams(question, by, judged.as_ref(), &mut *open()?, &mut seen)?;
    let over_chips = match (program, &runs.silicon) {
        (Some(program), Some(nominal)) => Trial {
            question,
            program,
            words: FrameWords::new(&program.code.frame, question.device)?,
            floats: &floats,
            nominal,
            frames,
            fps: scene.fps,
        }
        .run(open, &mut seen)?,
        _ => OverChips::without_program(question.chips),
    };
    let (waterfall, over_rates) = match program {
        Some(program) => {
            let found = (quantised.clone(), program.clone());
            // The readout that is told of loses none.
            let readout = match runs.lost {
                [0, 0] => question.readout,
                _ => Readout::Ideal(Ideal),
            };
            question.waterfall((&design, to), found, readout, open, &mut seen)?
        }
        None => (None, None),
    };
    let snapshot = Snapshot::new(&runs.float, runs.silicon.as_ref(), &mut *open()?)?;
    let busy = { runs.silicon.as_ref() }
        .map_or_else(Demand::default, |packet| Demand::new(packet, frames));
    let fit = match &compiled {
        Ok(compiled) => {
            let threshold = question.threshold / quantised.scale * compiled.program.scale();
            let time = time::time(question, compiled, &busy, (scene.height, scene.fps))?;
            let chip = OnChip::new(compiled, question.device, threshold, time);
            Fit::OnChip(Box::new(chip))
        }
        Err(why) => Fit::Refused(why.clone()),
    };
    let each = program.map_or_else(Vec::new, |it| Named::words_of(&it.code.frame));
    let needed = question.room_needed(&design.in_levels(&quantised), program, &scene);
    let link = question.link_of(&streams, &scene);
    let power = match &fit {
        Fit::OnChip(chip) => Some(question.power_of(chip, &streams, &scene, &link, &each)),
        Fit::Refused(_) => None,
    };
    let mut feasibility = Feasibility {
        amacrine: env!("CARGO_PKG_VERSION"),
        command: question.command.to_owned(),
        seed: question.seed,
        verdict: Verdict::default(),
        kernel: KernelSummary::new(question.name, question.kernel),
        threshold: question.threshold,
        chip: ChipSummary::new(question.device, needed),
        chosen: Chosen {
            to: to.to_string(),
            asked_for: question.to.is_some(),
            relative_error: quantised.relative_error(question.kernel),
            scale: quantised.scale,
            levels: KernelSummary::new(&to.to_string(), &quantised.levels),
        },
        fit,
        over_chips,
        figures: FigureSummary::all(question.device, &each),
        within_us: question.within,
        power,
        link,
        streams,
        waterfall,
        over_rates,
        quantisation: table.into_iter().map(|(_, row)| row).collect(),
        mesh: meshes(question.kernel),
        assumptions: Assumption::all(question, &scene),
        warnings: warnings(question, &to.to_string(), &quantised, &runs, &ladder),
        scene,
    };
    feasibility.verdict = Verdict::new(&feasibility);
    Ok((feasibility, snapshot))
}

/// What is to be known of the kernel's few values, of the runs and of the window.
fn warnings(
    question: &Question<'_>,
    to: &str,
    quantised: &Quantised,
    runs: &Runs,
    ladder: &Ladder,
) -> Vec<Warning> {
    let erased = { quantised.erasures(question.kernel).into_iter() }
        .map(|erasure| Warning::erased(to, erasure));
    let events = runs.float.events.len() as u64;
    let window = (events > 0).then(|| Warning::window(question.within, ladder.floor()));
    erased
        .chain(runs.warnings.iter().cloned())
        .chain(window.flatten())
        .chain(Warning::few_events(events))
        .collect()
}

/// None where the float sensor has no event.
fn heard<T>(answer: Result<T, WaterfallError>) -> Result<Option<T>, WaterfallError> {
    match answer {
        Err(WaterfallError::Silent { .. }) => Ok(None),
        answer => answer.map(Some),
    }
}

/// The kernel fitted by one resistive grid and by two, or by none; nothing for a kernel of zeros.
fn meshes(kernel: &Kernel) -> Vec<mesh::Fit> {
    let fit = |sheets| {
        let how = Fitting {
            sheets,
            anisotropic: false,
            ridge: RIDGE,
        };
        mesh::fit(kernel, how).ok()
    };
    let mut fits: Vec<_> = (1..=2).filter_map(fit).collect();
    // Where no sheet is needed both are the same.
    fits.dedup_by(|b, a| a.sheets.is_empty() && b.sheets.is_empty());
    fits
}

impl Question<'_> {
    pub(super) fn design(&self) -> Design<'_> {
        Design {
            kernel: self.kernel,
            threshold: self.threshold,
            device: self.device,
            effort: self.effort,
            seed: self.seed,
        }
    }

    /// Where the events went: step by step, and over frame rate; none where the float sensor has
    /// none.
    fn waterfall(
        &self,
        (design, to): (&Design<'_>, Quantiser),
        (quantised, compiled): (Quantised, Compiled),
        readout: Readout,
        open: &Reopen<'_>,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<(Option<Waterfall>, Option<Rates>), FeasibilityError> {
        let asked = waterfall::Question {
            design: *design,
            to,
            sum: self.sum,
            arithmetic: Arithmetic::Silicon { seed: self.seed },
            readout,
            within: self.within,
        };
        let fall = Fall::of_program(asked, quantised, compiled);
        let mut scene = open()?;
        // A window that is not the headline's was asked for, at every rate.
        let is_usual = self.within == window::headline(scene.fps());
        let steps = heard(fall.steps(&mut *scene, seen))?;
        drop(scene);
        let usual = waterfall::Choice::default();
        let choice = waterfall::Choice {
            chips: self.chips.min(usual.chips),
            within: (!is_usual).then_some(self.within),
            ..usual
        };
        let rates = heard(fall.rates(&choice, open, &|| ()))?;
        Ok((steps, rates))
    }

    /// What the sensors are judged by, of the float sensors' packets.
    fn ladder(&self, floats: &[Packet], scene: &dyn Scene) -> Result<Ladder, FeasibilityError> {
        let silent = Packet::new(scene.size(), 1);
        let (reference, rungs) = match floats {
            [reference, rungs @ ..] => (reference, rungs),
            [] => (&silent, floats),
        };
        let (within, fps) = (self.within, scene.fps());
        Ok(Ladder::new(
            reference.clone(),
            rungs,
            within,
            fps,
            self.seed,
        )?)
    }

    /// The rows, columns and words of the store that a program of a design needs; none where there
    /// is no program however large the store.
    fn room_needed(
        &self,
        design: &Design<'_>,
        program: Option<&Compiled>,
        scene: &SceneSummary,
    ) -> [Option<u64>; 3] {
        let stored = match program {
            Some(compiled) => Some(compiled.stored.0),
            None => self.stored_in_any(design),
        };
        [Some(scene.height as u64), Some(scene.width as u64), stored]
    }

    /// The words of a program that the chip refuses, where a larger store takes it.
    fn stored_in_any(&self, design: &Design<'_>) -> Option<u64> {
        let any = { self.device.clone() }.what_if(Figure::Store, STORE_WORDS as f64);
        let device = any.ok()?;
        let compiled = Design {
            device: &device,
            ..*design
        }
        .compile("quantised");
        compiled.ok().map(|compiled| compiled.stored.0)
    }

    fn power_of(
        &self,
        chip: &OnChip,
        streams: &Streams,
        scene: &SceneSummary,
        link: &Link,
        each: &[Named],
    ) -> Power {
        let silicon = streams.silicon.as_ref();
        let load = Load {
            words: chip.frame_words as f64,
            each,
            time: &chip.time,
            fps: scene.fps,
            events_s: silicon
                .filter(|_| scene.seconds > 0.0)
                .map(|stream| stream.events as f64 / scene.seconds),
            kbit_s: silicon.and_then(|stream| stream.mean_kbit_s),
            bit: &link.bit,
        };
        Power::new(&load, self.device)
    }

    fn link_of(&self, streams: &Streams, scene: &SceneSummary) -> Link {
        let bit = Estimate::between(
            self.link,
            "pJ",
            Evidence::Guess,
            "given with the question; nobody states it for a chip that does not exist yet",
        );
        let mut sent = vec![
            ("the plain DVS", &streams.dvs),
            ("the float sensor", &streams.float),
        ];
        sent.extend(streams.silicon.as_ref().map(|s| ("the chip", s)));
        Link::new(bit, &sent, Size::new(scene.height, scene.width), scene.fps)
    }
}
