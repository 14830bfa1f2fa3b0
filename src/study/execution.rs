//! A program run on an array, as the command line and the Python package both run it: what its cells
//! are, the array, how light falls on it, and what there is to warn of.

use std::sync::Arc;

use super::{
    pilot::{Chips, Machine},
    saturation::{self, Saturation},
};
use crate::{
    array::{
        Arithmetic, ArithmeticError, Array, CodeError, Register, Settings, ShapeError, Unheld,
    },
    event::Packet,
    isa::{Cell, Device},
    photoreceptor::Response,
    plane::{At, Size},
    program::{CellEffect, Code, Expansion, Exposure, Program, Step},
    rig::{
        Larger,
        guard::{Guard, Warning},
    },
    scene::{Frame, Observation},
    unit::Micros,
};

/// What a caller says of the cells of an array; of what is left out the program says, or its chip.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellOptions<'a> {
    /// What cells hold.
    pub domain: Option<&'a str>,
    /// Which chip and which noise, of analogue cells.
    pub seed: u64,
    /// Whether every store is limited to the range of a register.
    pub clip: Option<bool>,
    /// What registers off the array hold, in LSB.
    pub edge: Option<f64>,
    /// LSB for each unit of light.
    pub gain: Option<f64>,
}

impl CellOptions<'_> {
    /// What the cells of an array are that runs this program.
    ///
    /// # Errors
    /// When the domain is none.
    pub fn arithmetic(&self, program: &Program) -> Result<Arithmetic, ArithmeticError> {
        let own = program.settings.domain.as_deref();
        let arithmetic: Arithmetic = self.domain.or(own).unwrap_or("exact").parse()?;
        Ok(arithmetic.with_seed(self.seed))
    }

    /// How the array behaves.
    #[must_use]
    pub fn settings(&self, program: &Program, device: &Device) -> Settings {
        let own = &program.settings;
        let chip = Settings::from_device(device);
        Settings {
            clip: self.clip.or(own.clip).unwrap_or(chip.clip),
            edge: self.edge.or(own.edge).unwrap_or(chip.edge),
            gain: self.gain.unwrap_or(chip.gain),
            ..chip
        }
    }
}

/// A program, and the array that it runs on.
#[derive(Clone, Copy, Debug)]
pub struct Execution<'a> {
    /// The program.
    pub program: &'a Program,
    /// What it became on its chip; nothing where its host decides.
    pub code: &'a Code,
    /// Whether its host decides in the run what the array does.
    pub decides: bool,
    /// What that host asked for in each frame of an earlier run, where that was looked at.
    pub recorded: &'a [Arc<[Step]>],
    /// The chip.
    pub device: &'a Device,
    /// What its cells are.
    pub arithmetic: Arithmetic,
    /// How it behaves, and is worked on.
    pub settings: Settings,
}

/// What a run has left.
pub struct Ran<'a> {
    /// The array.
    pub chip: &'a dyn Array,
    /// What was read out.
    pub packet: &'a Packet,
    /// Frames that the array saw.
    pub frames: u64,
    /// What was seen of its light.
    pub observation: &'a Observation,
    /// Whether nobody gave it light.
    pub is_dark: bool,
    /// What was done with the photodiodes.
    pub exposure: Exposure,
    /// What was seen of registers at the end of their range.
    pub saturation: Saturation,
    /// Knows when the frames were.
    pub guard: Guard,
}

impl<'a> Execution<'a> {
    /// It as a family of models.
    #[must_use]
    pub fn chips(&self) -> Chips<'a> {
        Chips {
            name: &self.program.file,
            code: self.code,
            device: self.device,
            settings: self.settings,
            arithmetic: self.arithmetic,
            reads_all: false,
        }
    }

    /// An array of this size as switched on; `machine` runs in place of the arithmetic.
    ///
    /// # Errors
    /// When the program cannot run there.
    pub fn chip(
        &self,
        machine: Option<&Machine>,
        size: Size,
    ) -> Result<Box<dyn Array + Send>, CodeError> {
        let chips = self.chips();
        let full = chips.machine();
        let lies = (At { y: 0, x: 0 }, size.width);
        chips.chip(machine.unwrap_or(&full), size, (&[lies.0], lies.1))
    }

    /// The steps of the frames, without those that are others' again.
    #[must_use]
    pub fn codes(&self) -> Vec<&'a [Step]> {
        if self.recorded.is_empty() {
            return vec![&self.code.init, &self.code.frame];
        }
        // Frames that are alike share their steps.
        let mut all: Vec<&'a Arc<[Step]>> = Vec::new();
        for steps in self.recorded {
            if !all.iter().any(|it| Arc::ptr_eq(it, steps)) {
                all.push(steps);
            }
        }
        all.into_iter().map(|it| &**it).collect()
    }

    /// Whether its host decides, and nobody wrote down what.
    #[must_use]
    pub const fn is_unknown(&self) -> bool {
        self.decides && self.recorded.is_empty()
    }

    /// Whether the program reads events out, as addresses or in whole bit planes; one whose host
    /// decides may.
    #[must_use]
    pub fn reads_events(&self) -> bool {
        self.decides || self.code.reads_events()
    }

    /// Looks for registers at the end of their range, or, in an arithmetic that has no end, beyond
    /// that of the chip.
    #[must_use]
    pub fn saturation(&self) -> Saturation {
        Saturation::new(self.arithmetic, self.device, &self.settings)
    }

    /// What of the program's numbers its cells do not hold; `exposure` is what a run did with light.
    #[must_use]
    pub fn unheld(&self, exposure: Exposure) -> Option<Unheld> {
        let (cells, settings) = (self.arithmetic, &self.settings);
        if self.is_unknown() {
            // What it did with light is known after the run, and no more.
            return { exposure.reads().then(|| Unheld::of_light(cells, settings)) }.flatten();
        }
        Unheld::of_program(cells, &self.codes(), self.device, settings)
    }

    /// What there is to warn of after a run.
    #[must_use]
    pub fn warnings(&self, ran: Ran<'_>) -> Vec<Warning> {
        let subject = &self.program.file;
        let unheld = self.unheld(ran.exposure);
        let mut guard = ran.guard;
        guard.extend(Warning::of_scene(ran.observation, Response::IDENTITY));
        if let Some(unheld) = &unheld {
            saturation::warn_unheld(&mut guard, subject, unheld);
        }
        if let Err(larger) = Larger::check(subject, ran.chip.size(), self.device) {
            guard.warn(Warning::larger(subject, &larger));
        }
        let Ran { packet, frames, .. } = ran;
        // A host that decides looks for one pixel after the other, and knows what it leaves.
        if !self.decides {
            // A program that reads no events out, and a single frame, have none to miss.
            if self.code.reads_events() && frames > 1 {
                let is_empty = packet.events.is_empty() && packet.dropped.total() == 0;
                // Without its own numbers nothing that it says tells of light or thresholds.
                if ran.is_dark && is_empty {
                    guard.warn(Warning::in_the_dark(subject, frames));
                } else if unheld.is_none() {
                    guard.packet(subject, packet);
                    guard.extend(Warning::silent_kinds_in(subject, packet, frames));
                }
            } else {
                guard.lost(subject, packet.dropped, packet.events.len() as u64);
            }
        }
        ran.saturation
            .warn(&mut guard, subject, |register| self.loads(register));
        guard.warnings()
    }

    /// Whether a register holds a constant that the program loads, whatever the light is.
    fn loads(&self, register: &str) -> bool {
        // What a host decides may be.
        self.is_unknown() || {
            let steps = self.codes().concat();
            saturation::loads(&steps, self.device, self.settings, register)
        }
    }
}

/// That bare statements take no light in, where some is given, and read registers that neither they
/// nor the caller has set: 0 everywhere, in silence. `give` says how a register is set, by its name.
#[must_use]
pub fn uncaptured(
    file: &str,
    Expansion { code, bare, .. }: &Expansion,
    device: &Device,
    is_set: impl Fn(Register) -> bool,
    give: impl Fn(&str) -> String,
) -> Option<String> {
    let mut exposure = Exposure::default();
    exposure.see(&code.frame, device);
    if !bare || exposure.reads() {
        return None;
    }
    let effect = CellEffect::of(&code.frame, device);
    let inputs = effect
        .reads
        .into_iter()
        .filter(|cell| *cell != Cell::Flag && !is_set(Register::from(*cell)));
    let inputs: Vec<Cell> = inputs.collect();
    let first = inputs.first()?.name(device);
    let capture = match inputs.first()? {
        Cell::Analog(_) => format!(", or begin with `get_image({first});`"),
        Cell::Digital(_) | Cell::Flag => String::new(),
    };
    let names: Vec<String> = inputs.iter().map(|it| it.name(device)).collect();
    let (last, others) = names.split_last()?;
    let (names, they) = match others {
        [] => (last.clone(), "it is"),
        others => (format!("{} and {last}", others.join(", ")), "they are"),
    };
    let give = give(&first);
    Some(format!(
        "{file}: light is given, and no word captures it: nothing has written {names} before {they} read (0 everywhere); give {give}{capture}"
    ))
}

/// Lets the light of a frame fall on the array; when that is, and the seconds since the frame
/// `before`, if there was one.
///
/// # Errors
/// When the frame has another size.
pub fn begin(
    chip: &mut dyn Array,
    frame: &Frame,
    before: Option<f64>,
    packet: &mut Packet,
) -> Result<(Micros, Option<f64>), ShapeError> {
    let t = Micros::from_seconds(frame.seconds);
    chip.begin_frame();
    chip.expose(&frame.light)?;
    let since = before.map(|before| frame.seconds - before);
    match since {
        Some(seconds) => chip.wait(seconds),
        None => packet.span.0 = t,
    }
    packet.span.1 = t;
    Ok((t, since))
}
