//! `amacrine exec`: a program on the array, and every register written out.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use miette::{IntoDiagnostic, WrapErr, miette};
use ndarray_npy::{ReadNpyError, ReadableElement, WritableElement, WriteNpyExt};
use serde_json::json;

use crate::{
    array::{Arithmetic, Array, Ledger, Readings, Schedule, Settings},
    event::{Packet, Polarity, file},
    isa::{Analog, Bit, Device, Digital, Figure, Source, Value},
    picture::{panel, write_png},
    plane::{Plane, Size},
    program::{Expansion, Overrides, Program},
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
    /// The program; a file of bare statements is a whole program, run once
    program: PathBuf,
    /// Set a register before the program runs: a .npy of shape (H,W); can be given more than once
    #[arg(long = "set", value_name = "REGISTER=FILE.npy", value_parser = assignment)]
    sets: Vec<(String, PathBuf)>,
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
    /// A shipped chip by name, or the folder of another
    #[arg(long)]
    chip: Option<String>,
    /// In which order the array is worked on, which changes only the speed: plain, tiled, active
    #[arg(long)]
    schedule: Option<String>,
    /// On how many threads at most
    #[arg(long)]
    threads: Option<usize>,
    /// Set a constant of the program; can be given more than once
    #[arg(long = "const", value_name = "NAME=VALUE", value_parser = super::asm::constant)]
    constants: Vec<(String, f64)>,
    /// Write the events that were read out (.csv, .npy, .txt)
    #[arg(long)]
    events: Option<PathBuf>,
    /// Write every register into this folder, as .npy and .png
    #[arg(long)]
    dump: Option<PathBuf>,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Switch {
    On,
    Off,
}

/// `name=file`, for the command line.
fn assignment(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, file)) if !name.is_empty() && !file.is_empty() => {
            Ok((name.to_owned(), file.into()))
        }
        _ => Err(format!("`{text}` is not REGISTER=FILE.npy")),
    }
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    if let Some(events) = &arguments.events {
        file::Format::of(events)?;
    }
    let (program, device, expansion) = read_program(arguments)?;
    let planes = arguments
        .sets
        .iter()
        .map(|(name, path)| Set::read(&device, name, path))
        .collect::<miette::Result<Vec<_>>>()?;
    let mut light = Light::open(arguments, &program)?;
    let size = size(&planes, light.scene.as_deref(), &program, &device)?;
    let arithmetic = arithmetic(arguments, &program)?;
    let settings = settings(arguments, &program, &device)?;
    let name = program.file.clone();
    let mut chip = arithmetic
        .chip(&name, expansion.code.clone(), &device, size, settings)
        .wrap_err_with(|| format!("{name} cannot run"))?;
    let schedule = match &arguments.schedule {
        Some(name) => name.parse()?,
        None => Schedule::of(size),
    };
    let threads = arguments.threads.unwrap_or_else(rayon::current_num_threads);
    chip.set_schedule(schedule, threads);
    for set in &planes {
        set.apply(&mut *chip)?;
    }
    let (packet, frames) = watch(&mut *chip, &mut light, &expansion, size)?;

    if let Some(path) = &arguments.events {
        file::write(path, &packet)?;
    }
    if let Some(folder) = &arguments.dump {
        dump(&*chip, folder)?;
    }
    let report = Report {
        program: &name,
        chip: &*chip,
        arithmetic,
        frames,
        packet: &packet,
    };
    if arguments.json {
        super::say(&format!("{}\n", report.json()));
    } else {
        super::say(&report.table());
    }
    Ok(())
}

fn read_program(arguments: &Arguments) -> miette::Result<(Program, Device, Expansion)> {
    let file = arguments.program.display().to_string();
    let text = fs::read_to_string(&arguments.program)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot read {file}"))?;
    let program = Program::parse(&file, &text)?;
    let chip = arguments.chip.as_ref().or(program.settings.chip.as_ref());
    let device = Device::find(chip.map_or("scamp5", String::as_str))?;
    let overrides: Overrides = arguments.constants.iter().cloned().collect();
    let expansion = program.expand(&device, &overrides)?;
    if let Some(warnings) = program.warnings(&expansion) {
        eprintln!("{:?}", miette!(warnings));
    }
    Ok((program, device, expansion))
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

#[derive(Clone, Copy)]
enum Register {
    Analog(Analog),
    Digital(Digital),
    Flag,
}

impl Set {
    fn read(device: &Device, name: &str, path: &Path) -> miette::Result<Self> {
        let register = match device.value_of(name) {
            Some(Value::Source(Source::Register(register))) => Register::Analog(register),
            Some(Value::Bit(Bit::Register(register))) => Register::Digital(register),
            Some(Value::Bit(Bit::Flag)) => Register::Flag,
            _ => {
                let registers = device.registers();
                let names = registers.analog.iter().chain(&registers.digital);
                let names: Vec<_> = names.map(String::as_str).collect();
                return Err(miette!(
                    help = format!(
                        "{} has {} and FLAG; light is given with --image",
                        device.name(),
                        names.join(" ")
                    ),
                    "--set {name}: no such register"
                ));
            }
        };
        let plane = read_plane(path)?;
        let wrong = |value: &f64| match register {
            Register::Analog(_) => !value.is_finite(),
            Register::Digital(_) | Register::Flag => *value != 0.0 && *value != 1.0,
        };
        if let Some(((y, x), value)) = plane.indexed_iter().find(|(_, value)| wrong(value)) {
            let want = match register {
                Register::Analog(_) => "finite numbers",
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
        }
        .wrap_err_with(|| format!("--set {}={}", self.name, self.path.display()))
    }
}

/// Reads a plane of any numbers.
fn read_plane(path: &Path) -> miette::Result<Plane<f64>> {
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
            let folder = arguments.program.parent().unwrap_or(Path::new(""));
            folder.join(image).display().to_string()
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

/// Shows the light to the chip; what it said, and how many frames it saw.
///
/// Bare statements run for every frame, once if nothing else is asked for; other programs run
/// `init` with the first frame and `frame` with the others.
fn watch(
    chip: &mut dyn Array,
    light: &mut Light,
    expansion: &Expansion,
    size: Size,
) -> miette::Result<(Packet, u64)> {
    let mut packet = Packet::new(chip.size(), chip.channels());
    let mut seen: Option<Frame> = None;
    let mut frames = 0;
    while light.frames.is_none_or(|asked| frames < asked) {
        let next = match &mut light.scene {
            Some(scene) => scene.next_frame()?,
            None => None,
        };
        let frame = match (next, seen.take()) {
            (Some(frame), _) => frame,
            // A still picture, or the dark, is there as long as it is asked for.
            (None, before) => {
                let enough = light.frames.unwrap_or(if expansion.bare { 1 } else { 2 });
                if frames >= enough {
                    break;
                }
                Frame {
                    index: frames,
                    seconds: frames as f64 / light.fps,
                    light: before.map_or_else(|| Plane::zeros(size.shape()), |f| f.light),
                }
            }
        };
        if expansion.bare {
            let t = Micros::from_seconds(frame.seconds);
            chip.expose(&frame.light)?;
            chip.run_frame(t, &mut packet)?;
            packet.span.1 = t;
        } else {
            chip.watch(&frame, &mut packet)?;
        }
        frames += 1;
        seen = Some(frame);
    }
    Ok((packet, frames))
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
    for (name, register) in registers.analog.iter().zip(0..) {
        let values = chip.analog(Analog(register));
        write_npy(&folder.join(format!("{name}.npy")), &values)?;
        write_png(
            &folder.join(format!("{name}.png")),
            &panel::frame(&values, low, high),
        )?;
    }
    let bits = registers
        .digital
        .iter()
        .zip(0..)
        .map(|(name, register)| (name.as_str(), chip.digital(Digital(register))));
    for (name, bits) in bits.chain([("FLAG", chip.flag())]) {
        write_npy(&folder.join(format!("{name}.npy")), &bits.mapv(u8::from))?;
        let picture = bits.mapv(|bit| f64::from(u8::from(bit)));
        write_png(
            &folder.join(format!("{name}.png")),
            &panel::frame(&picture, 0.0, 1.0),
        )?;
    }
    Ok(())
}

fn write_npy<T: WritableElement>(path: &Path, plane: &Plane<T>) -> miette::Result<()> {
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
            lines.push(format!(
                "note     {} events at the chip's (0,0), the top right pixel: the chip's host takes (0,0) for the end of the list",
                ledger.ambiguous
            ));
        }
        for reading in self.chip.readings() {
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
            lines.push(format!("read     line {}: {what}", reading.line));
        }
        lines.join("\n") + "\n"
    }
}
