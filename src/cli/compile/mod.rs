//! `amacrine compile`: kernels to a program, and the proof.

mod asked;
mod bounds;
mod compiled;
mod front;
mod nearest;
mod on_chip;
mod proof;
mod readout;
mod shared;

use std::{fmt::Write as _, time::Instant};

use miette::{IntoDiagnostic, miette};

use self::on_chip::OnChip;
use super::{
    arguments::{
        event_rate::NoRate,
        heading,
        light::{self, Samples},
        quantiser::Total,
    },
    complain,
    output::{
        content::Content,
        files::{self, Named, Output},
        progress::Progress,
    },
};
use crate::{
    array::{
        Input,
        range::{Inputs, Interval},
    },
    compile::{
        BitMemory, Border, CellKind, CompileError, DriveMemory, Effort, Filter, FilterNoise,
        Objective, Request, SensorProgram, Signal, brightest, naive_cost,
    },
    config::UnknownWord,
    isa::{Analog, Device, Figure, Source, Value},
    kernel::{Kernel, quantise::Quantiser},
    plane::Plane,
    program::{Cost, Expansion, Program, Step, cpp, is_cpp},
    rig::guard::Warning,
    save::save,
    study::defaults,
    unit::counted,
};

/// What `compile` is asked to do.
#[derive(Debug, clap::Args)]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line")]
#[command(
    mut_arg("fps", |fps| fps.requires("scene").conflicts_with("filter_only")),
    override_usage = "amacrine compile [OPTIONS] <KERNELS>...\n       amacrine compile [OPTIONS] --sensor <SENSOR.toml>",
    after_help = "Examples:\n  amacrine compile sobel-x --filter-only\n  amacrine compile csdvs-3 --threshold 16 -o csdvs.scamp\n  amacrine compile rgc-5x5 --to ternary --threshold 128 --events-per-frame 300 -o rgc.scamp\n  amacrine compile four.npy --to int-5 --threshold 128 --memory shared -o four.scamp\n  amacrine compile --sensor rgc-4-on-chip --to ternary -o four.scamp"
)]
pub struct Arguments {
    /// Kernels, one for each kind of cell: files or names of built-in ones
    ///
    /// Files are .toml, or .npy of shape (k,k), (K,k,k) or (K,1,k,k).
    #[arg(required_unless_present = "sensor", value_delimiter = ',')]
    kernels: Vec<Named>,
    #[command(flatten)]
    no_rate: NoRate,
    /// Write the program to this file, in place of printing it
    #[arg(short, long, value_name = "FILE.scamp|FILE.cpp", value_parser = Content::Program)]
    output: Option<Output>,
    /// Quantiser of the weights; `exact` takes them as they are
    ///
    /// The scale of the quantiser goes into the thresholds. `amacrine quantise --help` lists the
    /// quantisers.
    #[arg(long, default_value = "exact", value_name = "QUANTISER")]
    to: To,
    /// Sum of the quantised kernel
    #[arg(long, value_enum, default_value_t)]
    sum: Total,
    /// Compile the filter alone, from register A into A, as bare statements
    ///
    /// Excludes --sensor, --threshold, --memory, --readout, --events-per-frame and --scene.
    #[arg(long, conflicts_with_all = ["sensor", "threshold"], help_heading = heading::FILTER)]
    filter_only: bool,
    /// Registers of the results, one for each kernel
    #[arg(long, value_delimiter = ',', requires = "filter_only", conflicts_with_all = ["sensor", "threshold"], help_heading = heading::FILTER)]
    into: Vec<String>,
    /// Registers that must stay as they are
    #[arg(long, value_delimiter = ',', requires = "filter_only", conflicts_with_all = ["sensor", "threshold"], help_heading = heading::FILTER)]
    keep: Vec<String>,
    /// Range of the input in LSB, with --filter-only
    ///
    /// The program halves the input until nothing saturates. If left out, it halves only where that
    /// improves the result on the chip.
    #[arg(long, value_name = "LO..HI", requires = "filter_only", conflicts_with_all = ["sensor", "threshold"], value_parser = interval, allow_hyphen_values = true, help_heading = heading::FILTER)]
    input: Option<(f64, f64)>,
    /// Require results that are right up to the border, with zeros beyond it
    ///
    /// A whole program is refused if none is found. With --filter-only the search takes such a
    /// filter if it finds one. If left out, a whole program is right at the border only where that
    /// improves the result on the chip.
    #[arg(long, help_heading = heading::SEARCH)]
    border: bool,
    /// Sensor file that has the kernels and thresholds
    ///
    /// Excludes KERNELS and --threshold.
    #[arg(long, value_name = "SENSOR.toml", conflicts_with_all = ["kernels", "threshold"])]
    sensor: Option<files::Input>,
    /// Threshold in kernel times light (0 to 255): one for all kernels, or one for each
    ///
    /// A cell has an event when its drive has moved by more than this. The threshold holds for ON
    /// and OFF alike. (In `run`, two numbers are ON and OFF of all kinds.) Required, unless
    /// --sensor or --filter-only is given.
    #[arg(long, value_delimiter = ',', value_name = "THRESHOLDS")]
    threshold: Vec<f64>,
    /// Memory of the program: analogue, bits:N or shared
    ///
    /// `analogue` keeps the drive of each kind in analogue registers, `bits:N` in N one-bit
    /// registers. `shared` keeps one picture for all kinds in one analogue register: the pixel at
    /// the last event of any kind (raw-snap). Default: as the sensor file says, else analogue.
    #[arg(long, value_name = "WHERE", value_parser = memory, conflicts_with = "filter_only")]
    memory: Option<DriveMemory>,
    /// Events expected in the busiest frame, all signs and kinds together
    ///
    /// The readout is chosen for them. Excludes --scene.
    #[arg(
        long,
        value_name = "N",
        conflicts_with_all = ["filter_only", "scene"],
        value_parser = clap::value_parser!(u64).range(1..=1_000_000_000_000),
        help_heading = heading::READOUT,
    )]
    events_per_frame: Option<u64>,
    /// Scene on which the events are counted: a clip, image folder, .npy or pattern
    #[arg(long, conflicts_with = "filter_only", alias = "image", help_heading = heading::SCENE)]
    scene: Option<Named>,
    #[command(flatten)]
    samples: Samples,
    /// Readout: how the events leave the chip
    #[arg(long, value_enum, default_value_t, conflicts_with = "filter_only", help_heading = heading::READOUT)]
    readout: readout::Asking,
    /// Language of the program [default: by the ending of the output, else scamp]
    ///
    /// `amacrine asm` and `amacrine exec` read both.
    #[arg(long = "as", value_enum, value_name = "LANGUAGE")]
    language: Option<Language>,
    /// Name of a shipped chip, or folder of your own
    #[arg(long, default_value = defaults::CHIP)]
    chip: Named,
    /// Objective of the search
    #[arg(long, value_enum, default_value_t, help_heading = heading::SEARCH)]
    objective: Aim,
    /// Print the Pareto front of words and correlation on the chip, with --filter-only
    ///
    /// No filter of the list has both fewer words and a better correlation than another. Excludes
    /// --output, --as and --objective.
    #[arg(long, requires = "filter_only", conflicts_with_all = ["output", "language", "objective", "sensor", "threshold"], help_heading = heading::FILTER)]
    front: bool,
    /// Search effort, in seconds
    ///
    /// The unit is a second of two cores of 2024 for one 3x3 kernel; larger kernels, and several
    /// kernels, take several times as long. The program counts states of the search, not time: a
    /// slower computer takes longer and finds the same program.
    #[arg(long, default_value_t = Effort::SECONDS, value_parser = super::arguments::effort::seconds, help_heading = heading::SEARCH)]
    effort: f64,
    /// Seed of the search; another seed may find another program
    #[arg(long, default_value_t = 0, help_heading = heading::SEARCH)]
    seed: u64,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// What a program is to be best at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum Aim {
    /// Most events kept on the chip, as predicted, and nearly all kept without the chip's errors,
    /// too. With --memory shared this is `events`; for several kinds with a memory each, `exact`
    #[default]
    Silicon,
    /// Most events kept on the chip, as predicted. Strong light or change may saturate. For several
    /// kinds with a memory each this is `exact`
    Events,
    /// Best signal-to-noise ratio, as predicted, of filters that do not saturate for light up to
    /// 254 of 255. What is compared behind a filter may saturate. Without the chip's errors the
    /// program has the same events as the float model. (On SCAMP-5, 255 is beyond the range of a
    /// register.)
    Exact,
    /// Fewest words of a program that does not saturate (as with `exact`), and is right at the
    /// border if one is found. The default can have fewer words, but may saturate for strong light
    /// or change
    Words,
}

/// How a program is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Language {
    /// The language of programs/
    Scamp,
    /// C++ for the vendor's tools
    Cpp,
}

impl Arguments {
    /// How the program is written. The readers go by the ending too, so both must say the same.
    fn language(&self) -> miette::Result<Language> {
        let named = self
            .output
            .as_ref()
            .filter(|path| path.extension().is_some());
        let by_name = named.map(|path| {
            if is_cpp(&path.to_string_lossy()) {
                Language::Cpp
            } else {
                Language::Scamp
            }
        });
        match (self.language, by_name, &self.output) {
            (Some(asked), Some(named), Some(output)) if asked != named => {
                let asked = match asked {
                    Language::Scamp => "scamp",
                    Language::Cpp => "cpp",
                };
                let help = format!(
                    "name it {}, or leave out --as",
                    output.with_extension(asked).display()
                );
                Err(miette!(
                    help = help,
                    "--as {asked}, and {} would be read as another language by its ending",
                    output.display()
                ))
            }
            (asked, named, _) => Ok(asked.or(named).unwrap_or(Language::Scamp)),
        }
    }

    /// Refuses what samples mean where no scene has any.
    fn check_samples(&self) -> miette::Result<()> {
        match self.samples.written().first() {
            Some((name, _)) if self.scene.is_none() => Err(miette!(
                help = "give --scene too, or leave it out",
                "--{name} says what the samples of a scene mean, and there is no --scene"
            )),
            _ => Ok(()),
        }
    }
}

/// Longer filters are proved by an impulse.
const TRACED: usize = 100;

/// Words, times pixels around one that is looked at, times weights: beyond, ranges are bounds. It
/// takes some seconds.
const RANGED: u64 = 4_000_000;

/// `lo..hi`, for the command line.
fn interval(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("`{text}` is not LO..HI, such as 0..127");
    let (low, high) = text.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match (number(low), number(high)) {
        (Some(low), Some(high)) if low < high => Ok((low, high)),
        (Some(_), Some(_)) => Err(format!("`{text}`: the first must be below the second")),
        _ => Err(wrong()),
    }
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let began = Instant::now();
    let device = Device::find(&arguments.chip)?;
    let language = arguments.language()?;
    arguments.check_samples()?;
    let asked = Asked::read(arguments)?;
    if arguments.front {
        return front::print(arguments, &asked, &device);
    }
    readout::check_scene(arguments, &device)?;
    let progress = Progress::spinner("searching");
    let mut compiled = compiled(arguments, &asked, &device)
        .map_err(|refused| nearest::named(refused, arguments, &device))?;
    progress.finish();
    if language == Language::Cpp {
        let program = Program::parse("compiled", &compiled.text)?;
        compiled.text = cpp(&program, &device)?;
    }
    if let Some(path) = &arguments.output {
        save(path, |w| w.write_all(compiled.text.as_bytes()))?;
    }
    let seconds = began.elapsed().as_secs_f64();
    for warning in { compiled.warning(&asked.kernels, arguments.objective) }
        .into_iter()
        .chain(compiled.aimed(&asked.kernels, arguments.objective))
        .chain(compiled.unreached(&asked.names, &device))
        .chain(compiled.restless(&asked, &device))
    {
        complain(&warning);
    }
    light::warn(&asked.warnings);
    if arguments.json {
        super::say(&format!("{}\n", compiled.json(&asked, &device, seconds)));
        return Ok(());
    }
    let mut account = compiled.account(&asked, &device, seconds);
    if let Some(to) = arguments.to.0 {
        let scales: Vec<String> = asked.scales.iter().map(|s| format!("{s:.4}")).collect();
        let _ = writeln!(
            account,
            "levels    {to}; the program's kernel times {} is the one asked for: thresholds are divided by it",
            scales.join(", ")
        );
    }
    if arguments.output.is_some() {
        super::say(&account);
        return Ok(());
    }
    // What is printed is a program.
    let commented = |text: &str| text.lines().map(comment).collect::<String>();
    super::say(&compiled.text);
    super::say("\n");
    super::say(&commented(&account));
    Ok(())
}

/// A line as a comment of a program.
fn comment(line: &str) -> String {
    format!("{}\n", format!("// {line}").trim_end())
}

/// What is to be compiled.
struct Asked {
    kernels: Vec<Kernel>,
    /// What a sensor file calls each kind.
    names: Vec<Option<String>>,
    /// What messages call each kernel: its file, with a number where that holds several.
    sources: Vec<String>,
    /// What they are to be multiplied by.
    scales: Vec<f64>,
    /// What few values have taken from them.
    warnings: Vec<Warning>,
    /// Given as one array of three axes.
    stacked: bool,
    /// ON and OFF, in kernel times light.
    thresholds: Vec<(f64, f64)>,
    title: String,
    /// What the input can be, LSB, of the filter alone.
    input: Option<(f64, f64)>,
    /// What the sensor file remembers.
    memory: Option<DriveMemory>,
    /// What the program is to be best at.
    objective: Aim,
}

impl Asked {
    /// The input that a filter alone is run on: that which was given, else the one of which most is
    /// predicted to come out.
    fn signal(&self, filter: &Filter, request: &Request<'_>) -> Signal {
        let best = || filter.best_signal(request.device, &self.kernels);
        self.input.map_or_else(best, Signal::from_range)
    }

    /// What the program is to remember.
    fn remembered(&self, arguments: &Arguments) -> miette::Result<DriveMemory> {
        let asked = arguments.memory;
        let Some(own) = self.memory else {
            return Ok(asked.unwrap_or_default());
        };
        let is_shared = |memory: DriveMemory| memory == DriveMemory::Shared;
        match asked {
            Some(asked) if is_shared(asked) != is_shared(own) => Err(miette!(
                help = "leave --memory out, or change the sensor's memory: `filtered-snap` for analogue and bits, `raw-snap` with `shared = true` for shared",
                "the sensor file and --memory name different memories"
            )),
            Some(asked) => Ok(asked),
            None => Ok(own),
        }
    }
}

/// `exact`, which studies call `none`, or a quantiser.
#[derive(Clone, Copy, Debug)]
struct To(Option<Quantiser>);

impl std::str::FromStr for To {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if matches!(name, "exact" | "none") {
            return Ok(Self(None));
        }
        super::arguments::quantiser::quantiser(name).map(|to| Self(Some(to)))
    }
}

/// `analogue`, `shared` or `bits:N`: what `--memory` takes.
pub fn memory(name: &str) -> Result<DriveMemory, String> {
    name.parse().map_err(|UnknownWord { word, .. }| {
        format!(
            "`{word}` is none of `analogue`, `shared` and `bits:N` with N from 1 to 8, such as bits:5"
        )
    })
}

/// A program that was proved.
struct Compiled {
    text: String,
    expansion: Expansion,
    filter: Filter,
    /// Weights by which each result differs from its kernel, powers of two.
    scales: Vec<f64>,
    /// The kernels as read back from the program, without the scale.
    kernels: Vec<Plane<f64>>,
    /// What the results may be, in LSB.
    results: Vec<Interval>,
    /// ON and OFF of each kernel, in LSB of its result; of the filter alone none.
    thresholds: Vec<[f64; 2]>,
    saturations: usize,
    results_in: Vec<Analog>,
    snake: u64,
    /// Whether the range of the input is known.
    ranged: bool,
    /// Whether it was to be right at the border.
    to_border: bool,
    /// Each result in the chip's model.
    on_chip: Vec<OnChip>,
    /// What the filter adds to each result.
    noises: Vec<Added>,
    /// The filters, one after the other: with a shared memory one for each kind.
    filters: Vec<Filter>,
    /// What a whole program remembers.
    memory: Option<DriveMemory>,
    /// The memory of each kind, where it is in bits.
    in_bits: Vec<BitMemory>,
    /// The ways to read its events; of the filter alone none.
    readouts: Option<readout::Readouts>,
}

/// The filter alone, or the whole program.
fn compiled(arguments: &Arguments, asked: &Asked, device: &Device) -> miette::Result<Compiled> {
    if arguments.filter_only {
        filter_only(arguments, asked, device)
    } else {
        whole(arguments, asked, device)
    }
}

/// The filter that is asked for, alone.
fn bare<'a>(
    arguments: &Arguments,
    asked: &'a Asked,
    device: &'a Device,
) -> miette::Result<Request<'a>> {
    let mut request = request(arguments, &asked.kernels, device)?;
    if !arguments.into.is_empty() {
        request.into = named(&arguments.into, device)?;
    }
    request.keep = named(&arguments.keep, device)?;
    if arguments.into.is_empty() {
        request.into_free();
    }
    check_registers(&request, asked)?;
    request.range = asked.input;
    let ends = [Figure::Lowest, Figure::Highest].map(|end| device.value(end));
    // Half a level beyond is what light has at most.
    if let Some((low, high)) = asked
        .input
        .filter(|it| it.0 < ends[0] || it.1 > ends[1] + 0.5)
    {
        return Err(miette!(
            help = format!(
                "give what a register can hold, such as --input {}..{}",
                ends[0].max(0.0).min(ends[1]),
                ends[1]
            ),
            "--input {low}..{high}: a register holds {} to {} LSB",
            ends[0],
            ends[1]
        ));
    }
    Ok(request)
}

/// A filter that the chip stores; the shortest where the best is too long.
fn stored(filter: Filter, request: &Request<'_>) -> miette::Result<Filter> {
    let device = request.device;
    let words = filter.word_count(device);
    if CompileError::of_store(words, device).is_none() {
        return Ok(filter);
    }
    let shortest = Request {
        objective: Objective::Words,
        ..request.clone()
    };
    let shortest = shortest.filter()?;
    if let Some(error) = CompileError::of_store(shortest.word_count(device), device) {
        return Err(error.into());
    }
    complain(&format!(
        "warning: the best program has {}, more than {} holds: this is the shortest, as with --objective words\n",
        counted(words, "instruction word"),
        device.name()
    ));
    Ok(shortest)
}

fn filter_only(arguments: &Arguments, asked: &Asked, device: &Device) -> miette::Result<Compiled> {
    // Nothing comes out of one of zeros, and nothing is to be measured of it.
    check_weights(asked)?;
    let request = bare(arguments, asked, device)?;
    let filter = stored(request.filter()?, &request)?;
    let on_chip = OnChip::run(
        &filter,
        device,
        &request.into,
        asked.signal(&filter, &request),
    )?;
    let text = filter.alone(device);
    let scale = filter.scale();
    // All light, as far as a register holds it.
    let most = 255.0 * device.value(Figure::LightScale);
    let most = most.min(device.register_range().1 + 0.5);
    let (low, high) = asked.input.unwrap_or((0.0, most));
    let proof = Proof {
        kernels: &asked.kernels,
        device,
        results: &request.into,
        input: Input::Register(request.input),
        inputs: Inputs {
            registers: Interval::new(low, high),
            ..Inputs::from_device(device)
        },
        scale,
    };
    let compiled = proof.compiled(text, filter, asked.input.is_some())?;
    Ok(Compiled {
        ranged: asked.input.is_some(),
        to_border: arguments.border,
        on_chip,
        ..compiled
    })
}

fn whole(arguments: &Arguments, asked: &Asked, device: &Device) -> miette::Result<Compiled> {
    let kinds: Vec<CellKind> = asked
        .kernels
        .iter()
        .zip(&asked.thresholds)
        .zip(&asked.names)
        .map(|((kernel, (on, off)), name)| CellKind {
            name: name.clone(),
            kernel: kernel.clone(),
            on: *on,
            off: *off,
        })
        .collect();
    let memory = asked.remembered(arguments)?;
    check_weights(asked)?;
    let compiled = if memory == DriveMemory::Shared {
        shared::whole(arguments, asked, &kinds, device)?
    } else {
        apart(arguments, asked, &kinds, memory, device)?
    };
    if arguments.border && !compiled.filter.border {
        return Err(miette!(
            help = "search longer (--effort), ask for fewer kinds, use a chip with more registers (--chip scamp5-wide), or leave --border out: events then differ near the border alone",
            "no program was found whose filters are right up to the border of the array"
        ));
    }
    let words = |steps: &[Step]| Cost::of(steps, device).words.0;
    let expectation = crate::program::Expectation {
        words: Some(crate::program::ExpectedWords {
            init: words(&compiled.expansion.code.init),
            frame: words(&compiled.expansion.code.frame),
        }),
        ..crate::program::Expectation::default()
    };
    let program = Program::parse("compiled", &compiled.text)?;
    let text = program.blessed(&expectation).into_diagnostic()?;
    Ok(Compiled {
        text,
        memory: Some(memory),
        ..compiled
    })
}

/// Refuses kernels of zeros, from which nothing comes, and those that no program computes; each by
/// the name of its file.
fn check_weights(asked: &Asked) -> miette::Result<()> {
    for (kernel, source) in asked.kernels.iter().zip(&asked.sources) {
        if kernel.is_zero() {
            return Err(miette!(
                help = "give it a weight; few values (--to ternary) can round all of them to 0",
                "{source} has no weight but 0: nothing comes of it"
            ));
        }
        naive_cost(std::slice::from_ref(kernel)).map_err(|error| error.of_kernel(source))?;
    }
    Ok(())
}

/// A program of kinds that each have a memory of their own.
fn apart(
    arguments: &Arguments,
    asked: &Asked,
    kinds: &[CellKind],
    memory: DriveMemory,
    device: &Device,
) -> miette::Result<Compiled> {
    let request = request(arguments, &asked.kernels[..1], device)?;
    let program = SensorProgram::new(kinds, memory, &asked.title, &request)?;
    let scale = program.scale();
    let proof = Proof {
        kernels: &asked.kernels,
        device,
        results: &program.drives,
        input: Input::Light,
        // More would saturate the capture itself.
        inputs: Inputs {
            light: Interval::new(0.0, brightest(device)),
            ..Inputs::from_device(device)
        },
        scale,
    };
    let (readout, readouts) = readout::planned(arguments, asked, &program, kinds, device)?;
    let text = program.text_with(kinds, &asked.title, device, readout);
    let mut compiled = proof.compiled(text, program.filter, false)?;
    compiled.readouts = Some(readouts);
    compiled.in_bits = program.steps;
    let light = Signal::from_range((0.0, brightest(device) * device.value(Figure::LightScale)));
    compiled.on_chip = OnChip::run(&compiled.filter, device, &compiled.results_in, light)?;
    compiled.ranged = true;
    let thresholds = asked.thresholds.iter();
    compiled.thresholds = thresholds
        .map(|(on, off)| [on * scale, off * scale])
        .collect();
    Ok(compiled)
}

fn request<'a>(
    arguments: &Arguments,
    kernels: &'a [Kernel],
    device: &'a Device,
) -> miette::Result<Request<'a>> {
    let mut request = Request::new(kernels, device)?;
    request.effort = Effort::seconds(arguments.effort);
    request.seed = arguments.seed;
    request.objective = match arguments.objective {
        Aim::Silicon => Objective::Silicon,
        Aim::Events => Objective::Events,
        Aim::Exact => Objective::Exact,
        Aim::Words => Objective::Words,
    };
    if arguments.border {
        request.border = Border::Right;
    }
    Ok(request)
}

fn named(names: &[String], device: &Device) -> miette::Result<Vec<Analog>> {
    let one = |name: &String| match device.value_of(name.trim()) {
        Some(Value::Source(Source::Register(register))) if register != device.news() => {
            Ok(register)
        }
        _ => Err(miette!(
            help = "give analogue registers of the chip other than NEWS, such as A,B",
            "{name} is not a register that can hold a result on {}",
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
            "there are {} and {} for them",
            counted(count, "kernel"),
            counted(request.into.len(), "register")
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
const MIDDLE: f64 = FilterNoise::MIDDLE;

/// Errors of the chip in one result, LSB.
#[derive(Clone, Copy, serde::Serialize)]
struct Added {
    temporal: f64,
    fixed: f64,
    input_temporal: Option<f64>,
    input_fixed: Option<f64>,
}

/// What a filter adds to each result, and to the input for each.
fn noises(filter: &Filter, device: &Device, kernels: &[Kernel]) -> Vec<Added> {
    let noises = filter.noise(device, MIDDLE);
    let added = |(noise, kernel): (FilterNoise, &Kernel)| {
        let squares: f64 = kernel.weights().iter().map(|w| w * w).sum();
        let gain = filter.scale() * squares.sqrt();
        Added {
            // Never -0.
            temporal: noise.temporal + 0.0,
            fixed: noise.fixed + 0.0,
            input_temporal: (gain > 0.0).then(|| noise.temporal / gain + 0.0),
            input_fixed: (gain > 0.0).then(|| noise.fixed / gain + 0.0),
        }
    };
    noises.into_iter().zip(kernels).map(added).collect()
}

struct Proof<'a> {
    kernels: &'a [Kernel],
    device: &'a Device,
    results: &'a [Analog],
    input: Input,
    inputs: Inputs,
    scale: f64,
}
