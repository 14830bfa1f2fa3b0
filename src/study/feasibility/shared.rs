//! One program of several kernels: whether there is one, what it takes, and what each kernel
//! keeps in it.

use super::{
    Estimate, Feasibility, FeasibilityError, Question,
    chip::{HalvedFor, registers},
    time::{self, Time},
};
use crate::{
    compile::like_these,
    isa::Figure,
    kernel::quantise::{Quantised, Quantiser},
    program::readout::Demand,
    rig::guard::Warning,
    scene::{Frame, Scene},
    study::{
        design::Design,
        equivalent::Likeness,
        quantisation::{Headline, Outcome},
        together::{Together, name},
    },
    unit::counted,
};

/// All kernels in one program.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Shared {
    /// In a few words.
    pub headline: String,
    /// In sentences.
    pub says: String,
    /// The program, or why there is none.
    pub fit: SharedFit,
    /// A row for each kernel.
    pub kinds: Vec<SharedKind>,
}

/// A program of all kernels, or none.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SharedFit {
    /// It runs.
    OnChip(Box<SharedProgram>),
    /// What is short, for each way to remember the drives that was tried; and where one was asked for,
    /// or a sensor file says it, which other one would do.
    Refused(Vec<String>),
}

/// What the program takes of the chip.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SharedProgram {
    /// Where the drives of the last events are kept.
    pub memory: String,
    /// What its kinds are judged against.
    pub against: String,
    /// How many kinds like these the chip carries in that way.
    pub carried: usize,
    /// Instruction words of the filters, which share what they can.
    pub filter_words: u64,
    /// Instruction words of a frame.
    pub frame_words: u64,
    /// Words of a frame of each kernel's own program, added up; none where one has none.
    pub frame_words_apart: Option<u64>,
    /// Words that the program takes of the store, the first frame's included.
    pub stored_words: u64,
    /// Words that the store holds.
    pub store: Estimate,
    /// Analogue registers that the whole program uses.
    pub registers: usize,
    /// Analogue registers that a pixel has, NEWS left out.
    pub registers_of: usize,
    /// The most halvings of any kind before anything else, a bit each.
    pub prescale_bits: u32,
    /// Those of each filter: one for each kind where they share a memory.
    pub halvings: Vec<u32>,
    /// What they are for.
    pub halved_for: HalvedFor,
    /// Whether all sums stay in range, the chip's transfer errors included.
    pub holds: bool,
    /// Time.
    pub time: Time,
}

/// One kernel in the program of all.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SharedKind {
    /// What the kernel is called.
    pub name: String,
    /// Its few values.
    pub to: String,
    /// Events of its own float sensor.
    #[serde(skip)]
    pub float_events: u64,
    /// What it keeps of them, with the chip's errors.
    #[serde(flatten)]
    pub headline: Option<Headline>,
    /// What it keeps in a program of its own.
    pub kept_apart: Option<f64>,
    /// Without errors of the chip.
    pub exact: Option<Likeness>,
    /// With them.
    pub silicon: Option<Likeness>,
}

impl Shared {
    /// Of questions that were answered, in the few values that were chosen for each; `of` is the
    /// one whose chip, exposure, effort and seed count.
    pub(super) fn new(
        of: &Question<'_>,
        questions: &[Question<'_>],
        answers: &[Feasibility],
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Self, FeasibilityError> {
        let mut quantised = Vec::new();
        for (question, answer) in questions.iter().zip(answers) {
            let mut asked = question.candidates.iter().chain(&question.to);
            // Ternary is what is taken where there is no candidate.
            let to = asked.find(|to| to.to_string() == answer.chosen.to);
            let to = to.copied().unwrap_or(Quantiser::TERNARY);
            quantised.push(question.design().quantise(to, question.sum)?);
        }
        let designs = levels(questions, &quantised);
        let found = Together::compile(&designs, "together", of.memory)?;
        let mut kinds: Vec<_> = answers.iter().map(SharedKind::new).collect();
        let fit = match found {
            Err(refused) => SharedFit::Refused(refused),
            Ok(together) => {
                let (rows, fps) = (scene.size().height, scene.fps());
                let busy = judge(of, questions, &together, &mut kinds, scene, seen)?;
                let time = time::time(of, &together.compiled, &busy, (rows, fps))?;
                let program = SharedProgram::new(&together, answers, time);
                SharedFit::OnChip(Box::new(program))
            }
        };
        let (headline, says) = verdict(&fit, &kinds, answers);
        Ok(Self {
            headline,
            says,
            fit,
            kinds,
        })
    }
}

/// The cells in their few values.
fn levels<'a>(questions: &'a [Question<'_>], quantised: &'a [Quantised]) -> Vec<Design<'a>> {
    let pairs = questions.iter().zip(quantised);
    pairs
        .map(|(question, quantised)| question.design().in_levels(quantised))
        .collect()
}

/// Shows the scene to the float sensor that the program stands for and to the program, and judges
/// every kernel; what there is to read, of all of them, with the chip's errors.
fn judge(
    of: &Question<'_>,
    questions: &[Question<'_>],
    together: &Together,
    kinds: &mut [SharedKind],
    scene: &mut dyn Scene,
    seen: &mut dyn FnMut(&Frame),
) -> Result<Demand, FeasibilityError> {
    let floats: Vec<Design<'_>> = questions.iter().map(Question::design).collect();
    let (judged, busy, _) = together.judge(&floats, (of.within, of.seed), scene, seen)?;
    for (kind, judged) in kinds.iter_mut().zip(judged) {
        kind.exact = Some(judged.exact);
        kind.headline = Some(judged.silicon.into());
        kind.silicon = Some(judged.silicon);
    }
    Ok(busy)
}

impl SharedKind {
    /// Of a kernel that was answered on its own.
    fn new(answer: &Feasibility) -> Self {
        let chosen = { answer.quantisation.iter() }.find(|row| row.to == answer.chosen.to);
        Self {
            name: answer.kernel.name.clone(),
            to: answer.chosen.to.clone(),
            float_events: answer.streams.float.events,
            headline: None,
            kept_apart: chosen.and_then(|row| match &row.outcome {
                Outcome::OnChip(chip) => chip.silicon.kept,
                Outcome::Refused(_) => None,
            }),
            exact: None,
            silicon: None,
        }
    }
}

impl SharedProgram {
    fn new(together: &Together, answers: &[Feasibility], time: Time) -> Self {
        let compiled = &together.compiled;
        let (device, code) = (&compiled.device, &compiled.code);
        let filter = &compiled.program.filter;
        let apart = answers.iter().map(|answer| match &answer.fit {
            super::Fit::OnChip(chip) => Some(chip.frame_words),
            super::Fit::Refused(_) => None,
        });
        Self {
            memory: name(together.memory),
            against: together.against().to_owned(),
            carried: together.carried(),
            filter_words: filter.word_count(device),
            frame_words: compiled.cost.words.0,
            frame_words_apart: apart.sum(),
            stored_words: compiled.stored.0,
            store: Estimate::figure(device, Figure::Store),
            registers: registers(code, device),
            registers_of: device.registers().analog.len() - 1,
            prescale_bits: filter.prescale,
            halvings: { compiled.program.each_filter().iter() }
                .map(|filter| filter.prescale)
                .collect(),
            halved_for: HalvedFor::of(&compiled.program),
            holds: filter.holds,
            time,
        }
    }
}

/// What one program does to a kernel's kept share is told from this loss on.
const LOSS: f64 = 0.05;

fn verdict(fit: &SharedFit, kinds: &[SharedKind], answers: &[Feasibility]) -> (String, String) {
    let count = kinds.len();
    let program = match fit {
        SharedFit::Refused(why) if count == 1 => {
            let says = format!(
                "There is no such program of the kernel. {}.",
                why.join(". ")
            );
            return ("Does not fit".to_owned(), says);
        }
        SharedFit::Refused(why) => {
            return (
                "Do not fit together".to_owned(),
                format!(
                    "There is no program of all {count} kernels. {}. Each kernel could have a chip, or a frame, of its own.",
                    why.join(". ")
                ),
            );
        }
        SharedFit::OnChip(program) => program,
    };
    let fps = answers.first().map_or(0.0, |answer| answer.scene.fps);
    let ceiling = &program.time.ceiling;
    let headline = match (ceiling.high < fps, ceiling.low < fps, count) {
        (true, _, 1) => "Fits, but is too slow",
        (_, true, 1) => "Fits, but may be too slow",
        (_, _, 1) => "Fits",
        (true, ..) => "Fit together, but are too slow",
        (_, true, _) => "Fit together, but may be too slow",
        _ => "Fit together",
    };
    let loss = loss(kinds);
    (
        headline.to_owned(),
        format!(
            "One program has {}, with {}: it takes {} of the {} in the store, uses {} of {} analogue registers, and reaches at most {ceiling} for the {fps} that the scene asks for. The chip carries {} in that way. {} judged against {}. {loss}",
            if count == 1 {
                "the kernel".to_owned()
            } else {
                format!("all {count} kernels")
            },
            program.memory,
            counted(program.stored_words, "word"),
            program.store.low,
            program.registers,
            program.registers_of,
            like_these(program.carried, if count == 1 { "this" } else { "these" }),
            if count == 1 {
                "It is"
            } else {
                "Together they are"
            },
            program.against,
        ),
    )
}

/// Which kernels one program costs something, as far as the scene and programs of their own tell.
fn loss(kinds: &[SharedKind]) -> String {
    let is_judged = |kind: &SharedKind| {
        kind.silicon.is_some_and(|it| it.is_judged())
            && Warning::few_events(kind.float_events).is_none()
    };
    let compared = |kind: &SharedKind| {
        let together = kind.headline?.kept.filter(|_| is_judged(kind))?;
        Some((together, kind.kept_apart?))
    };
    let loses =
        |kind: &SharedKind| compared(kind).is_some_and(|(together, apart)| together < apart - LOSS);
    let named = |is: &dyn Fn(&SharedKind) -> bool| -> Vec<&str> {
        let those = kinds.iter().filter(|kind| is(kind));
        those.map(|kind| kind.name.as_str()).collect()
    };
    // The other program of a kernel alone is one with another memory.
    let other = match kinds {
        [_] => "with a memory in an analogue register",
        _ => "in a program of its own",
    };
    let mut says = Vec::new();
    let unjudged = named(&|kind| !is_judged(kind));
    if !unjudged.is_empty() {
        let names = unjudged.join(", ");
        says.push(format!("{names} cannot be judged on this scene."));
    }
    let lone = named(&|kind| is_judged(kind) && kind.kept_apart.is_none());
    if !lone.is_empty() {
        let names = lone.join(", ");
        says.push(match kinds {
            [_] => format!("There is no program {other} to compare it with."),
            _ => format!("Without a program of their own to compare with: {names}."),
        });
    }
    let (losing, all) = (named(&loses), named(&|kind| compared(kind).is_some()));
    match (kinds, &losing[..]) {
        _ if all.is_empty() => {}
        ([_], []) => says.push(format!("It does not keep clearly less than {other}.")),
        ([_], _) => says.push(format!("It keeps clearly less than {other}.")),
        (_, []) if all.len() == kinds.len() => {
            says.push(format!("None of them keeps clearly less than {other}."));
        }
        (_, []) => {
            let names = all.join(", ");
            says.push(format!(
                "These do not keep clearly less than {other}: {names}."
            ));
        }
        (_, losing) => says.push(format!(
            "These keep clearly less than in a program of their own: {}.",
            losing.join(", ")
        )),
    }
    says.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::Micros;

    fn kind(name: &str, floor: f64, kept: f64, apart: Option<f64>) -> SharedKind {
        let silicon = Likeness {
            kept: Some(kept),
            window_us: Micros(100),
            fps: 10.0,
            f1: 0.5,
            floor,
            threshold_equivalent_percent: None,
            threshold_equivalent_is_least: false,
            event_ratio: Some(1.0),
            tuned: None,
        };
        SharedKind {
            name: name.to_owned(),
            to: "ternary".to_owned(),
            float_events: 1000,
            headline: Some(silicon.into()),
            kept_apart: apart,
            exact: None,
            silicon: Some(silicon),
        }
    }

    #[test]
    fn a_loss_of_a_few_events_is_none() {
        let few = SharedKind {
            float_events: 4,
            ..kind("few", 0.1, -0.2, Some(0.4))
        };
        let kinds = [few, kind("fine", 0.1, 0.8, Some(0.8))];
        let told = loss(&kinds);
        assert_eq!(
            told,
            "few cannot be judged on this scene. These do not keep clearly less than in a program of its own: fine."
        );
    }

    #[test]
    fn a_loss_is_told_only_of_what_can_be_judged_and_compared() {
        let (fine, loses) = (
            kind("fine", 0.1, 0.8, Some(0.8)),
            kind("loses", 0.1, 0.2, Some(0.8)),
        );
        let (blind, lone) = (
            kind("blind", 1.0, 1.0, Some(1.0)),
            kind("lone", 0.1, 0.8, None),
        );
        for (kinds, told) in [
            (
                &[fine.clone(), fine.clone()][..],
                "None of them keeps clearly less than in a program of its own.",
            ),
            (
                &[fine.clone(), loses],
                "These keep clearly less than in a program of their own: loses.",
            ),
            (
                &[blind.clone(), fine.clone()],
                "blind cannot be judged on this scene. These do not keep clearly less than in a program of its own: fine.",
            ),
            (
                std::slice::from_ref(&blind),
                "blind cannot be judged on this scene.",
            ),
            (
                &[lone.clone(), blind.clone()],
                "blind cannot be judged on this scene. Without a program of their own to compare with: lone.",
            ),
            (
                &[lone],
                "There is no program with a memory in an analogue register to compare it with.",
            ),
            (
                &[fine],
                "It does not keep clearly less than with a memory in an analogue register.",
            ),
        ] {
            assert_eq!(loss(kinds), told);
        }
    }
}
