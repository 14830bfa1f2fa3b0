//! `amacrine design`: from kernels and a scene to a sensor, its program and its report.

mod report;
mod table;

use std::{
    cell::RefCell,
    path::{Path, PathBuf},
};

use miette::{WrapErr, miette};
use serde_json::json;

use super::{
    arguments::{
        budget,
        clip::{Clip, goes_on},
        event_rate::event_rate,
        heading,
        kernel_names::KernelNames,
        light,
        quantiser::Total,
        window::Window,
    },
    compile::memory,
    input::kernels::Kinds,
    output::{
        command_line::CommandLine,
        content::Content,
        files::{self, Named, Output},
        progress::Progress,
    },
};
use crate::{
    compile::{DriveMemory, Effort, FRAMES},
    isa::Device,
    kernel::quantise::Quantiser,
    photoreceptor::Response,
    rig::guard::Warning,
    save::{Together, TogetherError},
    scene::Observation,
    study::{
        defaults,
        equivalent::RUNGS,
        exploration::{Aim, Exploration, Question, explore},
        together::{CHIPS, memories},
    },
};

/// What `design` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "amacrine design [OPTIONS] <KERNELS>...",
    after_help = "Examples:\n  amacrine design rgc-5x5 --rate 2 -o centre\n  amacrine design four.npy --scene clip.mp4 --rate 4 -o four\n  amacrine design four.npy --scene clip.mp4 --rate 4 --to ternary,int-5 --pick 2 -o four\n  amacrine design rgc-4-on-chip\n\nEvery row of the table was compiled and has run on the model of the chip. Without -o nothing is written."
)]
pub struct Arguments {
    #[command(flatten)]
    kernels: KernelNames,
    /// Events per pixel and second to reach, all kinds together
    ///
    /// The program finds the thresholds; each kind has an equal share of the events. Excludes
    /// --threshold.
    #[arg(long, value_name = "EVENTS", value_parser = event_rate, conflicts_with = "threshold")]
    rate: Option<f64>,
    /// Thresholds in kernel times light (0 to 255): one for all kernels, or one for each
    ///
    /// Required, unless --rate is given or KERNELS are sensor files, which have their own. Excludes
    /// --rate.
    #[arg(long, value_delimiter = ',', value_name = "THRESHOLDS")]
    threshold: Vec<f64>,
    #[command(flatten)]
    clip: Clip,
    /// Quantisers to try (`amacrine quantise --help` lists them)
    #[arg(long, value_delimiter = ',', value_name = "QUANTISERS", default_value = defaults::CANDIDATES, value_parser = super::arguments::quantiser::quantiser)]
    to: Vec<Quantiser>,
    /// Memory of the program: analogue, bits:N or shared
    ///
    /// Default: the program tries all that the chip has room for.
    #[arg(long, value_name = "WHERE", value_parser = memory)]
    memory: Option<DriveMemory>,
    /// Sum of the quantised kernel
    #[arg(long, value_enum, default_value_t)]
    sum: Total,
    /// Name of a shipped chip, or folder of your own
    #[arg(long, default_value = defaults::CHIP, help_heading = heading::CHIP)]
    chip: Named,
    #[command(flatten)]
    window: Window,
    /// Row of the table to write: its number, knee or best
    ///
    /// `best` is the row that keeps most. `knee` is the shortest program that keeps nearly as much;
    /// if no row keeps anything, it is `best`.
    #[arg(long, default_value = "knee", value_name = "N|knee|best")]
    pick: Pick,
    /// Number of chips in the report of -o, drawn from what the public data allow [default: 8]
    #[arg(long, value_name = "N", requires = "output", value_parser = clap::value_parser!(u64).range(1..=1024), help_heading = heading::CHIP)]
    chips: Option<u64>,
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
    /// Write sensor.toml, program.scamp and report.html to this folder
    ///
    /// If left out, nothing is written.
    #[arg(short, long, value_name = "DIR", value_parser = Content::Folder)]
    output: Option<Output>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// Which candidate is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pick {
    /// The shortest program that keeps nearly as much as the best.
    Knee,
    /// The one that keeps most.
    Best,
    /// This row, from 1.
    Row(usize),
}

impl std::str::FromStr for Pick {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "knee" => Ok(Self::Knee),
            "best" => Ok(Self::Best),
            row => match row.parse() {
                Ok(row) if row > 0 => Ok(Self::Row(row)),
                _ => Err(format!(
                    "`{row}` is neither knee nor best nor the number of a row, from 1"
                )),
            },
        }
    }
}

impl Pick {
    /// Refuses a row beyond so many.
    fn check(self, rows: usize) -> miette::Result<()> {
        match self {
            Self::Row(row) if row > rows => Err(miette!(
                help = format!("give a number from 1 to {rows}, knee or best"),
                "--pick {row}: the table has {}",
                crate::unit::counted(rows, "row")
            )),
            _ => Ok(()),
        }
    }

    /// Index among the candidates.
    fn of(self, all: &Exploration) -> miette::Result<usize> {
        self.check(all.candidates.len())?;
        Ok(match self {
            Self::Knee => all.knee.unwrap_or(0),
            Self::Best => 0,
            Self::Row(row) => row - 1,
        })
    }
}

/// What is written, by name.
struct Written {
    sensor: PathBuf,
    program: PathBuf,
    report: PathBuf,
}

impl Written {
    fn new(folder: &Path) -> Self {
        Self {
            sensor: folder.join("sensor.toml"),
            program: folder.join("program.scamp"),
            report: folder.join("report.html"),
        }
    }

    fn all(&self) -> [&Path; 3] {
        [&self.sensor, &self.program, &self.report]
    }

    /// Writes all of them before the first has its name.
    fn write(&self, texts: &[String; 3]) -> Result<(), TogetherError> {
        let mut files = Together::new();
        for (path, text) in self.all().into_iter().zip(texts) {
            files.add(path, |out| out.write_all(text.as_bytes()))?;
        }
        files.keep()
    }
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let kinds = arguments.kernels.kinds()?;
    kinds.check_weights()?;
    let device = Device::find(&arguments.chip)?;
    let thresholds = arguments.thresholds(&kinds)?;
    // Before all the work: more rows than this there cannot be.
    let ways = match arguments.memory {
        Some(_) => 1,
        None => memories(kinds.kernels.len()).len(),
    };
    arguments.pick.check(ways * arguments.to.len())?;
    let folder = arguments.output.as_ref();
    let written = folder.map(|folder| Written::new(folder));
    if let Some(written) = &written {
        files::writes(written.all())?;
    }
    let title = folder.and_then(|folder| folder.file_name()?.to_str());
    let title = title.unwrap_or("design");
    let question = Question {
        title,
        names: &kinds.names,
        kernels: &kinds.kernels,
        aim: match (arguments.rate, &thresholds) {
            (Some(rate), _) => Aim::Rate(rate),
            (None, thresholds) => Aim::Thresholds(thresholds),
        },
        quantisers: &arguments.to,
        memory: arguments.memory,
        sum: arguments.sum.into(),
        device: &device,
        effort: Effort::seconds(arguments.effort),
        seed: arguments.seed,
        within: arguments.window.within,
    };
    let observation = Observation::new();
    let scene = arguments.clip.open(&observation)?;
    arguments.clip.check_fits(&*scene, &device)?;
    let sensors =
        (RUNGS.len() + 1) * kinds.kernels.len() + ways * (1 + CHIPS as usize) * arguments.to.len();
    budget::check_study(&*scene, sensors)?;
    drop(scene);
    let open = || arguments.clip.open(&observation);
    let progress = Progress::spinner("thresholds");
    let told = RefCell::new(None);
    let searching = |at: usize, of: usize| {
        // The search for thresholds has seen the scene: what it warns of is said before the work.
        told.borrow_mut().get_or_insert_with(|| {
            let warnings = Warning::of_scene(&observation, Response::IDENTITY);
            progress.aside(|| light::warn(&warnings));
            warnings
        });
        progress.says(format!("program {at} of {of}"));
    };
    let mut frames = 0;
    let found = explore(&question, &open, &searching, |_| {
        frames += 1;
        progress.says(format!("watching, frame {frames}"));
    });
    let found = found.wrap_err_with(|| format!("a sensor for {}", arguments.clip.name()))?;
    let picked = arguments.pick.of(&found)?;
    let candidate = &found.candidates[picked];
    if let Some(written) = &written {
        progress.says("report");
        let page = report::page(arguments, candidate, &written.sensor, &question, found.fps)?;
        let texts = [candidate.sensor.to_toml(), candidate.program.clone(), page];
        written.write(&texts)?;
    }
    progress.finish();
    let answer = found.answer(&question, picked, arguments.clip.name(), &observation)?;
    light::warn_besides(&told.into_inner().unwrap_or_default(), &answer.warnings);
    let commands = written
        .as_ref()
        .map(|written| arguments.commands(written, found.frames));
    if arguments.json {
        let mut json = json!(answer);
        let written = written.as_ref().map(|it| it.all().map(Path::to_path_buf));
        json["written"] = json!(written);
        json["commands"] = json!(commands);
        super::say(&format!("{json}\n"));
        return Ok(());
    }
    let mut text = table::text(arguments, &found, picked, &light::line(&observation));
    if let (Some(written), Some(commands)) = (&written, &commands) {
        for path in written.all() {
            text += "wrote    ";
            text += &path.display().to_string();
            text += "\n";
        }
        text += "\n";
        for command in commands {
            text += command;
            text += "\n";
        }
    }
    super::say(&text);
    Ok(())
}

impl Arguments {
    /// A threshold for each kernel, where no rate is asked for.
    fn thresholds(&self, kinds: &Kinds) -> miette::Result<Vec<f64>> {
        if self.rate.is_some() {
            return Ok(Vec::new());
        }
        let thresholds = kinds.thresholds_or_rate("a design", &self.threshold)?;
        for ((name, kernel), threshold) in kinds.names.iter().zip(&kinds.kernels).zip(&thresholds) {
            let most = 255.0 * kernel.magnitude();
            if *threshold >= most {
                return Err(miette!(
                    help = "give a lower threshold, in kernel times light (0 to 255), or --rate EVENTS, per pixel and second",
                    "{name}: no light gives an event: the threshold is {threshold:?}, and kernel times light (0 to 255) changes by {most} at most"
                ));
            }
        }
        Ok(thresholds)
    }

    /// Chips that are drawn for the report.
    fn chips(&self) -> u64 {
        self.chips.unwrap_or(8)
    }

    /// The commands that use what was written: the float sensor, the program, its proof.
    fn commands(&self, written: &Written, frames: u64) -> [String; 3] {
        let scene = self.clip.given().unwrap_or("bundled");
        let light = |line: &mut CommandLine| {
            let all = self.clip.written().into_iter();
            line.options(all.filter(|(name, _)| *name != "scene"));
        };
        let of_program = |verb| {
            let mut line = CommandLine::new(verb);
            line.word(&written.program.display().to_string());
            if &*self.chip != "scamp5" {
                line.option("chip", &self.chip);
            }
            line
        };
        let mut run = CommandLine::new("run");
        run.option("scene", scene);
        light(&mut run);
        run.option("sensor", &written.sensor.display().to_string());
        run.option("events", "events.npy");
        let mut exec = of_program("exec");
        exec.option("image", scene);
        light(&mut exec);
        // A scene that ends before the program would stand still.
        if frames < FRAMES || self.clip.given().is_some_and(goes_on) {
            exec.option("frames", &frames.to_string());
        }
        if self.seed != 0 {
            exec.option("seed", &self.seed.to_string());
        }
        exec.option("domain", "silicon");
        exec.option("events", "silicon.npy");
        [run, exec, of_program("asm")].map(|line| line.to_string())
    }
}
