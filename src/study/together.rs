//! Several designs in one program: the memory that holds them on a chip, and what each kind keeps
//! of the float sensor that the program stands for.
//!
//! A program whose kinds have a memory each stands for float sensors of `filtered-snap`; one with a
//! memory of the pixel for all of them stands for one float sensor of `raw-snap`, shared.

use super::{
    design::{Compiled, Design, DesignError, float},
    equivalent::{EquivalentError, Ladder, Likeness, RUNGS, at_part},
};
use crate::{
    array::{Arithmetic, Array},
    compile::{DriveMemory, MEMORY_BITS, carried},
    event::{Event, Packet},
    number::Format,
    program::stored,
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
fn memories(kinds: usize) -> Vec<DriveMemory> {
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
        DriveMemory::Bits(bits) => format!("memories of {bits} bits each"),
    }
}

impl Together {
    /// Compiles designs in levels with the first memory that the chip holds them in; else what each
    /// memory is short of.
    ///
    /// # Errors
    /// When a threshold is not positive.
    pub fn compile(
        levels: &[Design<'_>],
        title: &str,
    ) -> Result<Result<Self, Vec<String>>, DesignError> {
        let Some((first, others)) = levels.split_first() else {
            return Ok(Err(Vec::new()));
        };
        let mut refused = Vec::new();
        for memory in memories(levels.len()) {
            match first.compile_with(others, memory, title) {
                Ok(compiled) => return Ok(Ok(Self { memory, compiled })),
                Err(error) if error.is_refusal() => {
                    refused.push(format!("{}: {error}", name(memory)));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(Err(refused))
    }

    /// The float sensor that the program stands for, of the designs before they were quantised.
    ///
    /// # Errors
    /// When a threshold is not positive.
    pub fn description(&self, floats: &[Design<'_>]) -> Result<Description, DesignError> {
        let shared = self.memory == DriveMemory::Shared;
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

    /// Shows the scene to the float sensors and to the program, and judges every kind. Also the
    /// number of frames.
    ///
    /// # Errors
    /// When a sensor cannot be made, or scene or sensor cannot go on.
    pub fn judge(
        &self,
        floats: &[Design<'_>],
        (within, seed): (Micros, u64),
        scene: &mut dyn Scene,
        mut seen: impl FnMut(&Frame),
    ) -> Result<(Vec<Judged>, u64), EquivalentError> {
        let (size, fps) = (scene.size(), scene.fps());
        let description = self.description(floats)?;
        let rung = |part: f64| at_part(&description, part);
        let mut models = vec![description.clone()];
        models.extend(RUNGS.into_iter().map(rung));
        let mut sensors: Vec<Box<dyn Sensor + Send>> = Vec::new();
        for model in models {
            let made = float(model, size, seed, Format::F64).map_err(DesignError::from)?;
            sensors.push(made);
        }
        let mut chips: Vec<Box<dyn Array + Send>> = Vec::new();
        let silicon = Arithmetic::Silicon { seed };
        for arithmetic in [Arithmetic::Number(Format::F64), silicon] {
            chips.push(
                self.compiled
                    .chip(arithmetic, size, self.compiled.settings())?,
            );
        }
        let mut watching: Vec<&mut (dyn Sensor + Send)> = Vec::new();
        for sensor in &mut sensors {
            watching.push(sensor);
        }
        for chip in &mut chips {
            watching.push(chip);
        }
        let mut frames = 0;
        let packets = rig::watch(scene, &mut watching, |frame| {
            frames += 1;
            seen(frame);
        })?;
        let mut judged = Vec::new();
        for kind in 0..floats.len() {
            let own: Vec<Packet> = packets.iter().map(|packet| own(packet, kind)).collect();
            let [truth, rungs @ .., exact, silicon] = &own[..] else {
                continue;
            };
            let ladder = Ladder::new(truth.clone(), rungs, within, fps, seed)?;
            judged.push(Judged {
                exact: ladder.judge(exact)?,
                silicon: ladder.judge(silicon)?,
                packet: silicon.clone(),
            });
        }
        Ok((judged, frames))
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
        let Compiled {
            device,
            code,
            program,
            ..
        } = &self.compiled;
        let words = stored(&code.init, device) + stored(&code.frame, device);
        carried(self.memory, device, (program.drives.len(), words.0))
    }
}

/// The events of one kind, as a sensor of that kind alone has them.
fn own(packet: &Packet, kind: usize) -> Packet {
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
