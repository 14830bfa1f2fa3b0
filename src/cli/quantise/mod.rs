//! `amacrine quantise`: kernels in few values, and what that does to them.

mod several;

use std::fmt::Write;

use image::RgbImage;
use miette::miette;

use super::{
    arguments::{
        budget,
        clip::Clip,
        event_rate::NoRate,
        heading,
        kernel_names::KernelNames,
        light,
        quantiser::{Total, quantiser},
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
    compare::metric::Short,
    compile::Effort,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{self, Change, Quantised, Quantiser},
    },
    photoreceptor::Response,
    picture::{self, write_png},
    rig::guard::Warning,
    save::save,
    scene::{Observation, Scene as _},
    study::{
        defaults,
        equivalent::{self, Likeness, RUNGS},
        quantisation::{self, Outcome},
        quantised::{self, Answer, Asked, Few, OnChip, One, Row, Tried, Watch},
    },
    unit::{fixed, frame_rate, signed},
};

/// What `quantise` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "amacrine quantise [OPTIONS] --to <QUANTISER> <KERNELS>...",
    after_help = after_help()
)]
pub struct Arguments {
    #[command(flatten)]
    kernels: KernelNames,
    #[command(flatten)]
    no_rate: NoRate,
    /// Quantiser, or several separated by commas
    ///
    /// The list of quantisers is at the end of this help.
    #[arg(long, required = true, value_delimiter = ',', value_name = "QUANTISER", value_parser = quantiser)]
    to: Vec<Quantiser>,
    /// Sum of the quantised kernel
    #[arg(long, value_enum, default_value_t)]
    sum: Total,
    /// Seed of stochastic rounding [default: 0]
    ///
    /// With --threshold it is the seed of the searches and of the silicon, too.
    #[arg(long)]
    seed: Option<u64>,
    /// Write the levels to a kernel file
    #[arg(short, long, value_name = "FILE.toml", value_parser = Content::Kernel)]
    output: Option<Output>,
    /// Draw the kernel beside its quantised versions
    #[arg(long, value_name = "FILE.png", value_parser = Content::Picture)]
    picture: Option<Output>,
    /// Threshold at which each version runs on the chip, beside the float kernel
    ///
    /// In kernel times light (0 to 255): one number for all kernels, or one for each. A cell has an
    /// event when its drive has moved by more than this. Sensor files have their own and run
    /// without this option, too. The other options under Chip, Scene, Search and Comparison need a
    /// threshold.
    #[arg(long, value_delimiter = ',', value_name = "THRESHOLDS", help_heading = heading::CHIP)]
    threshold: Vec<f64>,
    #[command(flatten)]
    clip: Clip,
    /// Name of a shipped chip, or folder of your own [default: scamp5]
    #[arg(long, help_heading = heading::CHIP)]
    chip: Option<Named>,
    /// Search effort for each program, in seconds [default: 1]
    ///
    /// The unit is a second of two cores of 2024 for one 3x3 kernel; larger kernels, and several
    /// kernels, take several times as long. The program counts states of the search, not time: a
    /// slower computer takes longer and finds the same program.
    #[arg(long, value_parser = super::arguments::effort::seconds, help_heading = heading::SEARCH)]
    effort: Option<f64>,
    #[command(flatten)]
    window: Window,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// The end of its help.
fn after_help() -> String {
    format!(
        "Examples:\n  amacrine quantise rgc-5x5 --to ternary --sum zero\n  amacrine quantise learned.npy --to ternary,po2-3,int-5,csd-40,q3.4\n  amacrine quantise rgc-4-on-chip --to ternary,int-5\n\nSeveral kernels are each quantised, and with a threshold run in one program.\nQuantisers: {}.\nA kernel becomes scale x levels; on a chip, divide the thresholds by the scale and run the levels.",
        quantise::known()
    )
}

/// Runs the verb.
///
/// # Errors
/// When the kernel cannot be read or not quantised in any of the ways that were asked for, or a
/// file not be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let kinds = arguments.kernels.kinds()?;
    let thresholds = kinds.thresholds(&arguments.threshold)?;
    arguments.check(thresholds.is_some(), kinds.kernels.len())?;
    let observation = Observation::new();
    let answer = arguments.answer(&kinds, thresholds.as_deref(), &observation)?;
    if let (Answer::One(one), [kernel]) = (&answer, &kinds.kernels[..]) {
        let good: Vec<&Quantised> = one.kind.good().collect();
        if let (Some(path), [quantised]) = (&arguments.output, &good[..]) {
            write(path, arguments, quantised)?;
        }
        if let Some(path) = &arguments.picture {
            let name = arguments.kernels.to_string();
            write_png(path, &picture(&name, kernel, &one.kind.tried))?;
        }
    }
    if arguments.json {
        let json = serde_json::to_string(&answer).map_err(|e| miette!("{e}"))?;
        super::say(&format!("{json}\n"));
        return Ok(());
    }
    let mut text = match (&answer, &kinds.kernels[..]) {
        (Answer::One(one), [kernel, ..]) => text(arguments, kernel, one),
        (Answer::One(_), []) => String::new(),
        (Answer::Several(all), kernels) => several::text(arguments, kernels, all),
    };
    if thresholds.is_some() {
        text += &light::line(&observation);
    }
    super::say(&text);
    Ok(())
}

/// What is said of one kernel.
fn text(arguments: &Arguments, kernel: &Kernel, one: &One) -> String {
    let mut text = format!("{}, sum {}\n", arguments.kernels, short(kernel.dc()));
    text += &drawn(kernel);
    let good: Vec<&Quantised> = one.kind.good().collect();
    if let ([quantised], [row]) = (&good[..], &one.kind.quantised[..]) {
        let _ = writeln!(text, "\n{} x {}", row.to, short(quantised.scale));
        text += &written(&quantised.levels);
        text += &drawn(&quantised.levels);
    }
    text += &table(&one.kind.quantised);
    if let Some(chip) = &one.chip {
        text += &chip_table(arguments, chip);
    }
    text
}

impl Arguments {
    /// The chip's name or folder.
    fn chip(&self) -> &str {
        self.chip.as_deref().unwrap_or(defaults::CHIP)
    }

    fn seed(&self) -> u64 {
        self.seed.unwrap_or(0)
    }

    fn effort(&self) -> Effort {
        Effort::seconds(self.effort.unwrap_or(Effort::SECONDS))
    }

    /// Refuses options that would be of no use.
    fn check(&self, has_threshold: bool, kernels: usize) -> miette::Result<()> {
        if kernels > 1 && (self.output.is_some() || self.picture.is_some()) {
            return Err(miette!(
                help = "give one of them, an array of shape (k,k), for --output and --picture",
                "{} holds {kernels} kernels",
                self.kernels
            ));
        }
        if self.output.is_some() && self.to.len() != 1 {
            return Err(miette!(
                help = "give one quantiser with --to",
                "--output writes one kernel, and {} were asked for",
                self.to.len()
            ));
        }
        if has_threshold {
            return Ok(());
        }
        if self.seed.is_some() && !self.to.iter().any(Quantiser::is_random) {
            return Err(miette!(
                help = "leave --seed out, round by chance (--to q3.4:stochastic), or give a threshold, too",
                "--seed has no effect without stochastic rounding or a threshold: these levels are the same under every seed"
            ));
        }
        let own = [
            self.window.within.map(|_| "within"),
            self.chip.as_ref().map(|_| "chip"),
            self.effort.map(|_| "effort"),
        ];
        let shown = self.clip.written().into_iter().map(|(name, _)| name);
        match own.into_iter().flatten().chain(shown).next() {
            None => Ok(()),
            Some(name) => Err(miette!(
                help = "give a threshold, too: then each is run on the chip",
                "--{name} needs --threshold"
            )),
        }
    }

    /// The kernels in few values; with thresholds on the chip, too.
    fn answer(
        &self,
        kinds: &Kinds,
        thresholds: Option<&[f64]>,
        observation: &Observation,
    ) -> miette::Result<Answer> {
        let asked = Asked {
            names: &kinds.names,
            kernels: &kinds.kernels,
            to: &self.to,
            sum: self.sum.into(),
            seed: self.seed(),
        };
        let open = || self.clip.open(observation);
        let Some(thresholds) = thresholds else {
            let watch = Watch {
                open: &open,
                observation,
                frame: &|| (),
            };
            let answer = quantised::answer(&asked, None, &watch)?;
            light::warn(answer.warnings());
            return Ok(answer);
        };
        let device = Device::find(self.chip())?;
        let scene = open()?;
        self.clip.check_fits(&*scene, &device)?;
        let (kernels, to) = (kinds.kernels.len(), self.to.len());
        let (sensors, shows) = match kernels {
            // All of them at once, and then those of as many events.
            1 => (1 + RUNGS.len() + 3 * to, 2),
            several => ((RUNGS.len() + 1) * several + 2, to as u64),
        };
        budget::check_study(&*scene, sensors)?;
        let progress = Progress::new("watching", scene.frames().map(|frames| shows * frames));
        drop(scene);
        let chip = OnChip {
            thresholds,
            device: &device,
            effort: self.effort(),
            memory: kinds.memory,
            within: self.window.within,
        };
        let watch = Watch {
            open: &open,
            observation,
            frame: &|| progress.tick(),
        };
        let answer = quantised::answer(&asked, Some(&chip), &watch);
        progress.finish();
        match &answer {
            Ok(answer) => light::warn(answer.warnings()),
            Err(_) => light::warn(&Warning::of_scene(observation, Response::IDENTITY)),
        }
        Ok(answer?)
    }
}

fn chip_table(arguments: &Arguments, answer: &quantisation::Answer) -> String {
    let scores = format!("{:>6} {:>9} {:>7}", "kept", "threshold", "events");
    let mut text = format!(
        "\non {}, against the float kernel's {} events on {} at {} frames/s (matched within {})\n{:<16} {:>6} {:>6} {:>6} {:>9}  {scores}  {scores}\n{:<16} {:>6} {:>6} {:>6} {:>9}  {:>24}  {:>24}\n",
        arguments.chip(),
        answer.reference_events,
        arguments.clip.name(),
        frame_rate(answer.fps),
        Short(answer.window_us),
        "quantiser",
        "filter",
        "words",
        "us",
        "registers",
        "",
        "words",
        "/frame",
        "/frame",
        "",
        "exact",
        "silicon",
    );
    for row in &answer.rows {
        let _ = match &row.outcome {
            Outcome::Refused(why) => writeln!(text, "{:<16} {why}", row.to),
            Outcome::OnChip(chip) => {
                let score = |score: &Likeness| {
                    let ratio = score
                        .event_ratio
                        .map_or("-".to_owned(), |r| format!("{r:.3}"));
                    let kept = equivalent::kept(score.kept, 3);
                    format!("{kept:>6} {:>9} {ratio:>7}", score.equivalent())
                };
                writeln!(
                    text,
                    "{:<16} {:>6} {:>6} {:>6.1} {:>9}  {}  {}",
                    row.to,
                    chip.filter_words,
                    chip.words,
                    chip.array_us,
                    chip.registers,
                    score(&chip.exact),
                    score(&chip.silicon),
                )
            }
        };
    }
    text + &tuned_table(answer)
        + "kept: the part of F1 above chance, 1 at most. threshold: the rise of the float kernel's threshold\nthat costs as much. events: for each of the float kernel's. us: on the array, without readout. registers: the most\nof the filter that are live at a time; `asm` lists all that the program uses.\n"
}

/// Gain and shape apart: against a float kernel that says as many events.
fn tuned_table(answer: &quantisation::Answer) -> String {
    let mut text = String::new();
    for row in &answer.rows {
        let Outcome::OnChip(chip) = &row.outcome else {
            continue;
        };
        let told = |score: &Likeness| match &score.tuned {
            None => format!("{:>24}", "-"),
            Some(tuned) => format!(
                "{:>6} {:>9} {:>6}%",
                equivalent::kept(tuned.kept, 3),
                tuned.equivalent(),
                signed(tuned.threshold_percent, 0)
            ),
        };
        let (exact, silicon) = (told(&chip.exact), told(&chip.silicon));
        let _ = writeln!(text, "{:<16} {:>30}  {exact}  {silicon}", row.to, "");
    }
    if text.is_empty() {
        return text;
    }
    format!(
        "against a float kernel of as many events, whose threshold is higher by the last column\n{text}"
    )
}

/// The levels as a kernel file.
fn write(path: &Output, arguments: &Arguments, quantised: &Quantised) -> miette::Result<()> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let source = format!(
        "{} as {}, sum {}; times {} it is the kernel: divide thresholds by that",
        arguments.kernels,
        arguments.to[0],
        arguments.sum.name(),
        quantised.scale
    );
    let [name, source] = [name.into_owned(), source].map(toml::Value::from);
    let mut text = format!("name = {name}\nsource = {source}\nweights = [\n");
    for row in quantised.levels.rows() {
        let _ = writeln!(text, "  {row:?},");
    }
    text += "]\n";
    save(path, |file| {
        std::io::Write::write_all(file, text.as_bytes())
    })?;
    Ok(())
}

/// One line for each quantiser.
fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "\n{:<16} {:>9} {:>6} {:>9} {:>9} {:>10}  {}\n",
        "quantiser", "rel error", "taps", "scale", "sum", "response", "most at (v, u) cycles/pixel"
    );
    for row in rows {
        let _ = match &row.few {
            Few::Refused { refused } => writeln!(text, "{:<16} {refused}", row.to),
            Few::Numbers(few) => {
                let Change { largest, at, .. } = few.response;
                writeln!(
                    text,
                    "{:<16} {:>9.4} {:>6} {:>9} {:>9} {:>9.1}%  ({:.3}, {:.3})",
                    row.to,
                    few.relative_error,
                    few.taps,
                    short(few.scale),
                    short(if few.sum.abs() < 1e-9 * few.scale {
                        0.0
                    } else {
                        few.sum
                    }),
                    100.0 * largest,
                    at.0,
                    at.1
                )
            }
        };
    }
    text + "rel error: |w - scale l| / |w|. response: the largest change of the frequency response, as a part of its largest value\n"
}

/// The numbers, in columns.
fn written(kernel: &Kernel) -> String {
    let texts: Vec<Vec<String>> = kernel
        .rows()
        .iter()
        .map(|row| row.iter().map(|w| short(*w)).collect())
        .collect();
    let width = texts.iter().flatten().map(String::len).max().unwrap_or(0);
    let line = |row: &Vec<String>| {
        row.iter().fold(" ".to_owned(), |line, cell| {
            format!("{line} {cell:>width$}")
        }) + "\n"
    };
    texts.iter().map(line).collect()
}

/// Three shades of each sign.
fn drawn(kernel: &Kernel) -> String {
    let most = kernel.largest();
    let cell = |w: f64| {
        let part = if most > 0.0 { w.abs() / most } else { 0.0 };
        let shade = if part < 1.0 / 12.0 {
            0
        } else {
            (part * 3.0).ceil() as usize
        };
        let sign = if w < 0.0 { "-" } else { "+" };
        if shade == 0 {
            "  . ".to_owned()
        } else {
            format!("{:^4}", sign.repeat(shade))
        }
    };
    let row = |row: Vec<f64>| {
        let cells: String = row.into_iter().map(cell).collect();
        format!("  {}\n", cells.trim_end())
    };
    kernel.rows().into_iter().map(row).collect()
}

/// Four digits after the point, or as many more as three digits of a small number need; no zeros at
/// the end.
fn short(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && size < 1e-4 {
        return format!("{value:.3e}");
    }
    let decimals = (4..8).find(|d| size >= 10f64.powi(2 - d)).unwrap_or(4) as usize;
    let text = fixed(value, decimals);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The kernel, and each of the quantised ones at its scale.
fn picture(name: &str, kernel: &Kernel, all: &[Tried]) -> RgbImage {
    let quantised = all.iter().filter_map(|(to, quantised)| {
        let quantised = quantised.as_ref().ok()?;
        Some((to.to_string(), quantised.kernel()))
    });
    let quantised: Vec<(String, Kernel)> = quantised.collect();
    let named: Vec<_> = std::iter::once((name.to_owned(), kernel.weights()))
        .chain(
            quantised
                .iter()
                .map(|(to, kernel)| (to.clone(), kernel.weights())),
        )
        .collect();
    picture::kernels(&named)
}
