//! `amacrine exec`: a program on the array, and every register written out.

mod bench;
mod light;
mod report;

use std::{
    io,
    ops::ControlFlow,
    path::{Path, PathBuf},
};

use miette::miette;
use ndarray_npy::{WritableElement, WriteNpyExt};

pub(super) use self::{light::read_plane, report::reading};

use super::{
    content::Content,
    files::{self, Named, Output},
    light::Samples,
    opened::Opened,
    registers::Register,
    strip::Strip,
};
use crate::{
    array::{Arithmetic, Array, Schedule, Settings},
    config::nearest,
    event::Packet,
    isa::{Analog, Device, Digital, Figure},
    limit::THREADS,
    picture::{panel, write_png},
    plane::{Plane, Size},
    program::Step,
    rig::guard::{Guard, Warning},
    save::save,
    scene::{Observation, Scene},
    unit::Micros,
};

/// What `exec` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine exec sobel.scamp --set A=a.npy --domain q8.8 --dump out/registers"
)]
pub struct Arguments {
    #[command(flatten)]
    source: super::opened::Source,
    /// Set a register before the program runs (a .npy of shape (H,W)), or a number of the chip
    /// (error.noise=0.1); can be given more than once
    #[arg(long = "set", value_name = "NAME=FILE.npy|NUMBER", value_parser = assignment)]
    sets: Vec<Assignment>,
    /// The light: a picture, a clip, or pattern:NAME?key=value; a still picture is shown again and again
    #[arg(long)]
    image: Option<Named>,
    #[command(flatten)]
    samples: Samples,
    /// How many frames to run; the first one runs `init`, the others `frame`
    #[arg(long)]
    frames: Option<u64>,
    /// Frames per second, instead of what the scene says
    #[arg(long)]
    fps: Option<f64>,
    /// The arithmetic: exact, f32, f16, bf16, qM.N (q8.8, q4.12, …), silicon
    #[arg(long)]
    domain: Option<String>,
    /// Limit every store to [-128, 127]
    #[arg(long, value_enum)]
    clip: Option<Switch>,
    /// What registers off the array hold
    #[arg(long, allow_negative_numbers = true)]
    edge: Option<f64>,
    /// What PIX rises by for one unit of light
    #[arg(long)]
    gain: Option<f64>,
    /// Which chip of the silicon domain, and which noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// In which order the array is worked on, which changes only the speed: plain, tiled
    #[arg(long)]
    schedule: Option<String>,
    /// On how many threads at most
    #[arg(long, value_parser = threads)]
    threads: Option<usize>,
    #[arg(long, help = format!("Write the events that were read out; the extension names the format ({})", crate::event::file::Format::names()), value_parser = Content::Events)]
    events: Option<Output>,
    /// Write every register into this folder, as .npy and .png
    #[arg(long, value_parser = Content::Folder)]
    dump: Option<Output>,
    /// Write what registers hold after each line of the last frame, side by side (.png)
    #[arg(long, value_name = "FILE.png", value_parser = Content::Picture)]
    strip: Option<Output>,
    /// Run so many times, with this seed and those that follow; print mean and spread
    #[arg(long, value_name = "N", conflicts_with_all = ["dump", "events", "strip", "debug"])]
    repeat: Option<u64>,
    /// Step through the program; commands are read from standard input, `help` lists them
    #[arg(long, conflicts_with_all = ["json", "strip"])]
    debug: bool,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Switch {
    On,
    Off,
}

/// What one `--set` asks for.
#[derive(Clone, Debug)]
enum Assignment {
    /// A register is read from a file.
    Register(String, PathBuf),
    /// A number of the chip is another.
    Figure(Figure, f64),
}

/// `name=file` or `section.key=number`, for the command line.
fn assignment(text: &str) -> Result<Assignment, String> {
    let (name, value) = match text.split_once('=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => (name, value),
        _ => {
            return Err(format!(
                "`{text}` is not REGISTER=FILE.npy or FIGURE=NUMBER"
            ));
        }
    };
    if !name.contains('.') {
        return Ok(Assignment::Register(name.to_owned(), value.into()));
    }
    figure(name, value).map(|(figure, number)| Assignment::Figure(figure, number))
}

/// A number of the chip and another value of it, for the command line.
pub(super) fn figure(name: &str, value: &str) -> Result<(Figure, f64), String> {
    let Some(figure) = Figure::named(name) else {
        let all: Vec<String> = Figure::ALL
            .iter()
            .map(|figure| format!("{}.{}", figure.key().0, figure.key().1))
            .collect();
        let near = nearest(name, all.iter().map(String::as_str));
        return Err(match near {
            Some(near) => format!("the chip has no number `{name}`; did you mean `{near}`?"),
            None => format!("the chip has no number `{name}`; it has {}", all.join(", ")),
        });
    };
    let number = value.parse().map_err(|_| {
        format!(
            "`{value}` is not a number: {name} is {}",
            figure.domain().expected()
        )
    })?;
    Ok((figure, number))
}

/// A number of threads, for the command line.
fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(number) if number <= THREADS => Ok(number),
        Ok(_) => Err(format!("{THREADS} threads at most")),
        Err(_) => Err("give a whole number".to_owned()),
    }
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    for set in &arguments.sets {
        if let Assignment::Register(_, path) = set {
            files::reads(path)?;
        }
    }
    let bench = Bench::new(arguments)?;
    bench.check()?;
    if let Some(folder) = &arguments.dump {
        let dumped = dumped(&bench.opened.device);
        files::writes(dumped.iter().flat_map(|(_, name)| named(folder, name)))?;
    }
    if let Some(runs) = arguments.repeat {
        let statistics = super::statistics::Statistics::of(&bench, arguments.seed, runs)?;
        if arguments.json {
            super::say(&format!("{}\n", statistics.json()));
        } else {
            super::say(&statistics.table());
        }
        return Ok(());
    }
    let mut chip = bench.chip(arguments.seed)?;
    let mut strip = Strip::default();
    let mut guard = Guard::new();
    let (packet, frames) = if arguments.debug {
        let mut debugger = super::debug::Debugger::new(&bench.opened);
        let seen = bench.watch(&mut *chip, |chip, moment, packet| {
            guard.frame_at(moment.t);
            debugger.frame(chip, moment, packet)
        })?;
        debugger.end(&*chip)?;
        seen
    } else if arguments.strip.is_some() {
        bench.watch(&mut *chip, |chip, moment, packet| {
            guard.frame_at(moment.t);
            strip.frame(&bench.opened, chip, moment, packet)?;
            Ok(ControlFlow::Continue(()))
        })?
    } else {
        bench.watch(&mut *chip, |chip, moment, packet| {
            guard.frame_at(moment.t);
            moment.run(chip, packet)?;
            Ok(ControlFlow::Continue(()))
        })?
    };
    let warnings = bench.warnings(guard, &*chip, &packet, frames);
    super::light::warn(&warnings);

    // Before anything is written: it may have nothing to show.
    let strip = match &arguments.strip {
        Some(path) => Some((path, strip.picture(&bench.opened)?)),
        None => None,
    };
    if let Some(path) = &arguments.events {
        path.write(&packet)?;
    }
    if let Some(folder) = &arguments.dump {
        dump(&*chip, folder)?;
    }
    if let Some((path, picture)) = strip {
        write_png(path, &picture)?;
    }
    let report = Report {
        program: &bench.opened.program.file,
        chip: &*chip,
        arithmetic: bench.arithmetic,
        frames,
        packet: &packet,
        light: &bench.observation,
        warnings: &warnings,
    };
    if arguments.json {
        super::say(&format!("{}\n", report.json()));
    } else {
        super::say(&report.table());
        if let Some(path) = &arguments.events {
            super::say(&super::convert::opened(path));
        }
    }
    Ok(())
}

/// A program and all that it needs to run, once or several times.
pub(super) struct Bench<'a> {
    arguments: &'a Arguments,
    pub opened: Opened,
    planes: Vec<Set>,
    size: Size,
    /// What was seen of its light.
    observation: Observation,
    /// Bytes of the frames of its light.
    frames: u128,
    arithmetic: Arithmetic,
    settings: Settings,
    schedule: Schedule,
    threads: usize,
}

/// One frame on its way to the chip, exposed already.
pub(super) struct Moment<'a> {
    /// Which one, from 0.
    pub index: u64,
    /// When.
    pub t: Micros,
    /// What is to run: the whole program if it is bare, else `init` or `frame`.
    pub steps: &'a [Step],
    /// Whether that is `init`.
    is_init: bool,
}

fn finite(what: &str, value: f64) -> miette::Result<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(miette!(help = "give a number", "{what} is {value}"))
}

/// A register and what it is set to.
struct Set {
    name: String,
    path: PathBuf,
    register: Register,
    plane: Plane<f64>,
}

/// What falls on the photodiodes.
struct Light {
    scene: Option<Box<dyn Scene>>,
    frames: Option<u64>,
    fps: f64,
}

/// The registers that are dumped, with their names.
fn dumped(device: &Device) -> Vec<(Register, String)> {
    let registers = device.registers();
    let analog = (0..)
        .zip(&registers.analog)
        .map(|(i, _)| Register::Analog(Analog(i)));
    let digital = (0..)
        .zip(&registers.digital)
        .map(|(i, _)| Register::Digital(Digital(i)));
    let all = analog.chain(digital).chain([Register::Flag]);
    all.map(|register| (register, register.name(device)))
        .collect()
}

/// The files of a register that is dumped.
fn named(folder: &Path, register: &str) -> [PathBuf; 2] {
    ["npy", "png"].map(|ending| folder.join(format!("{register}.{ending}")))
}

/// Writes every register, as numbers and as a picture.
fn dump(chip: &dyn Array, folder: &Path) -> miette::Result<()> {
    let (low, high) = (
        chip.device().value(Figure::Lowest),
        chip.device().value(Figure::Highest),
    );
    for (register, name) in dumped(chip.device()) {
        let values = register.values(chip);
        let (black, white) = if register.is_bit() {
            (0.0, 1.0)
        } else {
            (low, high)
        };
        let [array, shown] = named(folder, &name);
        if register.is_bit() {
            write_npy(&array, &values.mapv(|bit| bit as u8))?;
        } else {
            write_npy(&array, &values)?;
        }
        write_png(&shown, &panel::frame(&values, black, white))?;
    }
    Ok(())
}

pub(super) fn write_npy<T: WritableElement>(path: &Path, plane: &Plane<T>) -> miette::Result<()> {
    save(path, |out| {
        plane
            .write_npy(out)
            .map_err(|e| io::Error::other(e.to_string()))
    })?;
    Ok(())
}

/// What the run gave.
struct Report<'a> {
    program: &'a str,
    chip: &'a dyn Array,
    arithmetic: Arithmetic,
    frames: u64,
    packet: &'a Packet,
    light: &'a Observation,
    warnings: &'a [Warning],
}
