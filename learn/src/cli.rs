//! The command line: the only place that prints.

use std::{
    io::IsTerminal,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use amacrine::save::save;
use clap::{Parser, Subcommand};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use miette::{IntoDiagnostic, Result, miette};

use crate::{
    arm::{self, Sight},
    network::Network,
    report::Report,
    task::Task,
    train::{Job, Progress, Run, State, Trainee},
};

/// Learns kernels and thresholds of event sensors for a task, and judges them at equal bits.
#[derive(Debug, Parser)]
#[command(
    name = "amacrine-learn",
    version,
    args_conflicts_with_subcommands = true
)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    run: Option<RunArguments>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// The verdict on a run: a table, and a page in its folder
    Report {
        /// The run's folder
        run: PathBuf,
    },
}

/// What to train.
#[derive(Debug, clap::Args)]
struct RunArguments {
    /// The task file, such as tasks/interpolation.toml
    #[arg(value_name = "TASK.toml")]
    task: PathBuf,
    /// The run's folder
    #[arg(short, long, value_name = "RUN")]
    output: PathBuf,
    /// Only this arm of the task; may be given again
    #[arg(long, value_name = "ARM")]
    arm: Vec<String>,
    /// A folder of photographs in place of the task's
    #[arg(long, value_name = "DIR")]
    photos: Option<PathBuf>,
    /// Threads; one for each core when left out. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Go on where a run in this folder has stopped
    #[arg(long)]
    resume: bool,
    /// Only say what would be done, and how long it would take
    #[arg(long)]
    dry_run: bool,
}

/// Does what the arguments say.
///
/// # Errors
/// What went wrong, as it is to be told.
pub fn run(arguments: Arguments) -> Result<()> {
    match (arguments.verb, arguments.run) {
        (Some(Verb::Report { run }), _) => report(&run),
        (None, Some(run)) => train(&run),
        (None, None) => Err(miette!(
            help = "amacrine-learn tasks/interpolation.toml -o RUN",
            "no task was given"
        )),
    }
}

fn report(run: &Path) -> Result<()> {
    let report = Report::read(run)?;
    print!("{}", report.table());
    let page = run.join("report.html");
    let text = report.page();
    save(&page, |out| out.write_all(text.as_bytes()))?;
    println!("{}", page.display());
    Ok(())
}

fn train(asked: &RunArguments) -> Result<()> {
    if let Some(threads) = asked.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().into_diagnostic()?;
    }
    let mut task = Task::open(&asked.task)?;
    if let Some(photos) = &asked.photos {
        task.scenes.photographs = Some(photos.clone());
        task.scenes.video = None;
    }
    for name in &asked.arm {
        if !task.arms.iter().any(|arm| arm.name == *name) {
            let own: Vec<_> = task.arms.iter().map(|arm| arm.name.as_str()).collect();
            let known = if arm::NAMES.contains(&name.as_str()) {
                "add it to `arms` in the task file"
            } else {
                "give one of these"
            };
            return Err(miette!(
                help = format!("{known}: {}", own.join(", ")),
                "{}: no arm `{name}` takes part",
                asked.task.display()
            ));
        }
    }
    let run = Run::new(&task, &asked.output, asked.resume || asked.dry_run)?;
    let jobs = run.jobs().into_iter();
    let jobs: Vec<Job<'_>> = jobs
        .filter(|job| asked.arm.is_empty() || asked.arm.contains(&job.arm.name))
        .collect();
    announce(&task, &run, &jobs)?;
    if asked.dry_run {
        return Ok(());
    }
    let bars = Bars::new(&task, jobs.len());
    let ended = Mutex::new((0, Ok(())));
    run.train_all(&jobs, together(&jobs), &|n, progress| {
        let job = &jobs[n];
        let name = crate::train::name(job.arm, job.target, job.seed);
        match progress {
            Progress::Begun => bars.begin(n, &name),
            Progress::Step(state) => bars.step(n, state),
            Progress::Ended(done) => {
                bars.end(n);
                let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
                let done = done.and_then(|()| run.record().map(|_| ()));
                match done {
                    Ok(()) => println!("{name}: done"),
                    // Others may well reach their targets.
                    Err(error) if error.is_of_the_arm() => {
                        ended.0 += 1;
                        eprintln!("{:?}", miette::Report::from(error));
                    }
                    Err(error) => ended.1 = Err(error),
                }
            }
        }
    });
    let (failed, done) = ended.into_inner().unwrap_or_else(PoisonError::into_inner);
    done?;
    run.record()?;
    report(&asked.output)?;
    if failed > 0 {
        return Err(miette!(
            "{failed} of {} arms could not be trained",
            jobs.len()
        ));
    }
    Ok(())
}

/// Jobs at a time: one on each thread, since the parts of a step are few.
fn together(jobs: &[Job<'_>]) -> usize {
    rayon::current_num_threads().min(jobs.len())
}

/// A bar for each job that is being trained; none where nobody looks.
struct Bars {
    all: MultiProgress,
    own: Vec<ProgressBar>,
}

impl Bars {
    fn new(task: &Task, jobs: usize) -> Self {
        let hidden = !std::io::stderr().is_terminal();
        let target = if hidden {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = |_| {
            let hidden = ProgressDrawTarget::hidden();
            ProgressBar::with_draw_target(Some(task.steps), hidden)
        };
        Self {
            all: MultiProgress::with_draw_target(target),
            own: (0..jobs).map(bar).collect(),
        }
    }

    fn begin(&self, n: usize, name: &str) {
        let template = "{prefix} {bar:30} {pos}/{len} {eta} {msg}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.own[n].set_style(style);
        }
        self.own[n].set_prefix(format!("{}/{} {name}", n + 1, self.own.len()));
        self.all.add(self.own[n].clone());
        self.own[n].reset();
    }

    fn step(&self, n: usize, state: &State) {
        let [loss, rate] = state.means;
        let words = state
            .words
            .map_or(String::new(), |words| format!(", {words} words"));
        self.own[n].set_position(state.step);
        self.own[n].set_message(format!("loss {loss:.5}, {rate:.4} events/px/pair{words}"));
    }

    fn end(&self, n: usize) {
        self.own[n].finish_and_clear();
    }
}

/// Steps that an arm's time is taken from.
const PILOT: u64 = 6;

/// Says what is to be done, how long it takes, and what it holds.
fn announce(task: &Task, run: &Run<'_>, jobs: &[Job<'_>]) -> Result<()> {
    println!(
        "{}: {} arms of {} steps, {} clips of {}x{} in each",
        task.name,
        jobs.len(),
        task.steps,
        task.batch,
        task.crop,
        task.crop
    );
    // As it will be done: on one thread, the jobs side by side.
    let together = together(jobs);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(if together > 1 {
        1
    } else {
        rayon::current_num_threads()
    });
    let pool = pool.build().into_diagnostic()?;
    let mut total = Duration::ZERO;
    let mut most: usize = 0;
    // What has few levels is judged longest: its program is sought longest.
    let few = |job: &&Job<'_>| job.arm.cells().map(|cells| cells.few.is_some());
    let judged = jobs.iter().max_by_key(few).map(|job| job.arm.name.as_str());
    let mut judge = Duration::ZERO;
    for arm in &task.arms {
        let own: Vec<_> = jobs.iter().filter(|job| job.arm.name == arm.name).collect();
        let Some(job) = own.first() else { continue };
        let timed = pool.install(|| {
            let judged = judged == Some(&arm.name);
            Timed::new((task, run), job, judged)
        })?;
        judge = judge.max(timed.judge);
        total += timed.steps * own.len() as u32;
        most = most.max(timed.bytes);
        println!(
            "  {:<12} {} x {:.1} min, {:.0} ms a step, {} weights, {:.0} MB",
            arm.name,
            own.len(),
            timed.steps.as_secs_f64() / 60.0,
            timed.step.as_secs_f64() * 1e3,
            timed.weights,
            timed.bytes as f64 * 1e-6
        );
    }
    let told = jobs.iter().filter(|job| job.arm.cells().is_some()).count();
    println!(
        "  {told} x {:.0} s to judge on the chip at most",
        judge.as_secs_f64()
    );
    total += judge * told as u32;
    println!(
        "about {:.0} min in all, {together} at a time, {:.0} MB",
        total.as_secs_f64() / 60.0 / together as f64,
        (most * together + run.training().bytes()) as f64 * 1e-6
    );
    Ok(())
}

/// How long a job takes, by a few of its steps.
struct Timed {
    step: Duration,
    /// All of them.
    steps: Duration,
    /// Judging it as it then is, where that was asked for.
    judge: Duration,
    weights: usize,
    bytes: usize,
}

impl Timed {
    fn new((task, run): (&Task, &Run<'_>), job: &Job<'_>, judged: bool) -> Result<Self> {
        let mut trainee = Trainee::new((task, job.arm), (job.target, job.seed), run.training())?;
        let steps = if job.arm.sight == Sight::Blend {
            0
        } else {
            task.steps
        };
        let begun = trainee.state.clone();
        let mut step = Duration::MAX;
        // The second time their clips are there, as in most steps of a run.
        for _ in 0..2 {
            trainee.state = begun.clone();
            let start = Instant::now();
            for _ in 0..PILOT.min(steps) {
                trainee.step(run.training())?;
            }
            step = step.min(start.elapsed() / PILOT as u32);
        }
        let start = Instant::now();
        if judged {
            run.judge(&trainee, None)?;
        }
        let judge = start.elapsed();
        Ok(Self {
            step,
            judge,
            steps: step.mul_f64(steps as f64),
            weights: trainee.network().parameters(),
            bytes: bytes(task, trainee.network()),
        })
    }
}

/// What a step holds: maps there and back of all clips, weights and their moments for each clip.
fn bytes(task: &Task, network: &Network<f32>) -> usize {
    let light = task.batch * task.scenes.frames * task.crop * task.crop * 12;
    let groups = task.batch.div_ceil(network.shape().pictures());
    groups * (network.map_bytes() * 2 + network.parameters() * 4)
        + network.parameters() * 20
        + light
}
