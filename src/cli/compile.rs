//! `amacrine compile`: kernels to a program, and the proof.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    time::Instant,
};

use miette::{IntoDiagnostic, WrapErr, miette};
use serde_json::json;

use crate::{
    array::{
        Array as _, Chip, Errors, Exact, Input, Settings,
        range::{self, Inputs, Interval},
        taps,
    },
    compile::{
        CompileError, Effort, Filter, Kind, Memory, Noise, Request, SensorProgram, snake_words,
    },
    event::Packet,
    isa::{Analog, Device, Figure, Source, Value},
    kernel::{Kernel, quantise::Quantiser},
    photoreceptor::Curve,
    plane::{Plane, Size},
    program::{Action, Code, Cost, Expansion, Overrides, Program, Step, for_each, stored},
    reference::{Border, MemoryRule},
    save::save,
    sensor::Sensor as _,
    unit::Micros,
};

use super::quantise::Total;

/// What `compile` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine compile sobel-x --filter-only\n  amacrine compile kernels/csdvs-3.toml --threshold 16 -o csdvs.scamp"
)]
pub struct Arguments {
    /// Kernels: files (.toml, .npy of shape (k,k) or (K,k,k)) or names of built-in ones
    #[arg(required_unless_present = "sensor")]
    kernels: Vec<String>,
    /// Write the program here; else it is printed
    #[arg(short, long, value_name = "FILE.scamp")]
    output: Option<PathBuf>,
    /// The weights that the program has: `exact` takes them as they are, a quantiser (see
    /// `amacrine quantise --help`) brings them to few values; its scale goes into the thresholds
    #[arg(long, default_value = "exact", value_name = "QUANTISER")]
    to: To,
    /// What quantised kernels must sum to
    #[arg(long, value_enum, default_value = "free")]
    sum: Total,
    /// Only the filter, from register A into A, as bare statements
    #[arg(long, conflicts_with_all = ["sensor", "threshold"])]
    filter_only: bool,
    /// The registers of the results, with --filter-only
    #[arg(long, value_delimiter = ',', requires = "filter_only")]
    into: Vec<String>,
    /// Registers that stay as they are, with --filter-only
    #[arg(long, value_delimiter = ',', requires = "filter_only")]
    keep: Vec<String>,
    /// What the input can be, in LSB, with --filter-only: it is halved until nothing saturates
    #[arg(long, value_name = "LO..HI", requires = "filter_only", value_parser = interval, allow_hyphen_values = true)]
    input: Option<(f64, f64)>,
    /// With --filter-only: right up to the border, zeros beyond it, if that can be had
    #[arg(long, requires = "filter_only")]
    border: bool,
    /// A sensor file: its kernels and thresholds
    #[arg(long, value_name = "SENSOR.toml", conflicts_with_all = ["kernels", "threshold"])]
    sensor: Option<PathBuf>,
    /// Events where kernel times light (0 to 255) moved by more than this
    #[arg(long)]
    threshold: Option<f64>,
    /// Where the program remembers: `analogue` registers, or `bits:N` one-bit registers a kind
    #[arg(
        long,
        default_value = "analogue",
        value_name = "WHERE",
        conflicts_with = "filter_only"
    )]
    memory: Remembered,
    /// A shipped chip by name, or the folder of another
    #[arg(long, default_value = "scamp5")]
    chip: String,
    /// How long to search, in seconds of two cores of 2024
    #[arg(long, default_value_t = 2.5, value_parser = seconds)]
    effort: f64,
    /// Another seed may find another program
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

/// Longer filters are proved by an impulse.
const TRACED: usize = 100;

/// `lo..hi`, for the command line.
fn interval(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("`{text}` is not LO..HI, such as 0..127");
    let (low, high) = text.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match (number(low), number(high)) {
        (Some(low), Some(high)) if low < high => Ok((low, high)),
        _ => Err(wrong()),
    }
}

/// An effort, for the command line.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if (0.0..=3600.0).contains(&value) => Ok(value),
        _ => Err(format!(
            "`{text}` is not a number of seconds from 0 to 3600"
        )),
    }
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let began = Instant::now();
    let device = Device::find(&arguments.chip)?;
    let asked = Asked::read(arguments)?;
    let compiled = if arguments.filter_only {
        filter_only(arguments, &asked, &device)?
    } else {
        whole(arguments, &asked, &device)?
    };
    if let Some(path) = &arguments.output {
        save(path, |w| w.write_all(compiled.text.as_bytes()))?;
    }
    let seconds = began.elapsed().as_secs_f64();
    if arguments.json {
        super::say(&format!("{}\n", compiled.json(&asked, &device, seconds)));
        return Ok(());
    }
    if arguments.output.is_none() {
        super::say(&compiled.text);
        super::say("\n");
    }
    super::say(&compiled.account(&asked, &device, seconds));
    if let Some(to) = arguments.to.0 {
        let scales: Vec<String> = asked.scales.iter().map(|s| format!("{s:.4}")).collect();
        super::say(&format!(
            "levels    {to}; times {} they are the kernel: thresholds are divided by it\n",
            scales.join(", ")
        ));
    }
    Ok(())
}

/// What is to be compiled.
struct Asked {
    kernels: Vec<Kernel>,
    /// What they are to be multiplied by.
    scales: Vec<f64>,
    /// Given as one array of three axes.
    stacked: bool,
    /// ON and OFF, in kernel times light.
    thresholds: Vec<(f64, f64)>,
    title: String,
}

impl Asked {
    fn read(arguments: &Arguments) -> miette::Result<Self> {
        if let Some(path) = &arguments.sensor {
            return Self::of_sensor(path, arguments);
        }
        let mut kernels = Vec::new();
        let mut stacked = arguments.kernels.len() > 1;
        for name in &arguments.kernels {
            let (more, axes) = super::kernels::read(name)?;
            kernels.extend(more);
            stacked |= axes == 3;
        }
        if !arguments.filter_only && arguments.threshold.is_none() {
            return Err(miette!(
                help = "give --threshold T or --sensor FILE for a whole program, or --filter-only for the filter alone",
                "a program needs a threshold"
            ));
        }
        let threshold = arguments.threshold.unwrap_or(0.0);
        if !(threshold >= 0.0 && threshold.is_finite()) {
            return Err(miette!(
                help = "give zero or a positive number",
                "the threshold is {threshold}"
            ));
        }
        Self {
            thresholds: vec![(threshold, threshold); kernels.len()],
            scales: vec![1.0; kernels.len()],
            kernels,
            stacked,
            title: format!("events of {}", arguments.kernels.join(", ")),
        }
        .prepared(arguments)
    }

    fn of_sensor(path: &Path, arguments: &Arguments) -> miette::Result<Self> {
        let description = super::run::read_sensor(path)?;
        let shown = path.display();
        let linear = match description.response.curve {
            Curve::Identity => 1.0,
            Curve::Linear { white } => white,
            Curve::Log { .. } | Curve::LinLog { .. } => {
                return Err(miette!(
                    help = "the chip's photodiode is linear: give a sensor with `response = {{ linear = … }}`",
                    "{shown}: its response is not linear"
                ));
            }
        };
        if description.memory != MemoryRule::FilteredSnap {
            return Err(miette!(
                help = "one decision a frame stores what was seen: give a sensor with `memory = \"filtered-snap\"`",
                "{shown}: its memory is not filtered-snap"
            ));
        }
        let mut kernels = Vec::new();
        let mut thresholds = Vec::new();
        for channel in &description.channels {
            let ([kernel], [threshold]) = (&channel.kernels[..], &channel.thresholds[..]) else {
                return Err(miette!(
                    help = "give every kind of cell one kernel; all pixels of the array run the same program",
                    "{shown}: a channel has a pattern of kernels"
                ));
            };
            if channel.surrounds.is_some() {
                return Err(miette!(
                    help = "give the channel a kernel; `amacrine mesh fit` tells which kernels a mesh carries",
                    "{shown}: a channel sees through a resistor mesh, which is no program"
                ));
            }
            kernels.push(kernel.clone());
            thresholds.push((threshold.on * linear, threshold.off * linear));
        }
        if description.border == Border::Replicate {
            eprintln!("note: {shown} replicates the border; off the array the chip sees 0");
        }
        Self {
            scales: vec![1.0; kernels.len()],
            kernels,
            stacked: true,
            thresholds,
            title: description.name,
        }
        .prepared(arguments)
    }

    /// With the weights that the program will have; the scale of each kernel goes into its
    /// thresholds.
    fn prepared(mut self, arguments: &Arguments) -> miette::Result<Self> {
        let Some(to) = arguments.to.0 else {
            return Ok(self);
        };
        for (i, kernel) in self.kernels.iter_mut().enumerate() {
            let quantised = to.quantise(kernel, arguments.sum.into(), arguments.seed)?;
            let quantised = if arguments.filter_only {
                quantised
            } else {
                quantised.within_one()
            };
            let scale = quantised.scale;
            (*kernel, self.scales[i]) = (quantised.levels, scale);
            let (on, off) = self.thresholds[i];
            self.thresholds[i] = (on / scale, off / scale);
        }
        Ok(self)
    }
}

/// `exact`, or a quantiser.
#[derive(Clone, Copy, Debug)]
struct To(Option<Quantiser>);

impl std::str::FromStr for To {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if name == "exact" {
            return Ok(Self(None));
        }
        super::quantise::quantiser(name).map(|to| Self(Some(to)))
    }
}

/// `analogue`, or `bits:N`.
#[derive(Clone, Copy, Debug)]
struct Remembered(Memory);

impl std::str::FromStr for Remembered {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if name == "analogue" {
            return Ok(Self(Memory::Analogue));
        }
        let bits = name
            .strip_prefix("bits:")
            .and_then(|bits| bits.parse().ok());
        let memory = bits.filter(|bits| (1..=8).contains(bits)).map(Memory::Bits);
        memory.map(Self).ok_or_else(|| {
            format!(
                "`{name}` is neither `analogue` nor `bits:N` with N from 1 to 8, such as bits:4"
            )
        })
    }
}

/// A program that was proved.
struct Compiled {
    text: String,
    expansion: Expansion,
    filter: Filter,
    /// Weights by which the results differ from the kernels, a power of two.
    scale: f64,
    /// The kernels as read back from the program, without the scale.
    kernels: Vec<Plane<f64>>,
    /// What the results may be, in LSB.
    results: Vec<Interval>,
    /// ON and OFF of each kernel, in LSB of its result; of the filter alone none.
    thresholds: Vec<[f64; 2]>,
    saturations: usize,
    results_in: Vec<Analog>,
    snake: u64,
}

fn filter_only(arguments: &Arguments, asked: &Asked, device: &Device) -> miette::Result<Compiled> {
    let mut request = request(arguments, asked, device)?;
    if !arguments.into.is_empty() {
        request.into = named(&arguments.into, device)?;
    }
    request.keep = named(&arguments.keep, device)?;
    check_registers(&request, asked)?;
    request.border = arguments.border;
    request.range = arguments.input;
    let filter = request.filter()?;
    let text = filter.text(device, 0);
    let scale = 2f64.powi(-(filter.prescale as i32));
    let (low, high) = arguments.input.unwrap_or((0.0, 127.5));
    let proof = Proof {
        asked,
        device,
        results: &request.into,
        input: Input::Register(request.input),
        inputs: Inputs {
            registers: Interval::new(low, high),
            ..Inputs::default()
        },
        scale,
    };
    proof.compiled(text, filter, arguments.input.is_some())
}

fn whole(arguments: &Arguments, asked: &Asked, device: &Device) -> miette::Result<Compiled> {
    let kinds: Vec<Kind> = asked
        .kernels
        .iter()
        .zip(&asked.thresholds)
        .map(|(kernel, (on, off))| Kind {
            kernel: kernel.clone(),
            on: *on,
            off: *off,
        })
        .collect();
    let request = request(arguments, asked, device)?;
    let program = SensorProgram::new(&kinds, arguments.memory.0, &asked.title, &request)?;
    let proof = Proof {
        asked,
        device,
        results: &program.drives,
        input: Input::Light,
        // One more would saturate the capture itself.
        inputs: Inputs {
            light: Interval::new(0.0, 254.0),
            ..Inputs::default()
        },
        scale: program.scale,
    };
    let mut compiled = proof.compiled(program.text, program.filter, false)?;
    let thresholds = asked.thresholds.iter();
    compiled.thresholds = thresholds
        .map(|(on, off)| [on * program.scale, off * program.scale])
        .collect();
    let words = |steps: &[Step]| Cost::of(steps, device).words.0;
    let expectation = crate::program::Expectation {
        words: Some(crate::program::ExpectedWords {
            init: words(&compiled.expansion.code.init),
            frame: words(&compiled.expansion.code.frame),
        }),
        ..crate::program::Expectation::default()
    };
    let program = Program::parse("compiled", &compiled.text)?;
    compiled.text = program.blessed(&expectation).into_diagnostic()?;
    Ok(compiled)
}

fn request<'a>(
    arguments: &Arguments,
    asked: &'a Asked,
    device: &'a Device,
) -> miette::Result<Request<'a>> {
    let mut request = Request::new(&asked.kernels, device)?;
    request.effort = Effort::seconds(arguments.effort);
    request.seed = arguments.seed;
    Ok(request)
}

fn named(names: &[String], device: &Device) -> miette::Result<Vec<Analog>> {
    let one = |name: &String| match device.value_of(name.trim()) {
        Some(Value::Source(Source::Register(register))) if register != device.news() => {
            Ok(register)
        }
        _ => Err(miette!(
            help = "give analogue registers of the chip but NEWS, such as A,B",
            "{name} is no register that can hold a result on {}",
            device.name()
        )),
    };
    names.iter().map(one).collect()
}

fn check_registers(request: &Request<'_>, asked: &Asked) -> miette::Result<()> {
    let count = asked.kernels.len();
    if request.into.len() != count {
        return Err(miette!(
            help = "give --into as many registers as there are kernels",
            "there are {count} kernels and {} registers for them",
            request.into.len()
        ));
    }
    let twice = |(i, register): (usize, &Analog)| request.into[..i].contains(register);
    let kept = |register: &Analog| request.keep.contains(register);
    if request.into.iter().enumerate().any(twice) || request.into.iter().any(kept) {
        return Err(miette!(
            help = "name every result's register once, and none that is kept",
            "two values would lie in one register"
        ));
    }
    if request.keep.contains(&request.input) {
        return Err(miette!(
            help = "keep other registers; copy the input first where it is needed later",
            "the input's register cannot be kept"
        ));
    }
    Ok(())
}

/// The level at which mismatch is told, LSB.
const MIDDLE: f64 = 64.0;

/// Errors of the chip in one result, LSB.
#[derive(serde::Serialize)]
struct Added {
    temporal: f64,
    fixed: f64,
    input_temporal: Option<f64>,
    input_fixed: Option<f64>,
}

struct Proof<'a> {
    asked: &'a Asked,
    device: &'a Device,
    results: &'a [Analog],
    input: Input,
    inputs: Inputs,
    scale: f64,
}

impl Proof<'_> {
    /// Reads the kernels back from the text, and the ranges.
    fn compiled(&self, text: String, filter: Filter, limited: bool) -> miette::Result<Compiled> {
        let program = Program::parse("compiled", &text)?;
        let expansion = program.expand(self.device, &Overrides::default());
        let expansion = expansion.map_err(|faults| self.too_long(&filter, faults))?;
        let steps = &expansion.code.frame;
        let settings = Settings::of(self.device);
        let mut kernels = Vec::new();
        let long = filter.words.len() > TRACED;
        for (kernel, register) in self.asked.kernels.iter().zip(self.results) {
            let (read, others) = if long {
                (self.impulse(&expansion.code, *register)?, false)
            } else {
                let taps = taps::read(steps, self.device, settings, *register)
                    .wrap_err("the program cannot be read back")?;
                let others = taps.taps.keys().any(|(input, ..)| *input != self.input);
                (taps.kernel(self.input), others)
            };
            let unscale = 1.0 / self.scale;
            let found = Self::framed(&read, kernel.weights().dim());
            let found = found.map(|found| found.mapv(|w| w * unscale + 0.0));
            if others || found.as_ref() != Some(kernel.weights()) {
                return Err(miette!(
                    help = "this is a fault of amacrine: please report the kernel and the command",
                    "the compiled program computes another kernel than asked for"
                ));
            }
            kernels.extend(found);
        }
        let (results, saturations) = if long {
            let high = match self.input {
                Input::Light => self.inputs.light.high * settings.gain,
                Input::Register(_) => self.inputs.registers.high,
            };
            let most = filter.peak * high * 2f64.powi(-(filter.prescale as i32));
            (self.bounds(&kernels), usize::from(most > 127.0))
        } else {
            // What comes after the filter compares with a memory that may hold anything.
            let host = |step: &Step| matches!(step.action, Action::Host(_));
            let end = steps.iter().position(host).unwrap_or(steps.len());
            let filter = &steps[..end];
            let ranges = range::of(filter, self.device, settings, self.inputs)
                .wrap_err("the program's ranges cannot be told")?;
            let of = |r: &Analog| ranges.registers.get(usize::from(r.0)).copied();
            let results: Vec<Interval> = self.results.iter().filter_map(of).collect();
            (results, ranges.saturations.len())
        };
        if limited && saturations > 0 && !long {
            return Err(miette!(
                help = "this is a fault of amacrine: please report the kernel and the command",
                "the compiled program saturates for the input that it was made for"
            ));
        }
        Ok(Compiled {
            results,
            thresholds: Vec::new(),
            saturations,
            snake: snake_words(&self.asked.kernels)?,
            results_in: self.results.to_vec(),
            scale: self.scale,
            text,
            expansion,
            filter,
            kernels,
        })
    }

    /// What kernels make of the inputs.
    fn bounds(&self, kernels: &[Plane<f64>]) -> Vec<Interval> {
        let Interval { low, high } = match self.input {
            Input::Light => self.inputs.light,
            Input::Register(_) => self.inputs.registers,
        };
        let end = |kernel: &Plane<f64>, [least, most]: [f64; 2]| {
            let part = |w: &f64| if *w > 0.0 { w * most } else { w * least };
            self.scale * kernel.iter().map(part).sum::<f64>()
        };
        let bound = |kernel| Interval::new(end(kernel, [high, low]), end(kernel, [low, high]));
        kernels.iter().map(bound).collect()
    }

    /// The kernel by what one bright pixel leaves behind: for programs that reach too far to be
    /// read back as forms.
    fn impulse(&self, code: &Code, register: Analog) -> miette::Result<Plane<f64>> {
        const SIDE: usize = 64;
        let middle = (SIDE / 2, SIDE / 2);
        let settings = Settings::of(self.device);
        let left_by = |level: f64| -> miette::Result<Plane<f64>> {
            let mut picture = Plane::zeros((SIDE, SIDE));
            picture[middle] = level;
            let size = Size::new(SIDE, SIDE);
            let code = code.clone();
            let mut chip = Chip::new("compiled", Exact, code, self.device, size, settings)?;
            match self.input {
                Input::Light => chip.expose(&picture)?,
                Input::Register(register) => chip.set_analog(register, &picture)?,
            }
            let mut packet = Packet::new(size, chip.channels());
            chip.run_frame(Micros(0), &mut packet)?;
            Ok(chip.analog(register))
        };
        let (dark, bright) = (left_by(0.0)?, left_by(1.0)?);
        let reach = 15;
        let weight = |(y, x): (usize, usize)| {
            let at = (middle.0 + reach - y, middle.1 + reach - x);
            bright[at] - dark[at]
        };
        Ok(Plane::from_shape_fn((2 * reach + 1, 2 * reach + 1), weight))
    }

    /// Too many words, said with numbers; else what the program's check says.
    fn too_long(&self, filter: &Filter, faults: crate::isa::text::Faults) -> miette::Report {
        let room = self.device.value(Figure::Store) as u64;
        let words = filter.words.len() as u64;
        if words > room {
            return CompileError::Store {
                words,
                room,
                chip: self.device.name().to_owned(),
            }
            .into();
        }
        faults.into()
    }

    /// The weights in a plane of this shape; `None` where one lies outside.
    fn framed(found: &Plane<f64>, shape: (usize, usize)) -> Option<Plane<f64>> {
        let mut out = Plane::zeros(shape);
        let (height, width) = found.dim();
        for ((y, x), weight) in found.indexed_iter().filter(|(_, w)| **w != 0.0) {
            let y = (y + shape.0 / 2).checked_sub(height / 2)?;
            let x = (x + shape.1 / 2).checked_sub(width / 2)?;
            *out.get_mut((y, x))? = *weight;
        }
        Some(out)
    }
}

impl Compiled {
    fn statements(&self) -> u64 {
        let mut count = 0;
        for_each(&self.expansion.frame, &mut |_| count += 1);
        count
    }

    fn registers(&self) -> Vec<Analog> {
        let mut all: Vec<Analog> = self.filter.live.iter().flatten().copied().collect();
        all.extend(&self.results_in);
        all.sort_unstable();
        all.dedup();
        all
    }

    fn json(&self, asked: &Asked, device: &Device, seconds: f64) -> serde_json::Value {
        let cost = Cost::of(&self.expansion.code.frame, device);
        let rows = |plane: &Plane<f64>| -> Vec<Vec<f64>> {
            plane.rows().into_iter().map(|row| row.to_vec()).collect()
        };
        let stack: Vec<_> = self.kernels.iter().map(rows).collect();
        let kernel = match &stack[..] {
            [one] if !asked.stacked => json!(one),
            all => json!(all),
        };
        let names = |all: &[Analog]| -> Vec<String> {
            all.iter().map(|r| device.analog_name(*r)).collect()
        };
        let results = self.results.iter().map(|i| json!([i.low, i.high]));
        json!({
            "chip": device.name(),
            "words": cost.words.0,
            "macros": self.statements(),
            "registers": names(&self.registers()),
            "into": names(&self.results_in),
            "kernel": kernel,
            "scale": self.scale,
            "quantised_scales": asked.scales,
            "prescale_bits": self.filter.prescale,
            "filter_words": self.filter.words.len(),
            "snake_words": self.snake,
            "border": self.filter.border,
            "array_us": cost.array_us,
            "host_us": cost.host_us,
            "results_lsb": results.collect::<Vec<_>>(),
            "thresholds_lsb": self.thresholds,
            "saturating_stores": self.saturations,
            "holds_with_transfer_errors": self.filter.holds,
            "largest_input_lsb": 127.0 / self.filter.peak,
            "offset_stores": self.filter.offsets,
            "noise_lsb": self.noise(asked, device),
            "energy_uj": self.energy(device).0,
            "states": self.filter.states,
            "seconds": seconds,
            "text": self.text,
        })
    }

    /// What the filter adds to each result, and to the input for each.
    fn noise(&self, asked: &Asked, device: &Device) -> Vec<Added> {
        let noises = self
            .filter
            .noise(device, Analog(0), MIDDLE, &self.results_in);
        let added = |(noise, kernel): (Noise, &Kernel)| {
            let squares: f64 = kernel.weights().iter().map(|w| w * w).sum();
            let gain = self.filter_scale() * squares.sqrt();
            Added {
                temporal: noise.temporal,
                fixed: noise.fixed,
                input_temporal: (gain > 0.0).then(|| noise.temporal / gain),
                input_fixed: (gain > 0.0).then(|| noise.fixed / gain),
            }
        };
        noises.into_iter().zip(&asked.kernels).map(added).collect()
    }

    /// From an input in LSB to a result in LSB, but for the kernel.
    fn filter_scale(&self) -> f64 {
        2f64.powi(-(self.filter.prescale as i32))
    }

    /// Microjoules a frame at the highest frame rate, from the array's busy time alone to full
    /// power all the time; and that frame rate.
    fn energy(&self, device: &Device) -> ([f64; 2], f64) {
        let cost = Cost::of(&self.expansion.code.frame, device);
        let power = device.value(Figure::Power);
        (
            [power * cost.array_us, power * cost.micros()],
            1e6 / cost.micros(),
        )
    }

    /// The table for people.
    fn account(&self, asked: &Asked, device: &Device, seconds: f64) -> String {
        let cost = Cost::of(&self.expansion.code.frame, device);
        let mut text = String::new();
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "{name:<10}{what}");
        };
        line(
            "words",
            format!(
                "{} (the filter {}, a naive snake {})",
                cost.words.0,
                self.filter.words.len(),
                self.snake
            ),
        );
        let kept = stored(&self.expansion.code.init, device).0
            + stored(&self.expansion.code.frame, device).0;
        line(
            "store",
            format!("{kept} words of {}", device.value(Figure::Store)),
        );
        line(
            "time",
            format!(
                "{:.1} us on the array, {:.1} us on the host: at most {:.0} frames/s, of compute alone {:.0}",
                cost.array_us,
                cost.host_us,
                1e6 / cost.micros(),
                1e6 / cost.array_us
            ),
        );
        line(
            "proof",
            "the program was read back: it computes the kernel exactly".to_owned(),
        );
        for (register, result) in self.results_in.iter().zip(&self.results) {
            line(
                "result",
                format!(
                    "{} from {} to {} LSB",
                    device.analog_name(*register),
                    result.low,
                    result.high
                ),
            );
        }
        for (thresholds, scale) in self.thresholds.iter().zip(&asked.scales) {
            line("threshold", self.threshold(*thresholds, *scale, device));
        }
        line("range", self.range());
        let offsets = self.filter.offsets.iter().map(|o| format!("{o}"));
        line(
            "offset",
            format!(
                "{} transfer errors of one store stay in the result",
                offsets.collect::<Vec<_>>().join(", ")
            ),
        );
        for added in self.noise(asked, device) {
            let input = |lsb: Option<f64>| lsb.map_or("-".to_owned(), |lsb| format!("{lsb:.2}"));
            line(
                "noise",
                format!(
                    "the filter adds {:.2} LSB from frame to frame and {:.2} LSB from pixel to pixel; as an error of every input: {} and {} LSB (modelled, in part a guess; at {MIDDLE} LSB)",
                    added.temporal,
                    added.fixed,
                    input(added.input_temporal),
                    input(added.input_fixed),
                ),
            );
        }
        let ([least, most], rate) = self.energy(device);
        line(
            "energy",
            format!(
                "{least:.2} to {most:.2} uJ a frame at {rate:.0} frames/s: {} W (quoted) while the array is busy, or all the time; what it takes idle is not public",
                device.value(Figure::Power)
            ),
        );
        let border = if self.filter.border {
            "right up to the border, zeros beyond it"
        } else {
            "not right at the border, where the kernel leaves the array"
        };
        line("border", border.to_owned());
        line(
            "search",
            format!("{} states in {seconds:.1} s", self.filter.states),
        );
        text.push_str("\nregisters live over the filter's words\n");
        text.push_str(&self.chart(device));
        text
    }

    /// What the chip makes of a kernel's thresholds; `scale`: times its weights the kernel is
    /// the one asked for.
    fn threshold(&self, thresholds: [f64; 2], scale: f64, device: &Device) -> String {
        let step = Errors::of(device).input_step;
        let held = thresholds.map(|lsb| (lsb / step).round_ties_even() * step);
        let both = |[on, off]: [f64; 2], digits: usize| {
            if on == off {
                format!("{on:.digits$}")
            } else {
                format!("{on:.digits$} ON and {off:.digits$} OFF")
            }
        };
        let lost = (0..2).any(|k| thresholds[k] > 0.0 && held[k] == 0.0);
        let advice = if lost {
            format!(
                ": any change fires; take thresholds from {:.1} on, or a kernel that needs fewer halvings (--to)",
                step / self.scale * scale
            )
        } else {
            String::new()
        };
        format!(
            "{} LSB of the result, on the chip {}{advice}",
            both(thresholds, 3),
            both(held, 0),
        )
    }

    /// Whether anything saturates, and what that costs.
    fn range(&self) -> String {
        let range = match (self.saturations, self.filter.prescale) {
            (0, 0) => "nothing saturates".to_owned(),
            (0, bits) => format!(
                "nothing saturates; the input is halved {bits} times first, which costs {bits} bits"
            ),
            (n, _) => format!(
                "{n} stores can saturate; with inputs within ±{:.2} LSB none does (--input halves them)",
                127.0 / self.filter.peak
            ),
        };
        let errors = if self.filter.holds {
            ""
        } else {
            "; but the transfer errors of a real chip come on top, and no plan was found that keeps them in range: search longer (--effort), or take fewer digits (--to)"
        };
        range + errors
    }

    /// A row for each register, a column for each word.
    fn chart(&self, device: &Device) -> String {
        let mut text = String::new();
        for (start, part) in self.filter.live.chunks(64).enumerate() {
            if start > 0 {
                text.push('\n');
            }
            for register in self.registers() {
                let marks: String = part
                    .iter()
                    .map(|live| if live.contains(&register) { '#' } else { '.' })
                    .collect();
                let _ = writeln!(text, "  {:<4} {marks}", device.analog_name(register));
            }
        }
        text
    }
}
