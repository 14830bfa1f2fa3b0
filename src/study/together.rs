//! Several designs in one program: the memory that holds them on a chip, and what each kind keeps
//! of the float sensor that the program stands for.
//!
//! A program whose kinds have a memory each stands for float sensors of `filtered-snap`; one with a
//! memory of the pixel for all of them stands for one float sensor of `raw-snap`, shared.

use super::{
    StudyError,
    design::{Compiled, Design, DesignError, float},
    equivalent::{Ladder, Likeness, RUNGS, at_part},
    expanded::Expanded,
};
use crate::{
    array::{Arithmetic, Array},
    compile::{DriveMemory, Effort, EventReadout, MEMORY_BITS, carried},
    event::{Event, Packet},
    number::Format,
    program::readout::Demand,
    reference::{Description, MemoryRule},
    rig,
    scene::{Frame, Scene},
    sensor::Sensor,
    unit::Micros,
};

/// Several designs in one program.
#[derive(Clone, Debug)]
pub struct Together {
    /// What it remembers, and where.
    pub memory: DriveMemory,
    /// The program.
    pub compiled: Compiled,
    /// The same, with a readout that loses no event.
    every_event: Compiled,
}

/// One kind of a program, judged by its own part of the float sensor's events.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Without errors of the chip.
    pub exact: Likeness,
    /// With them.
    pub silicon: Likeness,
    /// Its events with them.
    pub packet: Packet,
}

/// The ways to remember so many drives, the better one first.
#[must_use]
pub fn memories(kinds: usize) -> Vec<DriveMemory> {
    let bits = u8::try_from(MEMORY_BITS / kinds.max(1)).unwrap_or(0);
    let in_bits = (bits > 0).then_some(DriveMemory::Bits(bits));
    [DriveMemory::Analogue, DriveMemory::Shared]
        .into_iter()
        .chain(in_bits)
        .collect()
}

/// A way to remember, in words.
#[must_use]
pub fn name(memory: DriveMemory) -> String {
    match memory {
        DriveMemory::Analogue => "memories in analogue registers".to_owned(),
        DriveMemory::Shared => "one memory of the pixel for all kinds".to_owned(),
        DriveMemory::Bits(bits) => {
            format!("memories of {} each", crate::unit::counted(bits, "bit"))
        }
    }
}

/// The float sensor of several cells that a program with this memory stands for.
///
/// # Errors
/// When a threshold is not positive, or there is no cell.
pub fn description(memory: DriveMemory, floats: &[Design<'_>]) -> Result<Description, DesignError> {
    let shared = memory == DriveMemory::Shared;
    let rule = if shared {
        MemoryRule::RawSnap
    } else {
        MemoryRule::FilteredSnap
    };
    let mut all: Option<Description> = None;
    for design in floats {
        let own = design.description(rule)?;
        match &mut all {
            None => all = Some(Description { shared, ..own }),
            Some(all) => all.channels.extend(own.channels),
        }
    }
    all.ok_or(DesignError::Threshold(0.0))
}

impl Together {
    /// Compiles designs in levels with this memory, or with the first that the chip holds them in;
    /// else what each memory is short of, and where one was asked for, which other one would do.
    ///
    /// # Errors
    /// When a threshold is not positive.
    pub fn compile(
        levels: &[Design<'_>],
        title: &str,
        memory: Option<DriveMemory>,
    ) -> Result<Result<Self, Vec<String>>, DesignError> {
        let Some((first, others)) = levels.split_first() else {
            return Ok(Err(Vec::new()));
        };
        let mut refused = Vec::new();
        let tried = memory.map_or_else(|| memories(levels.len()), |memory| vec![memory]);
        for memory in tried {
            match first.compile_with(others, memory, title) {
                Ok(compiled) => return Self::of(levels, memory, compiled).map(Ok),
                Err(error) if error.is_refusal() => {
                    refused.push(format!("{}: {error}", name(memory)));
                }
                Err(error) => return Err(error),
            }
        }
        if let Some(memory) = memory {
            refused.extend(other_memory(first, others, memory).map(advice));
        }
        Ok(Err(refused))
    }

    fn of(
        levels: &[Design<'_>],
        memory: DriveMemory,
        compiled: Compiled,
    ) -> Result<Self, DesignError> {
        let kinds = levels.iter().map(Design::kind);
        let kinds: Vec<_> = kinds.collect::<Result<_, _>>()?;
        let every_event = match compiled.reading(&kinds, EventReadout::BitPlanes(0, u16::MAX)) {
            // A few words more than the chip stores.
            Err(error) if error.is_refusal() => compiled.clone(),
            read => read?,
        };
        Ok(Self {
            memory,
            compiled,
            every_event,
        })
    }

    /// Shows the scene to the float sensors and to the program, and judges every kind by all of its
    /// events, before the readout. Also what the chip's events ask of a readout, all kinds together, and
    /// the number of frames.
    ///
    /// # Errors
    /// When a sensor cannot be made, or scene or sensor cannot go on.
    pub fn judge(
        &self,
        floats: &[Design<'_>],
        (within, seed): (Micros, u64),
        scene: &mut dyn Scene,
        seen: impl FnMut(&Frame),
    ) -> Result<(Vec<Judged>, Demand, u64), StudyError> {
        let description = description(self.memory, floats)?;
        let how = (within, seed, 1);
        let shown = judge(&[&self.every_event], &description, how, scene, seen)?;
        let judged = shown.programs.into_iter().next().unwrap_or_default();
        let chip = shown.packets.first();
        let demand = chip.map(|packet| Demand::new(packet, shown.frames));
        Ok((judged, demand.unwrap_or_default(), shown.frames))
    }

    /// The float sensor that the program stands for, in words.
    #[must_use]
    pub const fn against(&self) -> &'static str {
        match self.memory {
            DriveMemory::Shared => "a float sensor with one memory of the pixel for all kinds",
            DriveMemory::Analogue | DriveMemory::Bits(_) => {
                "float sensors with a memory of the drive each"
            }
        }
    }

    /// How many kinds like these the chip carries.
    #[must_use]
    pub fn carried(&self) -> usize {
        let Compiled { program, expanded } = &self.compiled;
        let Expanded { stored, device, .. } = expanded;
        carried(self.memory, device, (program.drives.len(), stored.0))
    }
}

/// The first other memory in which the chip holds these designs, in the plans that need no search.
fn other_memory(
    first: &Design<'_>,
    others: &[Design<'_>],
    memory: DriveMemory,
) -> Option<DriveMemory> {
    let effort = Effort::states(0);
    let first = Design { effort, ..*first };
    let others: Vec<_> = { others.iter() }
        .map(|design| Design { effort, ..*design })
        .collect();
    // What fires for ever on the chip is no way out.
    let holds = |other: &DriveMemory| {
        let compiled = first.compile_with(&others, *other, "");
        compiled.is_ok_and(|it| !it.program.is_restless())
    };
    memories(others.len() + 1)
        .into_iter()
        .find(|other| *other != memory && holds(other))
}

/// How to get a memory that was not asked for.
fn advice(memory: DriveMemory) -> String {
    let (option, own) = match memory {
        DriveMemory::Analogue => ("analogue".to_owned(), "`memory = \"filtered-snap\"`"),
        DriveMemory::Shared => (
            "shared".to_owned(),
            "`memory = \"raw-snap\"` and `shared = true`",
        ),
        DriveMemory::Bits(bits) => (format!("bits:{bits}"), "`memory = \"filtered-snap\"`"),
    };
    format!(
        "With {} there is a program: feasibility and design take it with --memory {option}; a sensor file of that kind says {own}",
        name(memory)
    )
}

/// On how many chips of the model a scene says how many events a readout must carry: noise fires,
/// too, and no two chips are alike.
pub const CHIPS: u64 = 4;

/// What was seen of one float sensor and of programs that stand for it.
#[derive(Clone, Debug)]
pub struct SceneRun {
    /// For each program, each of its kinds.
    pub programs: Vec<Vec<Judged>>,
    /// All events of each program with the errors of the chip that is judged.
    pub packets: Vec<Packet>,
    /// What the events of each program ask of a readout: the most on all chips, and without errors.
    pub demands: Vec<Demand>,
    /// The float sensor's events.
    pub float: Packet,
    /// Frames that were shown.
    pub frames: u64,
}

/// Shows the scene once, to a float sensor, to its ladder and to programs that stand for it, and
/// judges every kind of each; with the window of a match and the seed of the silicon. Of `chips`, of
/// this seed and the next ones, the first is judged; all of them say what a readout must carry.
///
/// # Errors
/// When a sensor cannot be made, or scene or sensor cannot go on.
pub fn judge(
    programs: &[&Compiled],
    description: &Description,
    (within, seed, chips): (Micros, u64, u64),
    scene: &mut dyn Scene,
    mut seen: impl FnMut(&Frame),
) -> Result<SceneRun, StudyError> {
    let (size, fps) = (scene.size(), scene.fps());
    let rung = |part: f64| at_part(description, part);
    let mut models = vec![description.clone()];
    models.extend(RUNGS.into_iter().map(rung));
    let mut sensors: Vec<Box<dyn Sensor + Send>> = Vec::new();
    for model in models {
        sensors.push(float(model, size, seed, Format::F64)?);
    }
    let silicon = (0..chips.max(1)).map(|n| Arithmetic::Silicon {
        seed: seed.wrapping_add(n),
    });
    let kinds: Vec<_> = [Arithmetic::Number(Format::F64)]
        .into_iter()
        .chain(silicon)
        .collect();
    let mut arrays: Vec<Box<dyn Array + Send>> = Vec::new();
    for program in programs {
        for arithmetic in &kinds {
            arrays.push(program.chip(*arithmetic, size, program.settings())?);
        }
    }
    let mut watching = rig::each(&mut sensors);
    watching.extend(rig::each(&mut arrays));
    let mut frames = 0;
    let packets = rig::watch(scene, &mut watching, |frame| {
        frames += 1;
        seen(frame);
    })?;
    let (floats, arrays) = packets.split_at(packets.len().min(RUNGS.len() + 1));
    let each = || arrays.chunks_exact(kinds.len());
    let mut judged = vec![Vec::new(); programs.len()];
    for kind in 0..description.channels.len() {
        let floats: Vec<Packet> = floats.iter().map(|packet| own(packet, kind)).collect();
        let [truth, rungs @ ..] = &floats[..] else {
            continue;
        };
        let ladder = Ladder::new(truth.clone(), rungs, within, fps, seed)?;
        for (ran, judged) in each().zip(&mut judged) {
            let [exact, silicon] = [0, 1].map(|one| own(&ran[one], kind));
            judged.push(Judged {
                exact: ladder.judge(&exact)?,
                silicon: ladder.judge(&silicon)?,
                packet: silicon,
            });
        }
    }
    let most = |ran: &[Packet]| {
        let each = ran.iter().map(|packet| Demand::new(packet, frames));
        each.reduce(Demand::and).unwrap_or_default()
    };
    Ok(SceneRun {
        programs: judged,
        packets: each().map(|ran| ran[1].clone()).collect(),
        demands: each().map(most).collect(),
        float: { floats.first().cloned() }.unwrap_or_else(|| Packet::new(size, 1)),
        frames,
    })
}

/// The events of one kind, as a sensor of that kind alone has them.
pub(super) fn own(packet: &Packet, kind: usize) -> Packet {
    let mut own = Packet::new(packet.size, 1);
    own.span = packet.span;
    let events = packet.events.iter();
    own.events = events
        .filter(|event| usize::from(event.channel) == kind)
        .map(|event| Event {
            channel: 0,
            ..*event
        })
        .collect();
    own
}
