//! What is to be done, how long it takes, and what it holds: by a pilot of each arm.

use std::{
    fmt::Write as _,
    time::{Duration, Instant},
};

use amacrine::{
    memory::{self, Need},
    unit::counted,
};
use miette::{IntoDiagnostic, Result};

use super::print::say;
use crate::{
    arm::Sight,
    task::Task,
    train::{Job, Run, TrainError, Trainee, need, no_program},
};

/// Steps that an arm's time is taken from.
const PILOT: u64 = 6;

/// Jobs at a time: one on each thread, since the parts of a step are few.
pub(super) fn together(jobs: &[Job<'_>]) -> usize {
    rayon::current_num_threads().min(jobs.len())
}

/// Says what is to be done, how long it takes, and what it holds.
///
/// An arm that cannot be trained is told of and passed over: the run says what is wrong with it.
pub(super) fn announce(task: &Task, run: &Run<'_>, jobs: &[Job<'_>], done: usize) -> Result<()> {
    let mut text = format!(
        "{}: {} of {}, {} of {}x{} in each",
        task.name,
        counted(jobs.len(), "arm"),
        counted(task.steps, "step"),
        counted(task.batch, "clip"),
        task.crop,
        task.crop
    );
    if done > 0 {
        let _ = write!(text, "; {done} more are done");
    }
    text.push('\n');
    say(&text)?;
    if jobs.is_empty() {
        return Ok(());
    }
    // As it will be done: on one thread, the jobs side by side.
    let together = together(jobs);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(if together > 1 {
        1
    } else {
        rayon::current_num_threads()
    });
    let pool = pool.build().into_diagnostic()?;
    let before = memory::peak();
    let (mut total, mut judge) = (Duration::ZERO, Duration::ZERO);
    // What has most levels is judged longest: its program is sought longest.
    let levels = |job: &&Job<'_>| {
        let cells = job.arm.cells();
        cells.map(|cells| cells.few.as_ref().map(|few| few.levels.count()))
    };
    let longest = jobs.iter().max_by_key(levels).map(|job| &job.arm.name);
    for arm in &task.arms {
        let own: Vec<_> = jobs.iter().filter(|job| job.arm.name == arm.name).collect();
        if own.is_empty() {
            continue;
        }
        let judged = longest == Some(&arm.name);
        match pool.install(|| Pilot::of_first((task, run), &own, judged))? {
            Ok(pilot) => {
                judge = judge.max(pilot.judge);
                total += pilot.whole() * own.len() as u32;
                say(&pilot.line(&arm.name, own.len()))?;
            }
            Err(error) => say(&format!(
                "  {:<12} {} x not to be trained: {error}\n",
                arm.name,
                own.len()
            ))?,
        }
        if let Some(why) = no_program(task, arm) {
            say(&format!("  {:<12} {why}\n", ""))?;
        }
    }
    let told = jobs.iter().filter(|job| job.arm.cells().is_some()).count();
    total += judge * told as u32;
    let held = held(task, jobs, before);
    say(&format!(
        "  {told} x {:.0} s to judge on the chip at most\nabout {:.0} min in all, {together} at a time, {:.0} MB\n",
        judge.as_secs_f64(),
        total.as_secs_f64() / 60.0 / together as f64,
        held as f64 * 1e-6
    ))
}

/// Bytes that all jobs hold: what was worked out, or what the pilots have held where that is more. Each
/// of those side by side then holds as much as they did.
fn held(task: &Task, jobs: &[Job<'_>], before: Option<u64>) -> u128 {
    let (need, together) = (need(task, jobs).total(), together(jobs));
    let (Some(peak), Some(before)) = (memory::peak(), before) else {
        return need;
    };
    let own = peak.saturating_sub(before);
    need.max(u128::from(peak) + u128::from(own) * (together as u128 - 1))
}

/// What these jobs will hold.
pub(super) fn need(task: &Task, jobs: &[Job<'_>]) -> Need {
    let arms: Vec<_> = jobs.iter().map(|job| job.arm).collect();
    need::of_run(task, &arms, together(jobs))
}

/// What a few steps of a job tell.
struct Pilot {
    /// A step.
    step: Duration,
    /// Of all searches that a price asks for.
    searches: Duration,
    /// Judging it, where that was asked for.
    judge: Duration,
    steps: u64,
    weights: usize,
    bytes: usize,
}

impl Pilot {
    /// That of the first job which can be trained; else why the first cannot be.
    fn of_first(
        of: (&Task, &Run<'_>),
        jobs: &[&Job<'_>],
        judged: bool,
    ) -> Result<Result<Self, TrainError>, TrainError> {
        let mut first = None;
        for job in jobs {
            match Self::new(of, job, judged) {
                Ok(pilot) => return Ok(Ok(pilot)),
                Err(error) if error.is_of_the_arm() => {
                    first.get_or_insert(error);
                }
                Err(error) => return Err(error),
            }
        }
        match first {
            Some(error) => Ok(Err(error)),
            None => unreachable!("an arm without a job is not asked about"),
        }
    }

    fn new(
        (task, run): (&Task, &Run<'_>),
        job: &Job<'_>,
        judged: bool,
    ) -> Result<Self, TrainError> {
        let clips = run.training();
        let mut trainee = Trainee::new((task, job.arm), (job.target, job.seed), clips)?;
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
                trainee.step(clips)?;
            }
            step = step.min(start.elapsed() / PILOT.min(steps).max(1) as u32);
        }
        let start = Instant::now();
        let searched = trainee.try_search(clips)?;
        let searches = start.elapsed() * searched;
        let start = Instant::now();
        if judged
            && let Err(error) = trainee.dense().and_then(|dense| run.judge(&dense, None))
            && !error.is_of_the_arm()
        {
            return Err(error);
        }
        Ok(Self {
            step,
            searches,
            judge: start.elapsed(),
            steps,
            weights: match job.arm.sight {
                Sight::Blend => 0,
                _ => trainee.network().parameters(),
            },
            bytes: need::of_arm(task, job.arm),
        })
    }

    /// All steps, and what is searched between them.
    fn whole(&self) -> Duration {
        self.step.mul_f64(self.steps as f64) + self.searches
    }

    fn line(&self, arm: &str, jobs: usize) -> String {
        let mut line = format!(
            "  {arm:<12} {jobs} x {:.1} min, {:.0} ms a step, {} weights, {:.0} MB",
            self.whole().as_secs_f64() / 60.0,
            self.step.as_secs_f64() * 1e3,
            self.weights,
            self.bytes as f64 * 1e-6
        );
        if self.searches > Duration::ZERO {
            let seconds = self.searches.as_secs_f64();
            let _ = write!(line, ", {seconds:.0} s of it for [price] at most");
        }
        line.push('\n');
        line
    }
}
