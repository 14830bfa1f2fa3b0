//! The command line: the only place that prints.

use std::{
    io::IsTerminal,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use amacrine::save::save;
use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use miette::{IntoDiagnostic, Result, miette};

use crate::{
    arm::{self, Sight},
    network::Network,
    report::Report,
    task::Task,
    train::{Job, Run, Trainee},
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
    let (mut task, text) = Task::open(&asked.task)?;
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
    let run = Run::new((&task, &text), &asked.output, asked.resume || asked.dry_run)?;
    let jobs = run.jobs().into_iter();
    let jobs: Vec<Job<'_>> = jobs
        .filter(|job| asked.arm.is_empty() || asked.arm.contains(&job.arm.name))
        .collect();
    announce(&task, &run, &jobs)?;
    if asked.dry_run {
        return Ok(());
    }
    let mut failed = 0;
    for (n, job) in jobs.iter().enumerate() {
        let name = crate::train::name(job.arm, job.target, job.seed);
        let bar = bar(&task, &format!("{}/{} {name}", n + 1, jobs.len()));
        let done = run.train(job, &mut |state| {
            bar.set_position(state.step);
            let [loss, rate] = state.means;
            bar.set_message(format!("loss {loss:.5}, {rate:.4} events/px/pair"));
        });
        bar.finish_and_clear();
        match done {
            Ok(()) => println!("{name}: done"),
            // Others may well reach their targets.
            Err(error) if error.is_of_the_arm() => {
                failed += 1;
                eprintln!("{:?}", miette::Report::from(error));
            }
            Err(error) => return Err(error.into()),
        }
        run.record()?;
    }
    report(&asked.output)?;
    if failed > 0 {
        return Err(miette!(
            "{failed} of {} arms could not be trained",
            jobs.len()
        ));
    }
    Ok(())
}

fn bar(task: &Task, name: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(task.steps).with_prefix(name.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} {eta} {msg}") {
        bar.set_style(style);
    }
    bar
}

/// Steps that an arm's time is taken from.
const PILOT: u32 = 3;

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
    let mut total = Duration::ZERO;
    let mut most = 0;
    for arm in &task.arms {
        let own: Vec<_> = jobs.iter().filter(|job| job.arm.name == arm.name).collect();
        let Some(job) = own.first() else { continue };
        let mut trainee = Trainee::new((task, arm), (job.target, job.seed), run.training())?;
        // The first step is slower.
        trainee.step(run.training())?;
        let start = Instant::now();
        for _ in 0..PILOT {
            trainee.step(run.training())?;
        }
        let step = start.elapsed() / PILOT;
        let steps = if arm.sight == Sight::Blend {
            0
        } else {
            task.steps
        };
        let each = step.mul_f64(steps as f64);
        total += each * own.len() as u32;
        let bytes = bytes(task, trainee.network()) + run.training().bytes();
        most = most.max(bytes);
        println!(
            "  {:<12} {} x {:.1} min, {:.0} ms a step, {} weights, {:.0} MB",
            arm.name,
            own.len(),
            each.as_secs_f64() / 60.0,
            step.as_secs_f64() * 1e3,
            trainee.network().parameters(),
            bytes as f64 * 1e-6
        );
    }
    println!(
        "about {:.0} min in all on {} threads, {:.0} MB",
        total.as_secs_f64() / 60.0,
        rayon::current_num_threads(),
        most as f64 * 1e-6
    );
    Ok(())
}

/// What a step holds: maps there and back of all clips, weights and their moments for each clip.
fn bytes(task: &Task, network: &Network<f32>) -> usize {
    let light = task.batch * task.scenes.frames * task.crop * task.crop * 12;
    let groups = task.batch.div_ceil(network.shape().pictures());
    groups * (network.map_bytes() * 2 + network.parameters() * 4)
        + network.parameters() * 20
        + light
}
