//! A run: all arms of a task at all targets from all seeds, in a folder.

use std::{
    fs::File,
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
};

use amacrine::{
    memory::Budget,
    plane::Size,
    save::{self, make_folder},
};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{
    arm::Arm,
    record::{self, KernelAt, Record, Remark, Row},
    scene::{Clips, hex},
    task::{Origin, Task},
};

use super::{
    checkpoint,
    error::TrainError,
    export, folder,
    judged::Judged,
    lock,
    on_chip::Sources,
    sources::clips,
    trainee::{State, Trainee},
};

/// One arm at one target from one seed.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The arm.
    pub arm: &'a Arm,
    /// Events a pixel and pair; 0 without events.
    pub target: f64,
    /// The seed.
    pub seed: u64,
}

/// All arms of a task at all targets from all seeds.
#[derive(Debug)]
pub struct Run<'a> {
    pub(super) task: &'a Task,
    /// What tasks and photographs are told apart by.
    identity: String,
    pub(super) folder: PathBuf,
    training: Clips,
    held_out: Clips,
}

/// What is trained of a task, in order.
#[must_use]
pub fn jobs(task: &Task) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    // All arms from one seed come before the next: a run that is stopped has all arms.
    for seed in &task.seeds {
        for arm in &task.arms {
            let targets = if arm.cells().is_some() {
                &task.targets[..]
            } else {
                &[0.0]
            };
            let job = |target: &f64| Job {
                arm,
                target: *target,
                seed: *seed,
            };
            jobs.extend(targets.iter().map(job));
        }
    }
    jobs
}

/// How far a job is.
#[derive(Debug)]
pub enum Progress<'a> {
    /// It begins.
    Begun,
    /// It has made a step.
    Step(&'a State),
    /// It has ended.
    Ended(Result<(), TrainError>),
}

/// What is left of a finished arm.
#[derive(Serialize, Deserialize)]
struct Finished {
    identity: String,
    rows: Vec<Row>,
    kernels: Vec<KernelAt>,
    #[serde(default)]
    remarks: Vec<String>,
}

/// Raised where the same task trains to other numbers: runs begun before are then refused.
const NUMERICS: u32 = 2;

impl<'a> Run<'a> {
    /// A run of a task in a folder, which is made.
    ///
    /// # Errors
    /// When there are no photographs, or the folder cannot be made, or holds something and `resume` is
    /// not said.
    pub fn new(task: &'a Task, folder: &Path, resume: bool) -> Result<Self, TrainError> {
        Self::within(task, (folder, resume), Budget::from_machine())
    }

    /// The same with a video that is held within what there may be.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn within(
        task: &'a Task,
        (folder, resume): (&Path, bool),
        memory: Budget,
    ) -> Result<Self, TrainError> {
        let (training, held_out, seen) = clips(task, memory)?;
        let begun =
            checkpoint::exists(&folder.join(ARMS)).map_err(|cause| TrainError::Unreadable {
                path: folder.to_owned(),
                cause,
            })?;
        if begun && !resume {
            return Err(TrainError::Begun {
                path: folder.to_owned(),
            });
        }
        if !begun {
            folder::check(folder)?;
        }
        // Without comments and names, and without the arms, targets and seeds, which may be added to
        // later: a job's own are in its name. What photographs and videos show is in `seen`.
        let mut rest = task.clone();
        rest.arms.clear();
        rest.targets.clear();
        rest.seeds.clear();
        rest.name.clear();
        rest.origin = Origin::default();
        rest.scenes.photographs = None;
        rest.scenes.video = None;
        // How often a checkpoint is written changes nothing; it stands here as it is when left out.
        rest.checkpoint = 500;
        let mut sum = Sha256::new();
        sum.update(env!("CARGO_PKG_VERSION"));
        sum.update(NUMERICS.to_le_bytes());
        sum.update(format!("{rest:?}"));
        sum.update(seen);
        let identity = hex(&sum.finalize()[..8]);
        Ok(Self {
            task,
            identity,
            folder: folder.to_owned(),
            training,
            held_out,
        })
    }

    /// What is trained, in order.
    #[must_use]
    pub fn jobs(&self) -> Vec<Job<'a>> {
        jobs(self.task)
    }

    /// The clips that are trained on.
    #[must_use]
    pub const fn training(&self) -> &Clips {
        &self.training
    }

    /// The clips that are held out.
    #[must_use]
    pub const fn held_out(&self) -> &Clips {
        &self.held_out
    }

    fn place(&self, job: &Job<'_>) -> PathBuf {
        let name = super::name(job.arm, job.target, job.seed);
        self.folder.join(ARMS).join(name)
    }

    pub(super) fn identity(&self, job: &Job<'_>) -> String {
        let name = super::name(job.arm, job.target, job.seed);
        format!("{}, {name}", self.identity)
    }

    /// Keeps other processes from training in the folder, as long as what is given lives and the
    /// process does.
    ///
    /// # Errors
    /// When another one does, or the folder cannot be made.
    pub fn lock(&self) -> Result<File, TrainError> {
        let lock = lock::take(&self.folder)?;
        // What a run that was killed has left half-written.
        let _ = save::sweep_up(&self.folder);
        Ok(lock)
    }

    /// Whether a job was trained and judged.
    ///
    /// # Errors
    /// When what it left is damaged, or of another task.
    pub fn is_done(&self, job: &Job<'_>) -> Result<bool, TrainError> {
        Ok(self.finished(job)?.is_some())
    }

    fn finished(&self, job: &Job<'_>) -> Result<Option<Finished>, TrainError> {
        let path = self.place(job).join(FINISHED);
        let text = match std::fs::read(&path) {
            Ok(text) => text,
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(cause) => return Err(TrainError::Unreadable { path, cause }),
        };
        let finished: Finished =
            serde_json::from_slice(&text).map_err(|cause| TrainError::Finished {
                path: path.clone(),
                cause,
            })?;
        if finished.identity == self.identity(job) {
            return Ok(Some(finished));
        }
        Err(TrainError::Checkpoint {
            path,
            what: self.other(&finished.identity, job),
        })
    }

    /// Trains and judges one arm, from its checkpoint where there is one; `seen` is called after each
    /// step. Nothing is done where it is finished.
    ///
    /// # Errors
    /// When training stops, or a file cannot be written.
    pub fn train(&self, job: &Job<'a>, seen: &mut dyn FnMut(&State)) -> Result<(), TrainError> {
        self.train_until(job, seen, &AtomicBool::new(false))
    }

    /// Trains and judges jobs, so many at a time, each on one thread where that is more than one;
    /// `seen` is called with a job's number. An arm that cannot be trained leaves others to go on; what
    /// else goes wrong stops all after their next step.
    pub fn train_all(
        &self,
        jobs: &[Job<'a>],
        together: usize,
        seen: &(dyn Fn(usize, Progress<'_>) + Sync),
    ) {
        let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
        let work = || {
            while !stop.load(Ordering::Relaxed) {
                let n = next.fetch_add(1, Ordering::Relaxed);
                let Some(job) = jobs.get(n) else { break };
                seen(n, Progress::Begun);
                let done =
                    self.train_until(job, &mut |state| seen(n, Progress::Step(state)), &stop);
                if done.as_ref().is_err_and(|error| !error.is_of_the_arm()) {
                    stop.store(true, Ordering::Relaxed);
                }
                match done {
                    Ok(()) if stop.load(Ordering::Relaxed) => {}
                    done => seen(n, Progress::Ended(done)),
                }
            }
        };
        let together = together.min(jobs.len());
        if together < 2 {
            return work();
        }
        std::thread::scope(|scope| {
            for _ in 0..together {
                scope.spawn(
                    || match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
                        Ok(pool) => pool.install(work),
                        // Without a thread of its own it shares those that there are.
                        Err(_) => work(),
                    },
                );
            }
        });
    }

    fn train_until(
        &self,
        job: &Job<'a>,
        seen: &mut dyn FnMut(&State),
        stop: &AtomicBool,
    ) -> Result<(), TrainError> {
        if self.finished(job)?.is_some() {
            return Ok(());
        }
        let place = self.place(job);
        make_folder(&place)?;
        // What a process that was killed has left half written.
        let _ = save::sweep_up(&place);
        let path = place.join(CHECKPOINT);
        let identity = self.identity(job);
        let (of, at) = ((self.task, job.arm), (job.target, job.seed));
        let unreadable = |cause| TrainError::Unreadable {
            path: path.clone(),
            cause,
        };
        let mut trainee = if checkpoint::exists(&path).map_err(unreadable)? {
            let mut trainee = Trainee::blank(of, at);
            let counts = [trainee.state.network.0.len(), trainee.state.kernel.0.len()];
            let other = |theirs: &str| self.other(theirs, job);
            trainee.state = State::open(&path, (&identity, &other), counts)?;
            trainee
        } else {
            Trainee::new(of, at, &self.training)?
        };
        let steps = if job.arm.sight == crate::arm::Sight::Blend {
            0
        } else {
            self.task.steps
        };
        while trainee.state.step < steps {
            trainee.step(&self.training)?;
            seen(&trainee.state);
            let step = trainee.state.step;
            if step == steps || step.is_multiple_of(self.task.checkpoint) {
                trainee.state.save(&path, &identity)?;
            }
            if stop.load(Ordering::Relaxed) {
                return Ok(());
            }
        }
        let Judged { rows, remarks } = self.judge(&trainee, Some((&place, &identity)))?;
        let finished = Finished {
            identity,
            rows,
            kernels: trainee.state.history.clone(),
            remarks,
        };
        let text = serde_json::to_vec(&finished).unwrap_or_default();
        save::save_durably(&place.join(FINISHED), |out| out.write_all(&text))?;
        Ok(())
    }

    /// What is measured of an arm as it is; kernels, sensor and program go into the folder that is given, with
    /// what they are of.
    ///
    /// # Errors
    /// When a sensor fails, or a file cannot be written.
    pub fn judge(
        &self,
        trainee: &Trainee<'a>,
        into: Option<(&Path, &str)>,
    ) -> Result<Judged, TrainError> {
        let rated = trainee.rated(&self.held_out)?;
        let sensor = rated.as_ref().map(|rated| &rated.description);
        let mut rows = trainee.judged(sensor, &self.held_out)?;
        let (Some(rated), Some(applied)) = (&rated, trainee.applied()?) else {
            return Ok(Judged {
                rows,
                remarks: Vec::new(),
            });
        };
        let (name, steps) = (&self.task.name, trainee.state.step);
        let into = into.map(|(place, identity)| {
            let source = format!("amacrine-learn, {name} {identity}, {steps} steps");
            (place, source)
        });
        if let Some((place, source)) = &into {
            let whole = applied.levels.iter().flatten().map(Some);
            let kernels = applied
                .kernels
                .iter()
                .zip(whole.chain(std::iter::repeat(None)));
            for (k, (kernel, levels)) in kernels.enumerate() {
                let weights = levels.unwrap_or_else(|| kernel.weights());
                export::kernel(&place.join(format!("kernel-{k}.npy")), weights)?;
            }
            let sensor = trainee.as_built(&rated.description);
            let told: Vec<String> = { export::light_noise(self.task.sensor.light_noise) }
                .into_iter()
                .collect();
            export::sensor(&place.join("sensor.toml"), &sensor, (source, &told))?;
        }
        let sources = Sources {
            held_out: &self.held_out,
            training: &self.training,
        };
        let into = { into.as_ref() }.map(|(place, source)| (*place, &**source));
        let chip = trainee.on_chip(&applied, rated, (sources, into))?;
        rows.extend(chip.rows);
        let mut remarks = chip.remarks;
        remarks.extend(trainee.far(&rows));
        Ok(Judged { rows, remarks })
    }

    /// What has been measured so far, written to `learn.json`.
    ///
    /// # Errors
    /// When a file cannot be read or written.
    pub fn record(&self) -> Result<Record, TrainError> {
        let mut rows = Vec::new();
        let (mut kernels, mut remarks) = (Vec::new(), Vec::new());
        for job in self.jobs() {
            if let Some(finished) = self.finished(&job)? {
                rows.extend(finished.rows);
                kernels.extend(finished.kernels);
                let told = finished.remarks.into_iter().map(|what| Remark {
                    of: super::name(job.arm, job.target, job.seed),
                    arm: job.arm.name.clone(),
                    seed: job.seed,
                    what,
                });
                remarks.extend(told);
            }
        }
        let one = self.task.arms.iter().find(|arm| arm.kinds() == 1);
        let one = one.or_else(|| self.task.arms.first());
        let size = Size::new(self.task.crop, self.task.crop);
        let network =
            one.map(|arm| crate::network::Network::<f32>::new(self.task.plan(arm), size, 1));
        let record = Record {
            version: record::VERSION,
            task: self.task.name.clone(),
            goal: self.task.goal.word().to_owned(),
            steps: self.task.steps,
            batch: self.task.batch,
            crop: self.task.crop,
            parameters: network.map_or(0, |network| network.parameters()),
            rows,
            kernels,
            remarks,
        };
        let text = serde_json::to_vec(&record).unwrap_or_default();
        save::save(&self.folder.join("learn.json"), |out| out.write_all(&text))?;
        Ok(record)
    }
}

pub(super) const ARMS: &str = "arms";
const CHECKPOINT: &str = "checkpoint";
const FINISHED: &str = "finished.json";
