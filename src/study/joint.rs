//! Several kernels in one program, for one quantiser: what that costs, and what each kind keeps of the
//! float sensor.

use serde::Serialize;

use super::{
    StudyError,
    design::{Design, quantise_all},
    equivalent::Likeness,
    together::{self, Together},
};
use crate::{
    compile::DriveMemory,
    isa::Figure,
    kernel::quantise::{Quantiser, Sum},
    program::readout::{Demand, Scans},
    rig::guard::{Guard, Warning},
    scene::Scene,
    unit::Micros,
};

/// All kernels in one program, for one quantiser.
#[derive(Debug, Serialize)]
pub struct Joint {
    /// The quantiser.
    pub to: String,
    /// What came of it.
    #[serde(flatten)]
    pub outcome: JointOutcome,
}

/// A program of all kernels, or why there is none.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JointOutcome {
    /// It runs.
    OnChip(Box<JointOnChip>),
    /// A kernel is not to be had in these values, or no memory holds all of them: why.
    Refused(Vec<String>),
}

/// What a program of all kernels costs and says.
#[derive(Debug, Serialize)]
pub struct JointOnChip {
    /// What it remembers, and where.
    pub memory: String,
    /// The float sensor that it is held to.
    pub against: &'static str,
    /// Words of the filters.
    pub filter_words: u64,
    /// Words of a frame.
    pub words: u64,
    /// Words that the chip stores.
    pub stored_words: u64,
    /// Words that it has room for.
    pub store: u64,
    /// Time of a frame's words on the array, us.
    pub array_us: f64,
    /// Frames a second, with all slots of the readout.
    pub frames_per_s: f64,
    /// Frames a second without the readout.
    pub frames_per_s_of_compute: f64,
    /// How many kinds like these the chip carries.
    pub carried: usize,
    /// What each kind keeps.
    pub kinds: Vec<JointKind>,
}

/// One kind of a program.
#[derive(Debug, Serialize)]
pub struct JointKind {
    /// What it is called.
    pub name: String,
    /// Without errors of the chip.
    pub exact: Likeness,
    /// With them.
    pub silicon: Likeness,
}

impl Joint {
    /// Quantises the kernels of these designs, compiles all of them into one program and runs it
    /// beside the float sensor; what there is to be warned of goes to `guard`. `names` has one for
    /// each design, and `seen` is called for each frame. The program has `memory`, or the first in which
    /// the chip holds it.
    ///
    /// # Errors
    /// When a sensor cannot be made, or scene or sensor cannot go on; not where the chip refuses.
    pub fn new(
        names: &[String],
        floats: &[Design<'_>],
        (to, sum, memory): (Quantiser, Sum, Option<DriveMemory>),
        (within, scene): (Micros, &mut dyn Scene),
        guard: &mut Guard,
        seen: impl FnMut(),
    ) -> Result<Self, StudyError> {
        let outcome = match quantise_all(floats, to, sum)? {
            Err(why) => JointOutcome::Refused(vec![why]),
            Ok(few) => {
                let levels: Vec<Design<'_>> = { floats.iter().zip(&few) }
                    .map(|(float, few)| float.in_levels(few))
                    .collect();
                match Together::compile(&levels, "together", memory)? {
                    Err(why) => JointOutcome::Refused(why),
                    Ok(program) => {
                        let kinds =
                            run(&program, (names, floats), (within, scene), to, guard, seen)?;
                        JointOutcome::OnChip(Box::new(JointOnChip::new(&program, kinds)))
                    }
                }
            }
        };
        Ok(Self {
            to: to.to_string(),
            outcome,
        })
    }
}

impl JointOnChip {
    fn new(program: &Together, kinds: Vec<JointKind>) -> Self {
        let compiled = &program.compiled;
        let (cost, device) = (compiled.cost, &compiled.device);
        Self {
            memory: together::name(program.memory),
            against: program.against(),
            filter_words: compiled.program.filter.word_count(device),
            words: cost.words.0,
            stored_words: compiled.stored.0,
            store: device.value(Figure::Store) as u64,
            array_us: cost.array_us,
            frames_per_s: cost.frames_per_second(),
            frames_per_s_of_compute: 1e6 / cost.array_us,
            carried: program.carried(),
            kinds,
        }
    }
}

/// Runs a program beside the float sensor; what each kind keeps.
fn run(
    program: &Together,
    (names, floats): (&[String], &[Design<'_>]),
    (within, scene): (Micros, &mut dyn Scene),
    to: Quantiser,
    guard: &mut Guard,
    mut seen: impl FnMut(),
) -> Result<Vec<JointKind>, StudyError> {
    // The frames of this run alone.
    let mut own = Guard::new();
    let seed = floats.first().map_or(0, |float| float.seed);
    let (judged, _, frames) = program.judge(floats, (within, seed), scene, |frame| {
        own.frame(frame);
        seen();
    })?;
    let compiled = &program.compiled;
    let slots = Scans::new(&compiled.code.frame, &compiled.device).slots;
    let mut kinds = Vec::new();
    for (name, kind) in names.iter().zip(judged) {
        let subject = format!("{to} silicon, {name}");
        own.packet(&subject, &kind.packet);
        let all = kind.packet.events.len() as u64;
        // A share of whole events.
        let lost = Demand::new(&kind.packet, frames).lost(slots) * all as f64;
        if lost > 0.0 {
            own.warn(Warning::own_slots(&subject, lost.round() as u64, all));
        }
        own.extend(kind.exact.warning(name));
        kinds.push(JointKind {
            name: name.clone(),
            exact: kind.exact,
            silicon: kind.silicon,
        });
    }
    guard.extend(own.warnings());
    Ok(kinds)
}
