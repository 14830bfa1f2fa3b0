//! `amacrine waterfall`: where the events of the float sensor go on the way to the chip, over
//! frame rate and step by step.

use std::{fmt::Write, sync::OnceLock};

use miette::miette;

use super::{
    arguments::{
        budget,
        clip::Clip,
        heading,
        kernel_names::KernelNames,
        light,
        quantiser::{Total, arithmetic},
        readout::Choice,
        window::Window,
    },
    input::kernels::Kinds,
    output::{
        content::Content,
        files::{Named, Output},
        progress::Progress,
    },
};
use crate::{
    array::Arithmetic,
    compare::fate::Fate,
    compile::Effort,
    isa::{Device, Figure},
    kernel::quantise::Quantiser,
    photoreceptor::Response,
    picture::share_text,
    rig::guard::Warning,
    scene::{Observation, Scene as _},
    study::{
        defaults,
        design::Design,
        equivalent::{self, RUNGS},
        waterfall::{
            Answer, Asked, Choice as RateChoice, Rate, Rates, Share, Shares, Watch, Waterfall,
            answer,
        },
    },
    unit::{frame_rate, signed},
};

/// What `waterfall` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "amacrine waterfall [OPTIONS] <KERNELS>...",
    after_help = "Examples:\n  amacrine waterfall rgc-5x5 --to int-5 --sum zero --threshold 128 -o waterfall.svg\n  amacrine waterfall csdvs-3 --threshold 20 --rates 10,40,130 --chips 20\n  amacrine waterfall csdvs-3 --threshold 20 --to int-5 --scene clip.mp4 --json\n  amacrine waterfall dog --threshold 20 --to ternary --format q8.8 --steps\n\nWithout --readout, events leave the chip by the scan that a compiled program asks for.\ndocs/waterfall.md says what each cause is, how it is told from the others, and which sensors\nare run."
)]
pub struct Arguments {
    #[command(flatten)]
    kernels: KernelNames,
    /// Thresholds in kernel times light (0 to 255): one for all kernels, or one for each
    ///
    /// A cell has an event when its drive has moved by more than this. Required, unless KERNELS are
    /// sensor files, which have their own.
    #[arg(long, value_delimiter = ',', value_name = "THRESHOLDS")]
    threshold: Vec<f64>,
    /// Quantiser of the kernel (`amacrine quantise --help` lists them)
    #[arg(long, default_value = defaults::TO, value_name = "QUANTISER", value_parser = super::arguments::quantiser::quantiser)]
    to: Quantiser,
    /// Sum of the quantised kernel
    #[arg(long, value_enum, default_value_t)]
    sum: Total,
    #[command(flatten)]
    clip: Clip,
    /// Name of a shipped chip, or folder of your own
    #[arg(long, default_value = defaults::CHIP, help_heading = heading::CHIP)]
    chip: Named,
    /// Number of the chip to change, such as error.noise=0.1; may be repeated
    #[arg(long = "set", value_name = "FIGURE=NUMBER", value_parser = figure, help_heading = heading::CHIP)]
    sets: Vec<(Figure, f64)>,
    #[arg(long, default_value = defaults::DOMAIN, value_parser = arithmetic, help = format!("Arithmetic of the chip's cells: {}; number formats have only their own rounding, and none of the silicon's errors", Arithmetic::names()), help_heading = heading::CHIP)]
    format: Arithmetic,
    /// How events leave the chip; unless said otherwise the scan that a compiled program asks for
    #[command(flatten)]
    readout: Choice,
    #[command(flatten)]
    window: Window,
    /// Seed of the search, of stochastic rounding and of the silicon
    #[arg(long, default_value_t = 0, help_heading = heading::SEARCH)]
    seed: u64,
    /// Search effort for the program, in seconds
    ///
    /// The unit is a second of two cores of 2024 for one 3x3 kernel; larger kernels, and several
    /// kernels, take several times as long. The program counts states of the search, not time: a
    /// slower computer takes longer and finds the same program.
    #[arg(long, default_value_t = Effort::SECONDS, value_parser = super::arguments::effort::seconds, help_heading = heading::SEARCH)]
    effort: f64,
    /// Frame rates at which the same light is shown, separated by commas
    ///
    /// In frames per second. Default: four rates, from the clip's own to the highest that the chip
    /// allows. Excludes --steps.
    #[arg(long, value_delimiter = ',', value_name = "FPS", value_parser = fps, conflicts_with = "steps")]
    rates: Vec<f64>,
    /// Number of chips, with seeds from --seed on
    ///
    /// Excludes --steps.
    #[arg(long, default_value_t = defaults::WATERFALL_CHIPS, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000), conflicts_with = "steps", help_heading = heading::CHIP)]
    chips: u64,
    /// Number of tiles of the scene on which the chips are run
    ///
    /// Default: as many as take some seconds. Excludes --steps.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000), conflicts_with = "steps", help_heading = heading::CHIP)]
    tiles: Option<u16>,
    /// Show only the steps at the clip's own frame rate, event by event
    ///
    /// Excludes --rates, --chips and --tiles.
    #[arg(long)]
    steps: bool,
    /// Draw the waterfall; of several kernels the one of --kind
    #[arg(short, long, value_name = "FILE.svg|FILE.png", value_parser = Content::Drawing)]
    output: Option<Output>,
    /// Kernel that -o draws, if there are several: its number from 0, or its name
    ///
    /// The drawing shows it in the program of all kernels.
    #[arg(long, value_name = "N|NAME", requires = "output")]
    kind: Option<String>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// `section.key=number`, for the command line.
fn figure(text: &str) -> Result<(Figure, f64), String> {
    let (name, value) = text
        .split_once('=')
        .ok_or_else(|| format!("`{text}` is not FIGURE=NUMBER, such as error.noise=0.1"))?;
    super::arguments::chip_figure::figure(name, value)
}

/// A frame rate, for the command line.
fn fps(text: &str) -> Result<f64, String> {
    { text.parse().ok() }
        .filter(|fps: &f64| fps.is_finite() && *fps > 0.0)
        .ok_or_else(|| format!("`{text}` is not a rate: give a number above 0, in frames/s"))
}

/// Sensors that watch side by side: one a step, and in all but one of them; and the float
/// sensors of both ladders.
pub(super) const SENSORS: usize = 21 + 2 * RUNGS.len();

/// Runs the verb.
///
/// # Errors
/// When kernel, chip, readout or scene cannot be read, the kernel does not fit the chip, no
/// event happens, or the picture cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let kinds = arguments.kernels.kinds()?;
    kinds.check_weights()?;
    let thresholds = arguments.thresholds(&kinds)?;
    let drawn = arguments.drawn(&kinds)?;
    let mut device = Device::find(&arguments.chip)?;
    for (figure, value) in &arguments.sets {
        device = device.what_if(*figure, *value)?;
    }
    arguments.note_unused();
    let observation = Observation::new();
    let readout = arguments.readout.open_compiled()?;
    let search = (Effort::seconds(arguments.effort), arguments.seed);
    let designs = Design::each(&kinds.kernels, &thresholds, &device, search);
    let asked = Asked {
        names: &kinds.names,
        designs: &designs,
        to: arguments.to,
        sum: arguments.sum.into(),
        arithmetic: arguments.format,
        readout: readout.readout()?,
        memory: kinds.memory,
        choice: RateChoice {
            rates: arguments.rates.clone(),
            chips: arguments.chips,
            tiles: arguments.tiles.map(usize::from),
            within: arguments.window.within,
        },
        steps_alone: arguments.steps,
    };
    let all = arguments.answers(&asked, &device, &observation)?;
    if let (Some(path), Some(answer)) = (&arguments.output, all.get(drawn)) {
        path.draw(&answer.drawing(&asked.title(drawn, arguments.clip.name())))?;
    }
    if arguments.json {
        let json = match &all[..] {
            [one] => serde_json::to_string(one),
            several => serde_json::to_string(several),
        };
        let json = json.map_err(|e| miette!("{e}"))?;
        super::say(&format!("{json}\n"));
        return Ok(());
    }
    super::say(&(text(&all, readout.name()) + &light::line(&observation)));
    Ok(())
}

/// What is said of each kernel, and of their program.
fn text(all: &[Answer], readout: &str) -> String {
    let mut text = String::new();
    for told in all {
        if let Some(name) = &told.name {
            let _ = writeln!(text, "== {name}");
        }
        let _ = writeln!(
            text,
            "{}\nthat is the chip against a float sensor that decides once a frame too, as in quantise and feasibility",
            told.steps.likeness
        );
        text += &match &told.rates {
            Some(rates) => rate_table(&told.steps, rates),
            None => table(&told.steps, readout),
        };
        if all.len() > 1 {
            text.push('\n');
        }
    }
    if let Some(memory) = all.first().and_then(|one| one.memory.as_ref()) {
        let _ = writeln!(
            text,
            "all {} kernels in one program, with {memory}; the memory rule of the float sensor is then that too",
            all.len(),
        );
    }
    text
}

impl Arguments {
    /// Which kernel is drawn.
    fn drawn(&self, kinds: &Kinds) -> miette::Result<usize> {
        let several = kinds.kernels.len();
        let Some(asked) = &self.kind else {
            if self.output.is_none() || several == 1 {
                return Ok(0);
            }
            return Err(miette!(
                help = format!(
                    "say which of them is drawn: --kind N, from 0, or its name: {}; a file of it alone would have another program",
                    kinds.names.join(", ")
                ),
                "{} holds {several} kernels, and --output draws one",
                self.kernels,
            ));
        };
        let named = kinds.names.iter().position(|name| name == asked);
        let number = asked.parse().ok().filter(|number| *number < several);
        named.or(number).ok_or_else(|| {
            miette!(
                help = format!(
                    "give a number from 0 to {}, or one of {}",
                    several - 1,
                    kinds.names.join(", ")
                ),
                "--kind {asked}: {} holds no such kernel",
                self.kernels
            )
        })
    }

    /// Says which number that is set changes nothing.
    fn note_unused(&self) {
        let mut sets = self.sets.iter();
        if let Some(note) = sets.find_map(|(figure, _)| self.format.unused(*figure, "--format")) {
            super::complain(&format!("note: {note}\n"));
        }
    }

    /// A threshold for each kind.
    fn thresholds(&self, kinds: &Kinds) -> miette::Result<Vec<f64>> {
        kinds.thresholds(&self.threshold)?.ok_or_else(|| {
            miette!(
                help = "give --threshold T, in kernel times light (0 to 255), or sensor files, which have their own",
                "a waterfall needs a threshold"
            )
        })
    }

    /// Where the events of each kernel go, all of them in one program.
    fn answers(
        &self,
        asked: &Asked<'_>,
        device: &Device,
        observation: &Observation,
    ) -> miette::Result<Vec<Answer>> {
        let open = || self.clip.open(observation);
        let scene = open()?;
        self.clip.check_fits(&*scene, device)?;
        budget::check_study(&*scene, SENSORS * asked.designs.len())?;
        let progress = Progress::new("watching", scene.frames());
        drop(scene);
        let chips = OnceLock::new();
        let chip = || {
            let begin = || {
                progress.finish();
                Progress::new("chips", None)
            };
            chips.get_or_init(begin).tick();
        };
        let watch = Watch {
            open: &open,
            observation,
            frame: &|| progress.tick(),
            chip: &chip,
        };
        let all = answer(asked, &watch);
        progress.finish();
        if let Some(chips) = chips.get() {
            chips.finish();
        }
        light::warn(&Warning::of_scene(observation, Response::IDENTITY));
        let all = all.map_err(|error| {
            let what = format!("no waterfall of {} on {}", self.kernels, self.chip);
            miette::Report::new(error).wrap_err(what)
        })?;
        for answer in &all {
            light::warn_of(answer.name.as_ref(), answer.own_warnings());
        }
        Ok(all)
    }
}

/// A column for each rate.
fn rate_table(steps: &Waterfall, rates: &Rates) -> String {
    let [_, program] = steps.captions();
    let mut text = format!("{program}\n\n{}\n\n", rates.captions().join("\n"));
    let row = |text: &mut String, name: &str, cells: &mut dyn Iterator<Item = String>| {
        let line = cells.fold(format!("{name:<24}"), |line, cell| {
            format!("{line}{cell:<21} ")
        });
        let _ = writeln!(text, "{}", line.trim_end());
    };
    // Numbers stand below each other.
    let cell = |share: Option<f64>, spread: Option<[f64; 2]>| {
        let text = share_text(share.zip(spread));
        let number = text.find(' ').unwrap_or(text.len());
        format!("{}{text}", " ".repeat(6_usize.saturating_sub(number)))
    };
    let all = || rates.rates.iter();
    let head = |rate: &Rate| format!("{:>6} frames/s", frame_rate(rate.headline.fps));
    row(&mut text, "%", &mut all().map(head));
    let kept = |rate: &Rate| cell(rate.headline.kept, rate.kept_10_90);
    row(&mut text, "kept", &mut all().map(kept));
    let first: &[Share] = rates.rates.first().map_or(&[], |rate| &rate.causes);
    for (i, cause) in first.iter().enumerate() {
        let shares = all().filter_map(|rate| rate.causes.get(i));
        let mut cells = shares.map(|share| cell(share.share, share.share_10_90));
        row(&mut text, cause.name, &mut cells);
    }
    let equivalent = |rate: &Rate| {
        let percent = rate.headline.threshold_equivalent_percent;
        let told = equivalent::percents(percent, rate.threshold_equivalent_is_least);
        format!("{told:>8}")
    };
    row(
        &mut text,
        "as a threshold higher by",
        &mut all().map(equivalent),
    );
    if rates.noise.is_some() {
        let share = |rate: &Rate| {
            let share = rate.noise.map_or(0.0, |noise| noise.share);
            format!("{:>6.1}", 100.0 * share)
        };
        row(&mut text, "noise alone", &mut all().map(share));
        text.push('\n');
        for line in rates.advice() {
            let _ = writeln!(text, "{line}");
        }
    }
    if let Some(why) = rates.unjudged() {
        let _ = writeln!(text, "\n-: {why}");
    }
    text + "\nkept and what the causes take add up to 100. noise alone: events on a still picture, for each of the float sensor's.\n"
}

/// A line for each step.
fn table(answer: &Waterfall, readout: &str) -> String {
    let [events, program] = answer.captions();
    let mut text = format!(
        "{events}\n{program}\n\n{:<22} {:>7}  {:^31}  {:^31}  {:>7}\n{:<22} {:>7}  {}  {}  {:>7}\n",
        "% of the float events",
        "events",
        "in order",
        "alone",
        "alone -",
        "",
        "after",
        CLASSES,
        CLASSES,
        "order",
    );
    let whole = answer.float_events as f64;
    for step in &answer.steps {
        let alone = step.backward_share.map_or(
            format!("{:>7} {:>7} {:>7} {:>7}", "-", "-", "-", "-"),
            columns,
        );
        let more = step
            .interaction
            .map_or("-".to_owned(), |d| signed(100.0 * d.changed(), 2));
        let _ = writeln!(
            text,
            "{:<22} {:>7.2}  {}  {alone}  {more:>7}",
            step.name,
            100.0 * step.forward.after() as f64 / whole,
            columns(step.forward_share),
        );
    }
    let Fate { kept, .. } = answer.ends;
    let _ = writeln!(
        text,
        "{:<22} {:>7.2}  {}",
        "first to last at once",
        100.0 * answer.ends.after() as f64 / whole,
        columns(answer.shares(answer.ends)),
    );
    let _ = writeln!(
        text,
        "\nkept from the float sensor to what leaves the {readout} readout: {:.2} %\nin order: what the step changes after those before it. alone: what it changes when all others are there.",
        100.0 * kept as f64 / whole
    );
    text
}

const CLASSES: &str = "   lost   extra mistime    sign";

/// The classes of [`CLASSES`], in %.
fn columns(shares: Shares) -> String {
    let Shares {
        mistimed,
        wrong_sign,
        lost,
        extra,
    } = shares;
    let part = |share: f64| format!("{:>7.2}", 100.0 * share);
    [lost, extra, mistimed, wrong_sign].map(part).join(" ")
}
