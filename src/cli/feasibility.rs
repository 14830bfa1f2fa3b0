//! `amacrine feasibility`: whether a kernel can run on a chip, as a page to forward.

use std::fmt::Write as _;

use miette::{IntoDiagnostic, miette};

use crate::{
    compile::Effort,
    isa::Device,
    kernel::{Kernel, quantise::Quantiser},
    rig::guard::Warning,
    save::save,
    scene::{Observation, Scene, SceneError},
    study::{
        equivalent::RUNGS,
        feasibility::{self, Feasibility, Fit, Question, Several, Snapshot, Stream},
        report,
    },
    unit::Micros,
};

use super::{
    budget,
    clip::Clip,
    content::Content,
    files::{Named, Output},
    light::{self, Shown},
    progress::Progress,
    quantiser::Total,
    readout::Choice,
    window::Window,
};

/// What `feasibility` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine feasibility --kernel rgc-5x5 --threshold 128 -o report.html\n  amacrine feasibility --kernel learned.npy --threshold 40 --to int-5 --scene clip.mp4 --chip isa/mine -o report.html\n  amacrine feasibility --kernel csdvs-3,sobel-x --threshold 40,100 -o report.html\n\nSeveral kernels: each on its own, and all of them in one program. The page is one file: no network, no script; docs/feasibility.md says how each of its numbers is found."
)]
pub struct Arguments {
    /// A kernel file (.toml or .npy), or the name of a built-in; or several of them, which are
    /// to share a chip
    #[arg(long, required = true, value_delimiter = ',', value_name = "KERNELS")]
    kernel: Vec<Named>,
    /// Events where kernel times light (0 to 255) moved by more than this: one number for all
    /// kernels, or one for each
    #[arg(
        long,
        required = true,
        allow_negative_numbers = true,
        value_delimiter = ',',
        value_name = "THRESHOLDS"
    )]
    threshold: Vec<f64>,
    #[command(flatten)]
    clip: Clip,
    /// The few values that the chip computes with (see `amacrine quantise --help`); else the
    /// best of the candidates
    #[arg(long, value_name = "QUANTISER", value_parser = super::quantiser::quantiser)]
    to: Option<Quantiser>,
    /// Rows of the table of quantisers
    #[arg(long, value_delimiter = ',', value_name = "QUANTISERS", default_value = feasibility::CANDIDATES, value_parser = super::quantiser::quantiser)]
    candidates: Vec<Quantiser>,
    /// What quantised kernels must sum to
    #[arg(long, value_enum, default_value_t)]
    sum: Total,
    /// A shipped chip by name, or the folder of another
    #[arg(long, default_value = "scamp5")]
    chip: Named,
    /// How long each frame is exposed, such as 2ms
    #[arg(long)]
    exposure: Option<Micros>,
    /// Energy of a bit on the link in pJ, one number or LO..HI: an assumption, yours to set
    #[arg(long, default_value = "1..20", value_name = "LO..HI", value_parser = energy)]
    link_energy: Energy,
    #[command(flatten)]
    window: Window,
    /// How long to search for each program, in seconds of two cores of 2024
    #[arg(long, default_value_t = 1.0, value_parser = super::effort::seconds)]
    effort: f64,
    /// Seed of the searches, of stochastic rounding and of the silicon
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Write the page here
    #[arg(short, long, value_name = "REPORT.html", value_parser = Content::Page)]
    output: Option<Output>,
    /// Print one JSON object instead of the summary
    #[arg(long)]
    json: bool,
}

/// The least and the most, pJ.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Energy(f64, f64);

/// An energy, for the command line.
fn energy(text: &str) -> Result<Energy, String> {
    let (low, high) = text.split_once("..").unwrap_or((text, text));
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match (number(low), number(high)) {
        (Some(low), Some(high)) if 0.0 <= low && low <= high => Ok(Energy(low, high)),
        _ => Err(format!(
            "`{text}` is neither a number of pJ nor LO..HI, such as 5 or 1..20"
        )),
    }
}

/// Sensors that watch side by side, at most: those of the waterfall.
const SENSORS: usize = 20;

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let kernels = arguments.kernels()?;
    let device = Device::find(&arguments.chip)?;
    let observation = Observation::new();
    let open = || arguments.clip.open(&observation);
    let scene = open()?;
    let sensors = SENSORS.max(kernels.len() * (RUNGS.len() + 1) + 2);
    budget::check_study(&*scene, sensors)?;
    let (frames, fps) = (scene.frames(), scene.fps());
    drop(scene);
    let command = arguments.command();
    let Energy(least, most) = arguments.link_energy;
    let mut questions = Vec::new();
    for ((name, kernel), threshold) in kernels.iter().zip(arguments.thresholds(kernels.len())?) {
        questions.push(Question {
            name,
            kernel,
            threshold,
            to: arguments.to,
            candidates: &arguments.candidates,
            sum: arguments.sum.into(),
            device: &device,
            exposure: arguments.exposure,
            link: [least, most],
            effort: Effort::seconds(arguments.effort),
            seed: arguments.seed,
            readout: Choice::default().open_compiled()?.readout()?,
            within: arguments.window.at(fps),
            scene: arguments.clip.name(),
            command: &command,
        });
    }
    // For the table twice, for the sensors and for the waterfall; and once for all together.
    let shown = match questions.len() {
        1 => 4,
        n => 4 * n as u64 + 1,
    };
    let progress = Progress::new("watching", frames.map(|frames| shown * frames));
    let answer = ask(&questions, &open, &progress);
    progress.finish();
    let warnings = Warning::of_scene(&observation, 255.0);
    light::warn(&warnings);
    let answer = answer?.with(warnings);
    if let Some(path) = &arguments.output {
        let page = answer.page();
        save(path, |out| out.write_all(page.as_bytes()))?;
    }
    if arguments.json {
        let json = answer.json(&observation).into_diagnostic()?;
        super::say(&format!("{json}\n"));
        return Ok(());
    }
    let mut text = answer.summary() + &light::line(&observation);
    if let Some(path) = &arguments.output {
        let _ = writeln!(text, "\nwrote {}", path.display());
    }
    super::say(&text);
    Ok(())
}

/// What was answered: of one kernel, or of several together.
enum Answer {
    One(Box<(Feasibility, Snapshot)>),
    Several(Several, Vec<Snapshot>),
}

fn ask(
    questions: &[Question<'_>],
    open: &dyn Fn() -> Result<Box<dyn Scene>, SceneError>,
    progress: &Progress,
) -> miette::Result<Answer> {
    if let [question] = questions {
        let answer = feasibility::ask(question, open, |_| progress.tick())?;
        return Ok(Answer::One(Box::new(answer)));
    }
    let answer = feasibility::ask_several(questions, open, |_| progress.tick())?;
    match answer {
        Some((several, snapshots)) => Ok(Answer::Several(several, snapshots)),
        None => Err(miette!("there is no kernel to ask about")),
    }
}

impl Answer {
    /// Says the warnings of each kernel beside the output, and puts those of the scene before
    /// them.
    fn with(mut self, of_scene: Vec<Warning>) -> Self {
        let kernels = match &mut self {
            Self::One(answer) => std::slice::from_mut(&mut answer.0),
            Self::Several(several, _) => &mut several.kernels,
        };
        for all in kernels {
            light::warn(&all.warnings);
            all.warnings.splice(0..0, of_scene.clone());
        }
        self
    }

    fn page(&self) -> String {
        match self {
            Self::One(answer) => report::page(&answer.0, &answer.1),
            Self::Several(several, snapshots) => report::page_of_several(several, snapshots),
        }
    }

    fn json(&self, observation: &Observation) -> serde_json::Result<String> {
        match self {
            Self::One(answer) => serde_json::to_string(&Shown::new(&answer.0, observation)),
            Self::Several(several, _) => serde_json::to_string(&Shown::new(several, observation)),
        }
    }

    fn summary(&self) -> String {
        match self {
            Self::One(answer) => summary(&answer.0),
            Self::Several(several, _) => summary_of_several(several),
        }
    }
}

/// The kernels of a file or of a name, each with a name of its own.
fn named(name: &str) -> miette::Result<Vec<(String, Kernel)>> {
    let (kernels, _) = super::kernels::read(name)?;
    let several = kernels.len() > 1;
    let own = |i| {
        if several {
            format!("{name}[{i}]")
        } else {
            name.to_owned()
        }
    };
    let pairs = kernels.into_iter().enumerate();
    Ok(pairs.map(|(i, kernel)| (own(i), kernel)).collect())
}

impl Arguments {
    /// All kernels, each with its name.
    fn kernels(&self) -> miette::Result<Vec<(String, Kernel)>> {
        let mut all = Vec::new();
        for name in &self.kernel {
            all.extend(named(name)?);
        }
        Ok(all)
    }

    /// A threshold for each of so many kernels.
    fn thresholds(&self, kernels: usize) -> miette::Result<Vec<f64>> {
        match self.threshold[..] {
            [all] => Ok(vec![all; kernels]),
            ref each if each.len() == kernels => Ok(each.to_vec()),
            ref other => Err(miette!(
                help = "give one --threshold for all kernels, or one for each, in their order",
                "{} thresholds for {kernels} kernels",
                other.len()
            )),
        }
    }

    /// The command that gives the same page again, every default written out.
    fn command(&self) -> String {
        let mut text = format!(
            "amacrine feasibility --kernel {} --threshold {}",
            quoted(&list(&self.kernel)),
            list(&self.threshold)
        );
        let mut add = |name: &str, value: &str| {
            let _ = write!(text, " --{name} {}", quoted(value));
        };
        for (name, value) in self.clip.written() {
            add(name, &value);
        }
        if let Some(to) = self.to {
            add("to", &to.to_string());
        }
        let candidates: Vec<String> = self.candidates.iter().map(Quantiser::to_string).collect();
        add("candidates", &candidates.join(","));
        add("sum", self.sum.name());
        add("chip", &self.chip);
        if let Some(exposure) = self.exposure {
            add("exposure", &format!("{}us", exposure.0));
        }
        let Energy(least, most) = self.link_energy;
        add("link-energy", &format!("{least}..{most}"));
        if let Some(within) = self.window.within {
            add("within", &format!("{}us", within.0));
        }
        add("effort", &self.effort.to_string());
        add("seed", &self.seed.to_string());
        text + " -o report.html"
    }
}

/// Words with commas between them.
fn list(words: &[impl ToString]) -> String {
    let words: Vec<_> = words.iter().map(ToString::to_string).collect();
    words.join(",")
}

/// A word of a shell's command line.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// What all kernels together take, a line for each of them, and each on its own.
fn summary_of_several(several: &Several) -> String {
    let together = &several.together;
    let mut text = format!("{}\n\n{}\n\n", together.headline, together.says);
    let _ = writeln!(
        text,
        "{:<22} {:>10} {:>10} {:>14} {:>10}",
        "in one program", "to", "kept", "as threshold", "alone"
    );
    for kind in &together.kinds {
        let number = |kept: Option<f64>| kept.map_or("-".to_owned(), |kept| format!("{kept:.3}"));
        let _ = writeln!(
            text,
            "{:<22} {:>10} {:>10} {:>14} {:>10}",
            kind.name,
            kind.to,
            number(kind.headline.map(|headline| headline.kept)),
            kind.silicon
                .map_or("-".to_owned(), |silicon| silicon.equivalent()),
            number(kind.kept_apart),
        );
    }
    for all in &several.kernels {
        let _ = write!(text, "\n{}: {}", all.kernel.name, summary(all));
    }
    text
}

/// The verdict, and the streams as a table.
fn summary(all: &Feasibility) -> String {
    let mut text = light::of_kernels(&all.warnings);
    let _ = write!(text, "{}\n\n", all.verdict.headline);
    for finding in &all.verdict.findings {
        let _ = writeln!(text, "{:<12} {}", finding.about, finding.says);
    }
    let _ = writeln!(
        text,
        "\n{:<22} {:>10} {:>10} {:>10} {:>8} {:>8}",
        "", "events", "kbit/s", "F1", "floor", "kept"
    );
    let streams = &all.streams;
    let rows = [
        ("plain DVS", Some(&streams.dvs)),
        ("float kernel", Some(&streams.float)),
        ("program, no errors", streams.exact.as_ref()),
        ("program on the chip", streams.silicon.as_ref()),
    ];
    for (name, stream) in rows {
        if let Some(stream) = stream {
            text += &row(name, stream);
        }
    }
    if let Fit::OnChip(chip) = &all.fit {
        let time = &chip.time;
        let _ = writeln!(
            text,
            "\n{} words a frame: {:.1} us on the array, {:.1} us of readout; at most {:.0} frames/s, {:.0} with the slots that this scene needs",
            chip.frame_words,
            time.array.high,
            time.readout.high,
            time.ceiling.low,
            time.ceiling_of_scene.low,
        );
    }
    if let Some(power) = &all.power {
        let _ = writeln!(
            text,
            "{:.2} to {:.0} mW of the array at {} frames/s (modelled: what it takes idle is not public)",
            power.array.low, power.array.high, all.scene.fps
        );
    }
    text
}

fn row(name: &str, stream: &Stream) -> String {
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let f1 = stream.judged.map(|judged| judged.f1);
    format!(
        "{name:<22} {:>10} {:>10} {:>10} {:>8} {:>8}\n",
        stream.events,
        number(stream.mean_kbit_s, 1),
        number(f1.map(|f1| f1.value), 4),
        number(f1.map(|f1| f1.floor), 4),
        number(f1.map(|f1| f1.kept), 4),
    )
}
