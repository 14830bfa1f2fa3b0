//! The command line: the only place that prints.

mod bars;
mod begin;
mod forecast;
mod print;

use std::{
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use amacrine::{memory::Budget, save::save, unit::fixed};
use clap::{Parser, Subcommand};
use miette::{IntoDiagnostic, Result, miette};

use crate::{
    arm,
    record::Record,
    report::Report,
    scene::Clips,
    task::Task,
    train::{DeadTime, Job, Progress, Run, TrainError, jobs},
};

use self::{
    bars::Bars,
    forecast::{announce, together},
    print::{complain, say},
};

pub use print::failed;

/// Learns kernels and thresholds of event sensors for a task, and judges them at equal bits.
#[derive(Debug, Parser)]
#[command(
    name = "amacrine-learn",
    version,
    subcommand_negates_reqs = true,
    override_usage = "amacrine-learn [OPTIONS] --output <RUN> <TASK.toml>\n       amacrine-learn [OPTIONS] <COMMAND>"
)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    run: Option<RunArguments>,
    /// Number of threads; it does not change the results [default: one for each core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Memory limit, such as 500M or 4G (powers of 1024) [default: three quarters of the machine's]
    ///
    /// Work that needs more is refused before it starts.
    #[arg(long, global = true, value_name = "SIZE")]
    max_memory: Option<Budget>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Judge a run: a table, and a page in its folder
    Report {
        /// Folder of the run
        run: PathBuf,
    },
    /// Write a task file to start from, with all keys that it may have
    New {
        /// Path of the file, without its ending
        name: PathBuf,
    },
    /// Print the keys of a task file as JSON Schema, for editors and checkers
    Schema {
        /// Write the schema to this file, in place of printing it
        #[arg(short, long, value_name = "FILE.json")]
        output: Option<PathBuf>,
    },
}

/// What to train.
#[derive(Debug, clap::Args)]
struct RunArguments {
    /// Task file; `amacrine-learn new NAME` writes one to start from
    #[arg(value_name = "TASK.toml")]
    task: PathBuf,
    /// Folder of the run
    #[arg(short, long, value_name = "RUN")]
    output: PathBuf,
    /// Arm of the task to train; may be repeated [default: all]
    #[arg(long, value_name = "ARM")]
    arm: Vec<String>,
    /// Folder of photographs, in place of the task's
    #[arg(long, value_name = "DIR")]
    photos: Option<PathBuf>,
    /// Go on where the run in this folder stopped
    #[arg(long)]
    resume: bool,
    /// Print what would be done and how long it would take, and do nothing
    #[arg(long)]
    dry_run: bool,
}

/// Does what the arguments say.
///
/// # Errors
/// What went wrong, as it is to be told.
pub fn run(arguments: Arguments) -> Result<()> {
    print::handle_errors();
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().into_diagnostic()?;
    }
    let budget = arguments.max_memory.unwrap_or_else(Budget::from_machine);
    match (arguments.verb, arguments.run) {
        (Some(_), Some(run)) => Err(miette!(
            help =
                "give a task with -o RUN, or one of report, new, schema: `amacrine-learn --help`",
            "{} is not an option of this verb",
            run.task.display()
        )),
        (Some(Verb::Report { run }), None) => report(&run),
        (Some(Verb::New { name }), None) => begin::task(&name),
        (Some(Verb::Schema { output }), None) => begin::schema(output.as_deref()),
        (None, Some(run)) => train(&run, budget),
        (None, None) => Err(miette!(
            help = "amacrine-learn TASK.toml -o RUN; `amacrine-learn new NAME` writes a task to start from",
            "no task was given"
        )),
    }
}

fn report(run: &Path) -> Result<()> {
    let report = Report::read(run)?;
    let page = run.join("report.html");
    let text = report.page();
    save(&page, |out| out.write_all(text.as_bytes()))?;
    say(&format!("{}{}\n", report.table(), page.display()))
}

fn train(asked: &RunArguments, budget: Budget) -> Result<()> {
    let (mut task, text) = Task::open_with_text(&asked.task)?;
    if let Some(photos) = &asked.photos {
        task.scenes.photographs = Some(photos.clone());
        task.scenes.video = None;
    }
    check_arms(&task, asked)?;
    let told = |error| of_task(error, &task, asked);
    // Before anything of it is there.
    check_memory((&task, asked), &wanted(jobs(&task), asked), budget)?;
    let place = (&*asked.output, asked.resume || asked.dry_run);
    let run = Run::within(&task, place, budget).map_err(told)?;
    // Held until all is done: two would write over each other.
    let lock = (!asked.dry_run).then(|| run.lock());
    let _lock = lock.transpose()?;
    if !asked.dry_run {
        run.keep_task(&text, &of_copy(asked))?;
    }
    warn_of_shared(&run);
    let (mut jobs, mut finished) = (Vec::new(), 0);
    for job in wanted(run.jobs(), asked) {
        if asked.resume && run.is_done(&job)? {
            finished += 1;
        } else {
            jobs.push(job);
        }
    }
    announce(&task, &run, &jobs, finished)?;
    // Behind the forecast, which tells the memory that it adds to the most so far.
    warn_of_dead_time(&task, &run, &jobs)?;
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
                let done = done.and_then(|()| run.record());
                match done {
                    // Nobody has to hear it: what has begun goes on, and the report tells in the end.
                    Ok(record) => drop(say(&of_done(&name, &record))),
                    // Others may well reach their targets.
                    Err(error) if error.is_of_the_arm() => {
                        ended.0 += 1;
                        complain(&format!("{:?}\n", told(error)));
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

/// The jobs that are asked for.
fn wanted<'a>(jobs: Vec<Job<'a>>, asked: &RunArguments) -> Vec<Job<'a>> {
    let wanted = |job: &Job<'_>| asked.arm.is_empty() || asked.arm.contains(&job.arm.name);
    jobs.into_iter().filter(wanted).collect()
}

/// Refuses what would hold more than may be held.
fn check_memory(
    (task, asked): (&Task, &RunArguments),
    jobs: &[Job<'_>],
    budget: Budget,
) -> Result<()> {
    let what = format!("{}: training", asked.task.display());
    let help =
        "lower `batch`, `crop`, `widths` in [network], `clips` in [scenes] or [test], or --threads";
    let need = forecast::need(task, jobs).within(budget, &what, help);
    need.map_err(TrainError::from).map_err(Into::into)
}

/// What the copy of the task in a run's folder says of itself.
fn of_copy(asked: &RunArguments) -> Vec<String> {
    let file = asked.task.display();
    let mut told = vec![format!(
        "The task of this run, as in {file}: folders and videos are from that file on."
    )];
    if let Some(photos) = &asked.photos {
        told.push(format!("Its photographs: --photos {}", photos.display()));
    }
    told
}

/// Says where a photograph is trained with and held out.
fn warn_of_shared(run: &Run<'_>) {
    let [training, held_out] = [run.training(), run.held_out()].map(Clips::photographs);
    let (Some(training), Some(held_out)) = (training, held_out) else {
        return;
    };
    if let Some((own, other)) = held_out.shared(training) {
        complain(&format!(
            "Warning: the photographs {own}, which is held out, and {other}, which is trained with, are the same: memorising one improves the score on the other; remove one\n"
        ));
    }
}

/// Says where a dead time costs most events.
fn warn_of_dead_time(task: &Task, run: &Run<'_>, jobs: &[Job<'_>]) -> Result<()> {
    let Some(found) = DeadTime::new(task, jobs, run.training())? else {
        return Ok(());
    };
    let percent = |share: f64| fixed(100.0 * share, 0);
    let costs: Vec<_> = { found.costs.iter() }
        .map(|(target, share)| format!("{} % at {target} events a pixel and pair", percent(*share)))
        .collect();
    let help = match found.shorter {
        Some((us, share)) => format!(
            "train with sensor.refractory-us = {us}, which costs {} %",
            percent(share)
        ),
        None => "shorten sensor.refractory-us, or lower the targets".to_owned(),
    };
    complain(&format!(
        "Warning: the dead time of {} us costs most events of {} on the task's first clips, {}: no gradient then points where the loss falls (docs/learning.md); {help}\n",
        task.sensor.refractory_us,
        found.arm,
        costs.join(", ")
    ));
    Ok(())
}

/// What is said when an arm is done.
fn of_done(name: &str, record: &Record) -> String {
    let mut told = format!("{name}: done\n");
    for remark in record.remarks.iter().filter(|remark| remark.of == name) {
        told.extend(["  ", &remark.what, "\n"]);
    }
    told
}

/// Whether the arms that are asked for take part.
fn check_arms(task: &Task, asked: &RunArguments) -> Result<()> {
    for name in &asked.arm {
        if !task.arms.iter().any(|arm| arm.name == *name) {
            let own: Vec<_> = task.arms.iter().map(|arm| arm.name.as_str()).collect();
            let known = if arm::named(name).is_some() {
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
    Ok(())
}

/// What went wrong, with the place in the task file that it is about.
fn of_task(error: TrainError, task: &Task, asked: &RunArguments) -> miette::Report {
    let given = asked.photos.is_some() && matches!(error, TrainError::Scene(_));
    let keys = if given { &[][..] } else { error.keys() };
    match task.origin.told(keys) {
        Some(place) => miette::Report::from(error).wrap_err(place),
        None => error.into(),
    }
}
