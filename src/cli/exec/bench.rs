//! The program on its arrays, as often as is asked for.

use std::{ops::ControlFlow, sync::Arc};

use miette::{WrapErr, miette};

use super::{
    arguments::{Arguments, Assignment, Switch},
    beside::{self, Run},
    light::{Lasting, Light, Said},
    moment::{Moment, Part},
    set::Set,
    strip, trace,
};
use crate::{
    array::{Arithmetic, Array, Register, Schedule, Settings},
    cli::{
        arguments::budget::{self, Growth},
        complain,
        input::opened_program::Opened,
    },
    event::Packet,
    isa::{Device, Figure},
    limit::THREADS,
    memory::Need,
    number::Format,
    plane::Size,
    program::{Expansion, Exposure, Program, Step},
    rig::{
        self,
        guard::{Guard, Warning},
    },
    scene::{Observation, Scene, kept::Kept},
    study::{
        execution::{CellOptions, Execution, Ran, begin, uncaptured},
        pilot::Machine,
        saturation::{self, Saturation},
    },
    unit::counted,
};

/// A program and all that it needs to run, once or several times.
pub struct Bench<'a> {
    pub(super) arguments: &'a Arguments,
    pub opened: Opened,
    pub(super) planes: Vec<Set>,
    pub(super) size: Size,
    /// What was seen of its light.
    pub observation: Observation,
    /// That its light goes nowhere, where it does not.
    uncaptured: Option<String>,
    /// What is to be said of how long it lasts.
    pub said: Said,
    /// Bytes of the frames of its light.
    frames: u128,
    /// Its clip, where it was read before.
    pub read: Option<Kept>,
    pub arithmetic: Arithmetic,
    pub(super) settings: Settings,
    /// What runs in place of the arithmetic that was asked for.
    pub machine: Option<Machine>,
    /// What a host that decides asked for, frame by frame, where that is looked at.
    recorded: Vec<Arc<[Step]>>,
}

impl<'a> Bench<'a> {
    pub fn new(arguments: &'a Arguments) -> miette::Result<Self> {
        let figures: Vec<(Figure, f64)> = arguments
            .sets
            .iter()
            .filter_map(|set| match set {
                Assignment::Figure(figure, value) => Some((*figure, *value)),
                Assignment::Register(..) | Assignment::Constant(..) => None,
            })
            .collect();
        let constants: Vec<(String, f64)> = arguments
            .sets
            .iter()
            .filter_map(|set| match set {
                Assignment::Constant(name, value) => Some((name.clone(), *value)),
                Assignment::Register(..) | Assignment::Figure(..) => None,
            })
            .collect();
        let names = arguments.sets.iter().filter_map(|set| match set {
            Assignment::Register(name, _) => Some(name.as_str()),
            Assignment::Figure(..) | Assignment::Constant(..) => None,
        });
        let names: Vec<&str> = names.collect();
        let opened = {
            let source = &arguments.source;
            let before = arguments.fidelity.is_auto();
            let how = (arguments.host, before);
            source.open_to_run(&figures, &constants, &names, how)?
        };
        let Opened {
            program, device, ..
        } = &opened;
        let registers = arguments.sets.iter().filter_map(|set| match set {
            Assignment::Register(name, path) => Some(Set::read(device, name, path)),
            Assignment::Figure(..) | Assignment::Constant(..) => None,
        });
        let planes = registers.collect::<miette::Result<Vec<_>>>()?;
        let observation = Observation::new();
        let light = Light::open(arguments, program, &observation)?;
        let size = size(&planes, light.scene.as_deref(), program, device)?;
        let set = |register| planes.iter().any(|set| set.sets(register));
        let give = |name: &str| format!("--set {name}=FILE.npy");
        let (file, expansion) = (&program.file, &opened.expansion);
        let told = light
            .scene
            .as_ref()
            .map(|_| uncaptured(file, expansion, device, set, give));
        let uncaptured = told.flatten();
        if let Some(told) = &uncaptured {
            complain(&format!("warning: {told}\n"));
        }
        Ok(Self {
            size,
            uncaptured,
            observation,
            said: Said::default(),
            frames: light
                .scene
                .as_ref()
                .map_or(0, |scene| scene.outline().bytes),
            arithmetic: cells(arguments).arithmetic(program)?,
            settings: settings(arguments, program, device)?,
            machine: None,
            read: None,
            recorded: Vec::new(),
            arguments,
            planes,
            opened,
        })
    }

    /// What a run holds, without its events.
    fn need(&self) -> Need {
        let device = &self.opened.device;
        let arguments = self.arguments;
        let pixels = self.size.pixels() as u128;
        let written = self.written().len() as u128;
        // Numbers, and a picture of them.
        let looked = match arguments.strip {
            Some(_) => 11 * written * strip::columns(&self.codes()) as u128,
            None if arguments.repeat.is_some() => 8 * (2 * written + 3),
            None => 16 * u128::from(arguments.dump.is_some()),
        };
        // Three more chips, and what is kept of them.
        let traced = match arguments.trace {
            Some(_) => trace::bytes(device, self.size),
            None => 0,
        };
        // What registers held is put back.
        let aside = if saturation::looks(&self.codes(), device) {
            self.arithmetic.bytes_of_registers(device, self.size)
        } else {
            0
        };
        Need::new()
            .and("frames of the light", self.frames + 8 * pixels)
            .and("the chip", self.arithmetic.bytes(device, self.size))
            .and("registers that are kept while words are looked at", aside)
            .and("the chips of the trace", traced)
            .and(
                "registers that are set",
                8 * pixels * self.planes.len() as u128,
            )
            .and("registers that are looked at", (8 + looked) * pixels)
    }

    /// What events may take beside that.
    pub fn growth(&self) -> Growth {
        Growth::beside(&self.need())
    }

    /// Refuses what cannot be run so.
    pub fn check(&self) -> miette::Result<()> {
        let fidelity = &self.arguments.fidelity;
        fidelity.check()?;
        fidelity.check_without(&self.arguments.without.told())?;
        self.check_room()?;
        self.check_events()?;
        self.check_known()
    }

    /// Runs a program whose host decides, to know its steps, where they are looked at one by one.
    pub fn record(&mut self) -> miette::Result<()> {
        if !self.opened.decides || !self.arguments.looks() {
            return Ok(());
        }
        let mut chip = self.chip(self.arguments.seed())?;
        self.recorded = beside::record(self, &mut *chip)?;
        self.check_room()
    }

    /// What runs, on what.
    pub fn execution(&self) -> Execution<'_> {
        let opened = &self.opened;
        Execution {
            program: &opened.program,
            code: &opened.expansion.code,
            decides: opened.decides,
            recorded: &self.recorded,
            device: &opened.device,
            arithmetic: self.arithmetic,
            settings: self.settings,
        }
    }

    /// The steps of the frames, without those that are others' again.
    pub fn codes(&self) -> Vec<&[Step]> {
        self.execution().codes()
    }

    /// Refuses an array for which there is no room.
    fn check_room(&self) -> miette::Result<()> {
        let what = format!("an array of {} in {}", self.size, self.arithmetic);
        let help = "take a smaller array or a narrower --domain";
        budget::check(&self.need(), &what, help)
    }

    /// A chip as switched on, its registers set.
    pub fn chip(&self, seed: u64) -> miette::Result<Box<dyn Array + Send>> {
        let arithmetic = self.arithmetic.with_seed(seed);
        self.chip_in(arithmetic, &self.opened.device, self.machine.as_ref())
    }

    /// What is left out by hand.
    pub fn left_out(&self) -> miette::Result<Option<Machine>> {
        let exact = self.arithmetic == Arithmetic::Number(Format::F64);
        if exact && self.arguments.trace.is_some() {
            // Only the cells of the page are analogue.
            return Ok(None);
        }
        self.arguments.without.machine(self.arithmetic)
    }

    /// A chip in this arithmetic, with the numbers of this device.
    pub fn chip_in(
        &self,
        arithmetic: Arithmetic,
        device: &Device,
        machine: Option<&Machine>,
    ) -> miette::Result<Box<dyn Array + Send>> {
        let execution = Execution {
            arithmetic,
            device,
            ..self.execution()
        };
        let mut chip = execution
            .chip(machine, self.size)
            .wrap_err_with(|| format!("{} cannot run", self.opened.program.file))?;
        for set in &self.planes {
            set.apply(&mut *chip)?;
        }
        Ok(chip)
    }

    /// What there is to warn of in the program's text.
    pub fn source_warnings(&self) -> Vec<String> {
        let Opened {
            program, expansion, ..
        } = &self.opened;
        let of_host = self.said.source.borrow();
        let expanded = program.warnings(expansion);
        let mut all = expanded.map_or_else(Vec::new, |faults| faults.lines());
        all.extend(self.opened.nothing());
        all.extend(self.uncaptured.clone());
        all.extend(of_host.iter().cloned());
        all
    }

    /// What there is to warn of after a run of so many frames.
    pub fn warnings(
        &self,
        guard: Guard,
        chip: &dyn Array,
        packet: &Packet,
        frames: u64,
        saturation: Saturation,
    ) -> Vec<Warning> {
        self.execution().warnings(Ran {
            chip,
            packet,
            // In the middle of a frame nothing is read out yet.
            frames: frames.saturating_sub(self.said.stopped.get().into()),
            observation: &self.observation,
            is_dark: self.arguments.image.is_none() && self.opened.program.settings.image.is_none(),
            exposure: self.said.exposure.get(),
            saturation,
            guard,
        })
    }

    /// Looks for registers at the end of their range.
    pub fn saturation(&self) -> Saturation {
        self.execution().saturation()
    }

    /// The registers that the program writes: any of them, where its host decides as it goes.
    pub fn written(&self) -> Vec<Register> {
        let device = &self.opened.device;
        if self.execution().is_unknown() {
            Register::all(device)
        } else {
            Register::written(&self.codes(), device)
        }
    }

    /// Refuses what needs the steps of a program before it runs, where its host decides them.
    fn check_known(&self) -> miette::Result<()> {
        if !(self.opened.decides && self.arguments.fidelity.is_auto()) {
            return Ok(());
        }
        Err(miette!(
            help = "leave --fidelity out for the full model. To leave errors out by hand: run it twice, with --domain silicon -o full.npy and with --domain silicon --without noise,decay -o less.npy, and see by `amacrine compare full.npy less.npy` what that changes. Or give what the host decides a fixed value, --const NAME=VALUE, so that every frame has the same words",
            "--fidelity auto: the host of {} decides in the run which words come next, and a pilot has to know them before",
            self.opened.program.file
        ))
    }

    /// Whether the program reads events out.
    pub fn reads_events(&self) -> bool {
        self.execution().reads_events()
    }

    /// What is to be said beside a run of so many frames.
    pub fn notes(&self, frames: u64) -> Vec<String> {
        let mut notes = self.said.notes(frames);
        notes.extend(self.unused());
        notes.extend(self.unshown());
        notes
    }

    /// What is to be said of texts that the host posts where it does not run beside the array.
    fn unshown(&self) -> Option<String> {
        let posts = self.opened.expansion.posts;
        let silent = !self.opened.decides && posts > 0;
        silent.then(|| {
            format!(
                "texts that the host posts in {} are not shown: --host runs it beside the array, and shows them",
                counted(posts, "place")
            )
        })
    }

    /// What is to be said of numbers of the chip, or a seed, that were set and change nothing.
    fn unused(&self) -> Option<String> {
        const DOMAIN: &str = "--domain";
        // A trace runs the chip's errors beside.
        if self.arguments.trace.is_some() {
            return None;
        }
        let set = self.arguments.sets.iter().find_map(|set| match set {
            Assignment::Figure(figure, _) => self.arithmetic.unused(*figure, DOMAIN),
            _ => None,
        });
        set.or_else(|| {
            { self.arguments.seed }.and_then(|_| self.arithmetic.changes_nothing("--seed", DOMAIN))
        })
    }

    /// Refuses files of events where the program reads none out.
    fn check_events(&self) -> miette::Result<()> {
        if self.arguments.events.is_none() || self.reads_events() {
            return Ok(());
        }
        Err(miette!(
            help = "add `scamp5_scan_events(R5, on, 1000);` with the register that holds them, or leave --events out; --dump writes registers",
            "{} reads no events out: --events would write none",
            self.opened.program.file
        ))
    }

    /// Shows the light to the chip; what it said, and how many frames it saw. `run` runs each
    /// frame's steps, and can end it.
    ///
    /// Bare statements run for every frame, once if nothing else is asked for; other programs
    /// run `init` with the first frame and `frame` with the others.
    pub fn watch(
        &self,
        chip: &mut dyn Array,
        mut run: impl FnMut(&mut dyn Array, &Moment<'_>, &mut Packet) -> miette::Result<ControlFlow<()>>,
    ) -> miette::Result<(Packet, u64)> {
        if self.opened.decides {
            return match &self.recorded[..] {
                [] => beside::watch(self, chip, &mut run),
                recorded => self.watch_recorded(chip, recorded, &mut run),
            };
        }
        let mut light = Light::open(self.arguments, &self.opened.program, &self.observation)?;
        if let Some(read) = &self.read {
            light.scene = Some(Box::new(read.scene()));
        }
        let Expansion { code, bare, .. } = &self.opened.expansion;
        let mut light = Lasting::new(light, self.size, if *bare { 1 } else { 2 });
        let mut packet = Packet::new(chip.size(), chip.channels());
        packet.names = self.opened.program.names(code)?;
        let steps = |index| {
            Some(if *bare || index > 0 {
                (&code.frame[..], Part::Frame)
            } else {
                (&code.init[..], Part::Init)
            })
        };
        let frames = self.play(&mut light, chip, &mut packet, &steps, &mut run)?;
        self.said.set(&light);
        let mut exposure = Exposure::default();
        exposure.see(&code.frame, &self.opened.device);
        self.said.exposure.set(exposure);
        Ok((packet, frames))
    }

    /// Shows the same light once more: what the host asked for in each frame runs again.
    fn watch_recorded(
        &self,
        chip: &mut dyn Array,
        recorded: &[Arc<[Step]>],
        run: &mut Run<'_>,
    ) -> miette::Result<(Packet, u64)> {
        // What is to be said of it was said.
        let light = Light::open(self.arguments, &self.opened.program, &Observation::new())?;
        let mut light = Lasting::new(light, self.size, beside::FRAMES);
        let mut packet = Packet::new(chip.size(), chip.channels());
        let steps = |index| Some((&**recorded.get(index as usize)?, Part::Recorded));
        let frames = self.play(&mut light, chip, &mut packet, &steps, run)?;
        packet.names = self.opened.program.names_of(packet.channels)?;
        Ok((packet, frames))
    }

    /// Shows the light to the chip as long as there are steps for a frame; how many frames it saw.
    fn play<'s>(
        &self,
        light: &mut Lasting,
        chip: &mut dyn Array,
        packet: &mut Packet,
        steps: &dyn Fn(u64) -> Option<(&'s [Step], Part)>,
        run: &mut Run<'_>,
    ) -> miette::Result<u64> {
        let growth = self.growth();
        let mut before: Option<f64> = None;
        let mut index = 0;
        rig::play(light, |frame| {
            let Some((steps, part)) = steps(index) else {
                return Ok::<_, miette::Report>(ControlFlow::Break(()));
            };
            let (t, since) = begin(chip, &frame, before, packet)?;
            before = Some(frame.seconds);
            let moment = Moment {
                index,
                t,
                since,
                light: &frame.light,
                steps,
                part,
            };
            index += 1;
            let flow = run(chip, &moment, packet)?;
            if flow.is_continue() {
                growth.check(packet, &self.opened.program.file)?;
            }
            Ok(flow)
        })?;
        Ok(index)
    }
}

/// What the caller says of cells.
fn cells(arguments: &Arguments) -> CellOptions<'_> {
    CellOptions {
        domain: arguments.domain.as_deref(),
        seed: arguments.seed(),
        clip: arguments.clip.map(|clip| clip == Switch::On),
        edge: arguments.edge,
        gain: arguments.gain,
    }
}

fn settings(arguments: &Arguments, program: &Program, device: &Device) -> miette::Result<Settings> {
    let mut settings = cells(arguments).settings(program, device);
    finite("--edge", settings.edge)?;
    finite("--gain", settings.gain)?;
    settings.schedule = match &arguments.schedule {
        // One step at a time has no use for any other.
        _ if arguments.debug || arguments.strip.is_some() || arguments.trace.is_some() => {
            Some(Schedule::Plain)
        }
        name => name.as_deref().map(str::parse).transpose()?,
    };
    settings.threads = Some(rayon::current_num_threads().min(THREADS));
    Ok(settings)
}

fn finite(what: &str, value: f64) -> miette::Result<()> {
    if value.is_finite() {
        return Ok(());
    }
    Err(miette!(help = "give a number", "{what} is {value}"))
}

/// The size of the array: of what is set, else of the light, else of the program, else of the chip.
fn size(
    planes: &[Set],
    scene: Option<&dyn Scene>,
    program: &Program,
    device: &Device,
) -> miette::Result<Size> {
    let set = planes
        .iter()
        .map(|set| (set.path.display().to_string(), Size::of(&set.plane)));
    let light = scene.map(|scene| ("the light".to_owned(), scene.size()));
    let mut all = set.chain(light);
    let Some((first, size)) = all.next() else {
        let height = device.value(Figure::Height) as usize;
        let width = device.value(Figure::Width) as usize;
        let (height, width) = program.settings.size.unwrap_or((height, width));
        return checked(Size::new(height, width));
    };
    if let Some((other, its)) = all.find(|(_, its)| *its != size) {
        return Err(miette!(
            help = "all planes and the light must have one size: that of the array",
            "{first} is {size}, {other} is {its}"
        ));
    }
    checked(size)
}

fn checked(size: Size) -> miette::Result<Size> {
    if size.is_possible() {
        return Ok(size);
    }
    Err(miette!(
        help = format!(
            "height and width must be from 1 to {}, and {} pixels at most",
            Size::LONGEST_SIDE,
            Size::MOST_PIXELS
        ),
        "an array of {size}"
    ))
}
