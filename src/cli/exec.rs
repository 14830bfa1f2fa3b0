//! `amacrine exec`: a program on the array, and every register written out.

use std::{
    fs, io,
    ops::ControlFlow,
    path::{Path, PathBuf},
};

use miette::{WrapErr, miette};
use ndarray_npy::{ReadNpyError, ReadableElement, WritableElement, WriteNpyExt};
use serde_json::json;

use super::{opened::Opened, registers::Register, strip::Strip};
use crate::{
    array::{Arithmetic, Array, Ledger, Reading, Readings, RunError, Schedule, Settings},
    event::{Packet, Polarity, file},
    isa::{Analog, Device, Digital, Figure, text::nearest},
    picture::{panel, write_png},
    plane::{Plane, Size},
    program::{Expansion, Program, Step},
    save::save,
    scene::{ASSUMED_FPS, Frame, OpenOptions, Scene, open},
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
    image: Option<String>,
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
    /// In which order the array is worked on, which changes only the speed: plain, tiled, active
    #[arg(long)]
    schedule: Option<String>,
    /// On how many threads at most
    #[arg(long)]
    threads: Option<usize>,
    /// Write the events that were read out; the extension names the format (csv npy txt npz evt2 evt2.1 evt3 dat aedat2 aedat3 aedat4 es hdf5 parquet)
    #[arg(long)]
    events: Option<PathBuf>,
    /// Write every register into this folder, as .npy and .png
    #[arg(long)]
    dump: Option<PathBuf>,
    /// Write what registers hold after each line of the last frame, side by side (.png)
    #[arg(long, value_name = "FILE.png")]
    strip: Option<PathBuf>,
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

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    if let Some(events) = &arguments.events {
        file::Format::of(events)?;
    }
    let bench = Bench::new(arguments)?;
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
    let (packet, frames) = if arguments.debug {
        let mut debugger = super::debug::Debugger::new(&bench.opened);
        let seen = bench.watch(&mut *chip, |chip, moment, packet| {
            debugger.frame(chip, moment, packet)
        })?;
        debugger.end(&*chip)?;
        seen
    } else if arguments.strip.is_some() {
        bench.watch(&mut *chip, |chip, moment, packet| {
            strip.frame(&bench.opened, chip, moment, packet)?;
            Ok(ControlFlow::Continue(()))
        })?
    } else {
        bench.watch(&mut *chip, |chip, moment, packet| {
            moment.run(chip, packet)?;
            Ok(ControlFlow::Continue(()))
        })?
    };

    // Before anything is written: it may have nothing to show.
    let strip = match &arguments.strip {
        Some(path) => Some((path, strip.picture(&bench.opened)?)),
        None => None,
    };
    if let Some(path) = &arguments.events {
        file::write(path, &packet)?;
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

impl Moment<'_> {
    /// Runs all of it.
    pub fn run(&self, chip: &mut dyn Array, packet: &mut Packet) -> Result<(), RunError> {
        if self.is_init {
            chip.run_init(self.t, packet)
        } else {
            chip.run_frame(self.t, packet)
        }
    }
}

impl<'a> Bench<'a> {
    fn new(arguments: &'a Arguments) -> miette::Result<Self> {
        let figures: Vec<(Figure, f64)> = arguments
            .sets
            .iter()
            .filter_map(|set| match set {
                Assignment::Figure(figure, value) => Some((*figure, *value)),
                Assignment::Register(..) => None,
            })
            .collect();
        let opened = arguments.source.open(&figures)?;
        let Opened {
            program, device, ..
        } = &opened;
        let registers = arguments.sets.iter().filter_map(|set| match set {
            Assignment::Register(name, path) => Some(Set::read(device, name, path)),
            Assignment::Figure(..) => None,
        });
        let planes = registers.collect::<miette::Result<Vec<_>>>()?;
        let light = Light::open(arguments, program)?;
        let size = size(&planes, light.scene.as_deref(), program, device)?;
        // One step at a time has no use for any other.
        let schedule = match &arguments.schedule {
            _ if arguments.debug || arguments.strip.is_some() => Schedule::Plain,
            Some(name) => name.parse()?,
            None => Schedule::of(size),
        };
        let threads = arguments.threads;
        Ok(Self {
            schedule,
            threads: threads.unwrap_or_else(rayon::current_num_threads),
            size,
            arithmetic: arithmetic(arguments, program)?,
            settings: settings(arguments, program, device)?,
            arguments,
            planes,
            opened,
        })
    }

    /// A chip as switched on, its registers set.
    pub fn chip(&self, seed: u64) -> miette::Result<Box<dyn Array + Send>> {
        let Opened {
            program,
            device,
            expansion,
        } = &self.opened;
        let mut chip = self
            .arithmetic
            .with_seed(seed)
            .chip(
                &program.file,
                expansion.code.clone(),
                device,
                self.size,
                self.settings,
            )
            .wrap_err_with(|| format!("{} cannot run", program.file))?;
        chip.set_schedule(self.schedule, self.threads);
        for set in &self.planes {
            set.apply(&mut *chip)?;
        }
        Ok(chip)
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
        let mut light = Light::open(self.arguments, &self.opened.program)?;
        let Expansion { code, bare, .. } = &self.opened.expansion;
        let mut packet = Packet::new(chip.size(), chip.channels());
        let mut seen: Option<Frame> = None;
        let mut frames = 0;
        while light.frames.is_none_or(|asked| frames < asked) {
            let next = match &mut light.scene {
                Some(scene) => scene.next_frame()?,
                None => None,
            };
            let before = seen.as_ref().map(|frame| frame.seconds);
            let frame = match (next, seen.take()) {
                (Some(frame), _) => frame,
                // A still picture, or the dark, is there as long as it is asked for.
                (None, before) => {
                    let enough = light.frames.unwrap_or(if *bare { 1 } else { 2 });
                    if frames >= enough {
                        break;
                    }
                    Frame {
                        index: frames,
                        seconds: frames as f64 / light.fps,
                        light: before.map_or_else(|| Plane::zeros(self.size.shape()), |f| f.light),
                    }
                }
            };
            let t = Micros::from_seconds(frame.seconds);
            chip.begin_frame();
            chip.expose(&frame.light)?;
            match before {
                Some(before) => chip.wait(frame.seconds - before),
                None => packet.span.0 = t,
            }
            packet.span.1 = t;
            let is_init = !*bare && frames == 0;
            let moment = Moment {
                index: frames,
                t,
                steps: if is_init { &code.init } else { &code.frame },
                is_init,
            };
            frames += 1;
            if run(chip, &moment, &mut packet)?.is_break() {
                break;
            }
            seen = Some(frame);
        }
        Ok((packet, frames))
    }
}

fn arithmetic(arguments: &Arguments, program: &Program) -> miette::Result<Arithmetic> {
    let asked = arguments.domain.as_ref();
    let name = asked.or(program.settings.domain.as_ref());
    let arithmetic: Arithmetic = name.map_or("exact", String::as_str).parse()?;
    Ok(arithmetic.with_seed(arguments.seed))
}

fn settings(arguments: &Arguments, program: &Program, device: &Device) -> miette::Result<Settings> {
    let mut settings = Settings::of(device);
    let clip = arguments.clip.map(|clip| clip == Switch::On);
    settings.clip = clip.or(program.settings.clip).unwrap_or(settings.clip);
    let asked = arguments.edge.or(program.settings.edge);
    settings.edge = finite("--edge", asked.unwrap_or(settings.edge))?;
    settings.gain = finite("--gain", arguments.gain.unwrap_or(settings.gain))?;
    Ok(settings)
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

impl Set {
    fn read(device: &Device, name: &str, path: &Path) -> miette::Result<Self> {
        let register = Register::named(device, name)?;
        if register == Register::Pix {
            return Err(miette!(
                help = "light is given with --image",
                "--set {name}: the photodiodes are not set"
            ));
        }
        let plane = read_plane(path)?;
        let wrong = |value: &f64| match register {
            Register::Analog(_) | Register::Pix => !value.is_finite(),
            Register::Digital(_) | Register::Flag => *value != 0.0 && *value != 1.0,
        };
        if let Some(((y, x), value)) = plane.indexed_iter().find(|(_, value)| wrong(value)) {
            let want = match register {
                Register::Analog(_) | Register::Pix => "finite numbers",
                Register::Digital(_) | Register::Flag => "0 or 1",
            };
            return Err(miette!(
                help = format!("{name} holds {want} in every pixel"),
                "{}: {value} at [{y}, {x}]",
                path.display()
            ));
        }
        Ok(Self {
            name: name.to_owned(),
            path: path.to_owned(),
            register,
            plane,
        })
    }

    fn apply(&self, chip: &mut dyn Array) -> miette::Result<()> {
        let bits = || self.plane.mapv(|value| value == 1.0);
        match self.register {
            Register::Analog(register) => chip.set_analog(register, &self.plane),
            Register::Digital(register) => chip.set_digital(register, &bits()),
            Register::Flag => chip.set_flag(&bits()),
            Register::Pix => Ok(()),
        }
        .wrap_err_with(|| format!("--set {}={}", self.name, self.path.display()))
    }
}

/// Reads a plane of any numbers.
pub(super) fn read_plane(path: &Path) -> miette::Result<Plane<f64>> {
    fn of<T: ReadableElement + Copy>(
        bytes: &[u8],
        number: impl Fn(T) -> f64,
    ) -> Result<Plane<f64>, ReadNpyError> {
        use ndarray_npy::ReadNpyExt;
        let plane = Plane::<T>::read_npy(bytes)?;
        Ok(plane.map(|value| number(*value)))
    }
    let shown = path.display();
    let bytes = fs::read(path).map_err(|e| {
        miette!(
            help = "give a .npy of shape (H,W), as numpy.save writes it",
            "{shown}: {e}"
        )
    })?;
    let bytes = bytes.as_slice();
    let mut result = of::<f64>(bytes, |v| v);
    // Every kind of number that numpy saves; which one it is stands in the header.
    macro_rules! or_else {
        ($($kind:ty),*) => {$(
            if let Err(ReadNpyError::WrongDescriptor(_)) = result {
                result = of::<$kind>(bytes, |v| v as f64);
            }
        )*};
    }
    or_else!(f32, i64, i32, i16, i8, u64, u32, u16, u8);
    if let Err(ReadNpyError::WrongDescriptor(_)) = result {
        result = of::<bool>(bytes, |v| if v { 1.0 } else { 0.0 });
    }
    let plane = result.map_err(|e| {
        miette!(
            help = "give a .npy of shape (H,W) with real numbers, as numpy.save writes it",
            "{shown}: {e}"
        )
    })?;
    if plane.is_empty() {
        return Err(miette!(
            help = "a plane has at least one pixel",
            "{shown}: a plane of {}",
            Size::of(&plane)
        ));
    }
    Ok(plane)
}

/// What falls on the photodiodes.
struct Light {
    scene: Option<Box<dyn Scene>>,
    frames: Option<u64>,
    fps: f64,
}

impl Light {
    fn open(arguments: &Arguments, program: &Program) -> miette::Result<Self> {
        let own = program.settings.image.as_ref().map(|image| {
            if image.starts_with("pattern:") {
                return image.clone();
            }
            arguments.source.folder().join(image).display().to_string()
        });
        let asked = arguments.fps.or(program.settings.fps);
        let scene = arguments
            .image
            .clone()
            .or(own)
            .map(|spec| open(&spec, &OpenOptions { fps: asked }))
            .transpose()?;
        let found = scene.as_deref().map_or(ASSUMED_FPS, <dyn Scene>::fps);
        let frames = arguments.frames.or(program.settings.frames);
        if frames == Some(0) {
            return Err(miette!(
                help = "the first frame runs `init`, every later one `frame`",
                "--frames 0: nothing would run"
            ));
        }
        Ok(Self {
            scene,
            frames,
            fps: asked.unwrap_or(found),
        })
    }
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
    const LARGEST: usize = 4096;
    let fits = |n| (1..=LARGEST).contains(&n);
    if fits(size.height) && fits(size.width) {
        return Ok(size);
    }
    Err(miette!(
        help = format!("height and width must be from 1 to {LARGEST}"),
        "an array of {size}"
    ))
}

/// Writes every register, as numbers and as a picture.
fn dump(chip: &dyn Array, folder: &Path) -> miette::Result<()> {
    fs::create_dir_all(folder).map_err(|e| {
        miette!(
            help = "give a folder that can be made",
            "{}: {e}",
            folder.display()
        )
    })?;
    let registers = chip.device().registers();
    let (low, high) = (
        chip.device().value(Figure::Lowest),
        chip.device().value(Figure::Highest),
    );
    let analog = (0..)
        .zip(&registers.analog)
        .map(|(i, _)| Register::Analog(Analog(i)));
    let digital = (0..)
        .zip(&registers.digital)
        .map(|(i, _)| Register::Digital(Digital(i)));
    for register in analog.chain(digital).chain([Register::Flag]) {
        let name = register.name(chip.device());
        let values = register.values(chip);
        let (black, white) = if register.is_bit() {
            (0.0, 1.0)
        } else {
            (low, high)
        };
        let path = folder.join(format!("{name}.npy"));
        if register.is_bit() {
            write_npy(&path, &values.mapv(|bit| bit as u8))?;
        } else {
            write_npy(&path, &values)?;
        }
        let picture = panel::frame(&values, black, white);
        write_png(&folder.join(format!("{name}.png")), &picture)?;
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
}

impl Report<'_> {
    fn on_and_off(&self) -> (usize, usize) {
        let events = &self.packet.events;
        let on = events.iter().filter(|e| e.polarity == Polarity::On).count();
        (on, events.len() - on)
    }

    fn json(&self) -> serde_json::Value {
        let ledger = self.chip.ledger();
        let cost = ledger.cost(self.chip.device());
        let (on, off) = self.on_and_off();
        let readings: Vec<_> = self
            .chip
            .readings()
            .iter()
            .map(|reading| {
                let value = match &reading.values {
                    Readings::Analog { columns, values } => {
                        json!({"columns": columns, "adc": values})
                    }
                    Readings::Digital { columns, values } => {
                        json!({"columns": columns, "bits": values})
                    }
                    Readings::Box(found) => json!({"box": found.map(|w| json!({
                        "top": w.top, "right": w.right, "bottom": w.bottom, "left": w.left
                    }))}),
                    Readings::Sum(sum) => json!({"sum": sum}),
                    Readings::Any(any) => json!({"any": any}),
                };
                json!({"line": reading.line, "value": value})
            })
            .collect();
        json!({
            "program": self.program,
            "chip": self.chip.device().name(),
            "domain": self.arithmetic.to_string(),
            "width": self.packet.size.width,
            "height": self.packet.size.height,
            "frames": self.frames,
            "words": cost.words,
            "words_by_clock": {
                "analog": ledger.analog,
                "digital": ledger.digital,
                "dnews": ledger.dnews,
                "prop": ledger.prop,
            },
            "array_us": cost.array_us,
            "host_us": cost.host_us,
            "slots": ledger.slots,
            "events": self.packet.events.len(),
            "on": on,
            "off": off,
            "dropped": self.packet.dropped,
            "ambiguous": ledger.ambiguous,
            "readings": readings,
        })
    }

    fn table(&self) -> String {
        let ledger = self.chip.ledger();
        let cost = ledger.cost(self.chip.device());
        let Ledger {
            analog,
            digital,
            dnews,
            prop,
            ..
        } = ledger;
        let (on, off) = self.on_and_off();
        let mut lines = vec![
            format!(
                "program  {} on {}, {}, {}",
                self.program,
                self.chip.device().name(),
                self.packet.size,
                self.arithmetic
            ),
            format!("frames   {}", self.frames),
            format!(
                "words    {} ({analog} analog, {digital} digital, {dnews} DNEWS, {prop} PROP)",
                cost.words.0
            ),
            format!(
                "time     {:.1} us on the array, {:.1} us on the host",
                cost.array_us, cost.host_us
            ),
        ];
        if ledger.slots > 0 {
            lines.push(format!(
                "events   {} ({on} ON, {off} OFF) in {} slots",
                self.packet.events.len(),
                ledger.slots
            ));
        }
        if ledger.missed > 0 {
            lines.push(format!(
                "note     {} set pixels found no slot",
                ledger.missed
            ));
        }
        if ledger.ambiguous > 0 {
            let (count, plural, it) = match ledger.ambiguous {
                1 => (1, "", "it"),
                count => (count, "s", "them"),
            };
            lines.push(format!(
                "note     {count} event{plural} at the chip's (0,0), the top right pixel, kept here: a host that takes (0,0) for the end of the list would lose {it}"
            ));
        }
        for reading in self.chip.readings() {
            lines.push(format!("read     {}", self::reading(reading)));
        }
        lines.join("\n") + "\n"
    }
}

/// A reading of the host, in a line.
pub(super) fn reading(reading: &Reading) -> String {
    let what = match &reading.values {
        Readings::Analog { values, .. } => match values[..] {
            [value] => format!("ADC {value}"),
            _ => format!("{} ADC values (--json lists them)", values.len()),
        },
        Readings::Digital { values, .. } => {
            format!("{} bits (--json lists them)", values.len())
        }
        Readings::Box(None) => "no pixel is set".to_owned(),
        Readings::Box(Some(w)) => format!(
            "box from row {}, column {} to row {}, column {} (the chip's count)",
            w.top, w.right, w.bottom, w.left
        ),
        Readings::Sum(sum) => format!("sum {sum}"),
        Readings::Any(any) => format!("any {any}"),
    };
    format!("line {}: {what}", reading.line)
}
