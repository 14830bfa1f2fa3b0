//! `amacrine feasibility`: whether a kernel can run on a chip, as a page to forward.

use std::fmt::{self, Write as _};

use miette::{IntoDiagnostic, WrapErr};

use super::{
    arguments::{
        budget, clip::Clip, event_rate::event_rate, heading, kernel_names::KernelNames, light,
        quantiser::Total, readout::Choice, window::Window,
    },
    compile::memory,
    input::kernels::Kinds,
    output::{
        command_line::CommandLine,
        content::Content,
        files::{Named, Output},
        progress::Progress,
        readout_table,
    },
    waterfall,
};
use crate::{
    compare::metric::Short,
    compile::{DriveMemory, Effort},
    isa::Device,
    kernel::quantise::Quantiser,
    photoreceptor::Response,
    rig::guard::Warning,
    save::save,
    scene::Observation,
    study::{
        WithLight, defaults,
        equivalent::{self, Likeness, RUNGS},
        feasibility::{
            self, AtRate, Feasibility, Fit, Question, Reply, Several, Stream, chips::OverChips,
            readout::ReadoutOrder,
        },
        report,
    },
    unit::{Micros, frame_rate},
};

/// What `feasibility` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "amacrine feasibility [OPTIONS] <KERNELS>...",
    after_help = "Examples:\n  amacrine feasibility rgc-5x5 --threshold 128 -o report.html\n  amacrine feasibility learned.npy --threshold 40 --to int-5 --scene clip.mp4 --chip isa/mine -o report.html\n  amacrine feasibility csdvs-3,sobel-x --threshold 40,100 -o report.html\n\nSeveral kernels: each on its own, and all of them in one program. The page is one file: no network, no script; docs/feasibility.md says how each of its numbers is found."
)]
pub struct Arguments {
    #[command(flatten)]
    kernels: KernelNames,
    /// Thresholds in kernel times light (0 to 255): one for all kernels, or one for each
    ///
    /// A cell has an event when its drive has moved by more than this. Required, unless --rate is
    /// given or KERNELS are sensor files, which have their own. Excludes --rate.
    #[arg(long, value_delimiter = ',', value_name = "THRESHOLDS")]
    threshold: Vec<f64>,
    /// Events per pixel and second to reach, all kernels together
    ///
    /// The program finds the thresholds; each kernel has an equal share of the events. Each
    /// threshold is that of a float sensor of its kernel alone. (`amacrine design` finds those of
    /// all kinds in one program, with the memory that they share.) Excludes --threshold.
    #[arg(long, value_name = "EVENTS", value_parser = event_rate, conflicts_with = "threshold")]
    rate: Option<f64>,
    #[command(flatten)]
    clip: Clip,
    /// Quantiser of the program [default: the best of --candidates]
    ///
    /// `amacrine quantise --help` lists the quantisers. The table has a row for each of
    /// --candidates in any case.
    #[arg(long, value_name = "QUANTISER", value_parser = super::arguments::quantiser::quantiser)]
    to: Option<Quantiser>,
    /// Quantisers in the table, one row each
    #[arg(long, value_delimiter = ',', value_name = "QUANTISERS", default_value = defaults::CANDIDATES, value_parser = super::arguments::quantiser::quantiser)]
    candidates: Vec<Quantiser>,
    /// Sum of the quantised kernel
    #[arg(long, value_enum, default_value_t)]
    sum: Total,
    /// Memory of the program of all kernels: analogue, bits:N or shared
    ///
    /// Default: as a sensor file of several kinds says; else the first of analogue, shared and bits
    /// for which the chip has room.
    #[arg(long, value_name = "WHERE", value_parser = memory)]
    memory: Option<DriveMemory>,
    /// Name of a shipped chip, or folder of your own
    #[arg(long, default_value = defaults::CHIP, help_heading = heading::CHIP)]
    chip: Named,
    /// Exposure of each frame, such as 2ms
    ///
    /// If left out, exposure does not limit the frame rate; the report states the longest that the
    /// frame rate leaves.
    #[arg(long, help_heading = heading::CHIP)]
    exposure: Option<Micros>,
    /// Energy of a bit on the link in pJ: one number or LO..HI
    ///
    /// This is an assumption: give that of your own link.
    #[arg(long, default_value_t = Energy::default(), value_name = "LO..HI", value_parser = energy, help_heading = heading::CHIP)]
    link_energy: Energy,
    /// Order of exposure and readout
    #[arg(long, value_enum, default_value = "overlapped", help_heading = heading::CHIP)]
    readout: Order,
    #[command(flatten)]
    window: Window,
    /// Number of simulated chips, drawn from what the public data allow
    #[arg(long, default_value_t = defaults::FEASIBILITY_CHIPS, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_CHIPS), help_heading = heading::CHIP)]
    chips: u64,
    /// Search effort for each program, in seconds
    ///
    /// The unit is a second of two cores of 2024 for one 3x3 kernel; larger kernels, and several
    /// kernels, take several times as long. The program counts states of the search, not time: a
    /// slower computer takes longer and finds the same program.
    #[arg(long, default_value_t = Effort::SECONDS, value_parser = super::arguments::effort::seconds, help_heading = heading::SEARCH)]
    effort: f64,
    /// Seed of the searches, of stochastic rounding and of the silicon
    #[arg(long, default_value_t = 0, help_heading = heading::SEARCH)]
    seed: u64,
    /// Write the page to this file
    #[arg(short, long, value_name = "REPORT.html", value_parser = Content::Page)]
    output: Option<Output>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
    /// Print what a number is made of, in place of the report
    ///
    /// The number is given by a name such as `array_us`, ceiling or power.busy, by a figure such as
    /// error.noise, or by a place in the JSON such as /power/known.
    #[arg(long, value_name = "NUMBER")]
    explain: Option<String>,
}

/// Chips that are drawn at most: each is a run.
const MOST_CHIPS: u64 = 1024;

/// Whether light is collected while events are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Order {
    /// The next frame is exposed while events are read
    Overlapped,
    /// The next exposure begins after the last event is read
    Sequential,
}

impl From<Order> for ReadoutOrder {
    fn from(order: Order) -> Self {
        match order {
            Order::Overlapped => Self::Overlapped,
            Order::Sequential => Self::Sequential,
        }
    }
}

/// The least and the most, pJ.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Energy(f64, f64);

impl Default for Energy {
    fn default() -> Self {
        let [least, most] = defaults::LINK_PJ;
        Self(least, most)
    }
}

/// As it is written.
impl fmt::Display for Energy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(least, most) = self;
        write!(f, "{least}..{most}")
    }
}

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

/// Sensors that watch side by side beside two for each quantiser: the float sensor and its
/// ladder.
const SENSORS: usize = RUNGS.len() + 1;

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let kinds = arguments.kernels.kinds()?;
    kinds.check_weights()?;
    let device = Device::find(&arguments.chip)?;
    if let Some(what) = &arguments.explain {
        feasibility::explain::check(what, &device)?;
    }
    let observation = Observation::new();
    let open = || arguments.clip.open(&observation);
    let scene = open()?;
    // The table, the waterfall, and all kernels together.
    let sensors = [
        SENSORS + 2 * (arguments.candidates.len() + 1),
        waterfall::SENSORS,
        kinds.kernels.len() * SENSORS + 2,
    ];
    budget::check_study(&*scene, sensors.into_iter().max().unwrap_or(SENSORS))?;
    let (frames, fps) = (scene.frames(), scene.fps());
    drop(scene);
    let command = arguments.command();
    let Energy(least, most) = arguments.link_energy;
    let mut questions = Vec::new();
    let early = Observation::new();
    let AtRate { thresholds, missed } = arguments.thresholds(&kinds, &device, &early)?;
    // The search for thresholds has seen the whole scene: what it warns of is said before the work.
    let told = Warning::of_scene(&early, Response::IDENTITY);
    light::warn(&told);
    if arguments.rate.is_some() && !arguments.json {
        super::say(&format!("threshold {}\n\n", list(&thresholds)));
    }
    let kernels = kinds.names.iter().zip(&kinds.kernels);
    for ((name, kernel), threshold) in kernels.zip(thresholds) {
        questions.push(Question {
            name,
            kernel,
            threshold,
            to: arguments.to,
            candidates: &arguments.candidates,
            sum: arguments.sum.into(),
            device: &device,
            memory: arguments.memory.or(kinds.memory),
            exposure: arguments.exposure,
            order: arguments.readout.into(),
            link: [least, most],
            effort: Effort::seconds(arguments.effort),
            seed: arguments.seed,
            readout: Choice::default().open_compiled()?.readout()?,
            within: arguments.window.at(fps),
            chips: arguments.chips,
            scene: arguments.clip.name(),
            command: &command,
        });
    }
    // For the table and for the sensors twice, for the waterfall, and for some chips at a time;
    // and once for all kernels together.
    let each = 5 + arguments.chips.div_ceil(8) + 4;
    let shows = match questions.len() {
        1 => each,
        n => each * n as u64 + 1,
    };
    let progress = Progress::new("watching", frames.map(|frames| shows * frames));
    let reply = feasibility::ask(&questions, &open, |_| progress.tick());
    progress.finish();
    let mut warnings = Warning::of_scene(&observation, Response::IDENTITY);
    warnings.extend(missed);
    light::warn_besides(&told, &warnings);
    let mut reply = reply?;
    warn_and_complete(&mut reply, &warnings, &observation);
    let explain = |what: &String| explanation(&reply, what, arguments.json);
    let explained = arguments.explain.as_ref().map(explain).transpose()?;
    if let Some(path) = &arguments.output {
        let page = report::page(&reply);
        save(path, |out| out.write_all(page.as_bytes()))?;
    }
    if let Some(chain) = explained {
        super::say(&chain);
        return Ok(());
    }
    if arguments.json {
        let json =
            serde_json::to_string(&WithLight::new(&reply, &observation)).into_diagnostic()?;
        super::say(&format!("{json}\n"));
        return Ok(());
    }
    let mut text = match &reply {
        Reply::One(one, _) => summary(one),
        Reply::Several(several, _) => summary_of_several(several),
    };
    text += &light::line(&observation);
    if let Some(path) = &arguments.output {
        let _ = writeln!(text, "\nwrote {}", path.display());
    }
    super::say(&text);
    Ok(())
}

/// Says the warnings of each kernel beside the output, then puts those of the scene before them,
/// and says of the light what was seen.
fn warn_and_complete(reply: &mut Reply, of_scene: &[Warning], observation: &Observation) {
    let is_several = reply.kernels().len() > 1;
    for all in reply.kernels() {
        light::warn_of(is_several.then_some(&all.kernel.name), &all.warnings);
    }
    reply.saw(of_scene, observation.words().as_deref());
}

/// From a number of each kernel to its sources, in words or in JSON.
fn explanation(reply: &Reply, what: &str, in_json: bool) -> miette::Result<String> {
    let mut chains = Vec::new();
    for all in reply.kernels() {
        chains.push((&all.kernel.name, feasibility::explain(all, what)?));
    }
    if let [(_, chain)] = &chains[..] {
        return Ok(if in_json {
            serde_json::to_string(chain).into_diagnostic()? + "\n"
        } else {
            chain.to_string()
        });
    }
    if in_json {
        let chains: Vec<_> = chains.iter().map(|(_, chain)| chain).collect();
        return Ok(serde_json::to_string(&chains).into_diagnostic()? + "\n");
    }
    let chains: Vec<String> = { chains.iter() }
        .map(|(name, chain)| format!("{name}:\n{chain}"))
        .collect();
    Ok(chains.join("\n"))
}

impl Arguments {
    /// A threshold for each kernel, and the kernels whose events no threshold brings to the rate.
    /// What is seen of the scene in a search for thresholds is noted in `seen`.
    fn thresholds(
        &self,
        kinds: &Kinds,
        device: &Device,
        seen: &Observation,
    ) -> miette::Result<AtRate> {
        let Some(asked) = self.rate else {
            return Ok(AtRate {
                thresholds: kinds.thresholds_or_rate("feasibility", &self.threshold)?,
                ..AtRate::default()
            });
        };
        let kernels = kinds.names.iter().map(String::as_str).zip(&kinds.kernels);
        let open = || self.clip.open(seen);
        feasibility::at_rate(kernels, (asked, self.seed), device, &open).wrap_err("--rate")
    }

    /// The command that gives the same page again, every default written out.
    fn command(&self) -> String {
        let mut line = CommandLine::new("feasibility");
        line.word(&self.kernels.to_string());
        if let Some(rate) = self.rate {
            line.option("rate", &rate.to_string());
        }
        if !self.threshold.is_empty() {
            line.option("threshold", &list(&self.threshold));
        }
        line.options(self.clip.written());
        if let Some(to) = self.to {
            line.option("to", &to.to_string());
        }
        let candidates: Vec<String> = self.candidates.iter().map(Quantiser::to_string).collect();
        line.option("candidates", &candidates.join(","));
        line.option("sum", self.sum.name());
        if let Some(memory) = self.memory {
            line.option("memory", &memory.to_string());
        }
        line.option("chip", &self.chip);
        if let Some(exposure) = self.exposure {
            line.option("exposure", &format!("{}us", exposure.0));
        }
        line.option("link-energy", &self.link_energy.to_string());
        let order = ReadoutOrder::from(self.readout);
        line.option("readout", order.name());
        line.option("chips", &self.chips.to_string());
        if let Some(within) = self.window.within {
            line.option("within", &format!("{}us", within.0));
        }
        line.option("effort", &self.effort.to_string());
        line.option("seed", &self.seed.to_string());
        format!("{line} -o report.html")
    }
}

/// Words with commas between them.
fn list(words: &[impl ToString]) -> String {
    let words: Vec<_> = words.iter().map(ToString::to_string).collect();
    words.join(",")
}

/// What all kernels together take, a line for each of them, and each on its own.
fn summary_of_several(several: &Several) -> String {
    let together = &several.together;
    let mut text = format!("{}\n\n{}\n\n", together.headline, together.says);
    let names = together.kinds.iter().map(|kind| kind.name.chars().count());
    let width = names.max().unwrap_or(0).max(22);
    let _ = writeln!(
        text,
        "{:<width$} {:>10} {:>10} {:>14} {:>10}",
        "in one program", "to", "kept", "as threshold", "alone"
    );
    for kind in &together.kinds {
        let _ = writeln!(
            text,
            "{:<width$} {:>10} {:>10} {:>14} {:>10}",
            kind.name,
            kind.to,
            equivalent::kept(kind.headline.and_then(|headline| headline.kept), 3),
            kind.silicon
                .map_or("-".to_owned(), |silicon| silicon.equivalent()),
            equivalent::kept(kind.kept_apart, 3),
        );
    }
    for all in &several.kernels {
        let _ = write!(text, "\n{}: {}", all.kernel.name, summary(all));
    }
    text
}

/// The verdict, and the streams as a table.
fn summary(all: &Feasibility) -> String {
    let mut text = format!("{}\n\n", all.verdict.headline);
    for finding in &all.verdict.findings {
        let _ = writeln!(text, "{:<12} {}", finding.about, finding.says);
    }
    let streams = &all.streams;
    let judged = streams.dvs.judged;
    let _ = writeln!(
        text,
        "\n{:<22} {:>10} {:>10} {:>10} {:>8} {:>8} {:>11}{}",
        "",
        "events",
        "kbit/s",
        "F1",
        "floor",
        "kept",
        "threshold",
        judged.map_or(String::new(), |judged| {
            let (window, fps) = (judged.headline.window_us, judged.headline.fps);
            format!(
                "   (within {}, {} frames/s)",
                Short(window),
                frame_rate(fps)
            )
        })
    );
    let rows = [
        ("plain DVS", Some(&streams.dvs)),
        ("float kernel", Some(&streams.float)),
        ("program, no errors", streams.exact.as_ref()),
        ("program on the chip", streams.silicon.as_ref()),
    ];
    for (name, stream) in rows {
        if let Some(stream) = stream {
            text += &row(name, stream, streams.float.events > 0);
        }
    }
    text += &over_chips(&all.over_chips);
    if let Fit::OnChip(chip) = &all.fit {
        let time = &chip.time;
        let _ = writeln!(
            text,
            "\n{} a frame: {} on the array, {} of readout ({}, {}); {} at most, {} with all slots of the program",
            crate::unit::counted(chip.frame_words, "word"),
            time.array,
            time.readout,
            time.plan.in_words(),
            time.order.name(),
            time.ceiling,
            time.ceiling_as_programmed,
        );
        let rows = time.plans.iter().map(|plan| readout_table::Row {
            way: plan.plan,
            slots: plan.slots,
            us: plan.time.ends(),
            frames_s: plan.frames_s.ends(),
            lost: Some(plan.lost),
            is_chosen: plan.is_chosen,
        });
        let _ = write!(text, "\n{}\n", readout_table::table(rows));
    }
    if let Some(power) = &all.power {
        let mut unknown = Vec::new();
        for part in power.parts() {
            if part.power.is_none() {
                let most = part.at_most.as_ref().map_or(String::new(), |most| {
                    format!(" (at most {:.0} {})", most.high, most.unit)
                });
                unknown.push(format!("{}{most}", part.what));
            }
        }
        let _ = writeln!(
            text,
            "{} known at {} frames/s ({}), {} a frame; not known: {}",
            power.known,
            frame_rate(all.scene.fps),
            power.known.evidence.word(),
            power.frame,
            unknown.join(", ")
        );
    }
    text
}

/// The numbers that decide most are shown, so many.
const DECIDING: usize = 5;

/// How many chips, what lies between 10 and 90 % of them, and what decides.
fn over_chips(over: &OverChips) -> String {
    let mut text = String::new();
    let (Some(ranges), Some(evidence)) = (&over.ranges, over.chips_evidence) else {
        return text;
    };
    let _ = writeln!(
        text,
        "\n{:<22} {:>10} {:>10} {:>10}   of {} that the public data allow ({})",
        "",
        "10 %",
        "median",
        "90 %",
        crate::unit::counted(over.chips, "chip"),
        evidence.word()
    );
    if let Some(why) = over.unjudged() {
        let _ = writeln!(text, "{:<22} {why}", "kept");
    }
    let threshold = ranges.threshold_equivalent_percent;
    let rows = [
        ("kept", ranges.kept, 3),
        ("threshold, % higher", threshold, 1),
        ("events to the float's", ranges.event_ratio, 3),
        ("frames/s at most", Some(ranges.frames_s), 0),
        ("mW, array busy", Some(ranges.power_busy_mw), 3),
    ];
    for (name, spread, decimals) in rows {
        if let Some(spread) = spread {
            let _ = writeln!(
                text,
                "{name:<22} {:>10.decimals$} {:>10.decimals$} {:>10.decimals$}",
                spread.p10, spread.median, spread.p90
            );
        }
    }
    let mut turns = { over.tornado.iter() }
        .filter_map(|turn| Some((turn, turn.kept()?)))
        .take(DECIDING)
        .peekable();
    if turns.peek().is_none() {
        return text;
    }
    let _ = writeln!(
        text,
        "\n{:<26} {:>10} {:>10} {:>10} {:>10}   one number turned, all others as stated",
        "what decides", "low", "high", "kept", "kept"
    );
    for (turn, [at_low, at_high, _]) in turns {
        let _ = writeln!(
            text,
            "{:<26} {:>10} {:>10} {at_low:>10.3} {at_high:>10.3}   {}, {}",
            turn.figure,
            turn.low,
            turn.high,
            turn.unit,
            turn.evidence.word()
        );
    }
    text
}

/// The numbers of a stream; without scores where the float kernel has no event to keep.
fn row(name: &str, stream: &Stream, is_scored: bool) -> String {
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let judged = stream.judged.filter(|_| is_scored);
    let likeness = judged.map(|judged| judged.likeness);
    format!(
        "{name:<22} {:>10} {:>10} {:>10} {:>8} {:>8} {:>11}\n",
        stream.events,
        number(stream.mean_kbit_s, 1),
        number(likeness.map(|it| it.f1), 4),
        number(likeness.map(|it| it.floor), 4),
        number(likeness.and_then(|it| it.kept), 4),
        { likeness.filter(Likeness::is_judged) }.map_or("-".to_owned(), |it| it.equivalent()),
    )
}
