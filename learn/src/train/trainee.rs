//! One arm at one target from one seed: its network, its kernels, its thresholds.

use std::sync::Arc;

use amacrine::{
    compile::Effort,
    gradient::{Clips as Light, GradientError, rate_threshold},
    isa::Device,
    kernel::Kernel,
    photoreceptor::{Curve, Response},
    plane::{Plane, Size},
    reference::{
        Border, Channel, Description, MemoryRule, Noise, PolarityRule, Refractory, RefractoryRule,
        Threshold,
    },
    rng::Hash,
};

use crate::{
    arm::{Applied, Arm, Few, Shape},
    levels::{Chip, LevelsError, memory_spread},
    network::{Adam, Network},
    record::KernelAt,
    scene::Clips,
    task::Task,
};

use super::{
    batch::Batch,
    error::TrainError,
    fit::{self, no_program},
};

/// What randomness is for.
#[derive(Clone, Copy)]
pub(super) enum Reason {
    Light = 1,
    Mismatch,
    Test,
}

/// Of a run, the part after which weights of few values hold still.
const HELD: f64 = 0.5;

/// How far a weight that the loss always moves the same way may stand off its level, of a kernel's
/// length: at the first step, and when weights begin to hold still.
const GIVE: [f64; 2] = [1.0, 0.01];

/// Snapshots of the kernels in a run.
const SNAPSHOTS: u64 = 20;

/// States that a search for a program on the way looks at, for each step of the run: about a
/// twentieth of its time in all. And the fewest.
const STATES_A_STEP: u64 = 20;
const FEWEST_STATES: u64 = 10_000;

/// Batches that the first thresholds are set by.
pub(super) const FIRST: u64 = 4;

/// All that changes from step to step.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Steps so far.
    pub step: u64,
    /// Weights of the network, and how they move.
    pub network: (Vec<f32>, Adam<f32>),
    /// What is learned of the kernels, and how it moves.
    pub kernel: (Vec<f64>, Adam<f64>),
    /// The threshold, in the signal's unit, of kernels of length 1.
    pub threshold: f64,
    /// Running means of the loss and of events a pixel and pair.
    pub means: [f64; 2],
    /// Steps in which the rate was far from its target, up to this one.
    pub pinned: u64,
    /// What the chip makes of the kernel, 0 until it is compiled: noise of the light that leaves as
    /// much in the drive as the program does, of 255; and the step of its thresholds, in the unit of
    /// [`State::threshold`].
    pub chip: [f64; 2],
    /// Words of its filter.
    pub words: Option<u64>,
    /// Kernels on the way.
    pub history: Vec<KernelAt>,
}

/// One arm at one target from one seed.
#[derive(Clone, Debug)]
pub struct Trainee<'a> {
    /// The task.
    pub task: &'a Task,
    /// The arm.
    pub arm: &'a Arm,
    /// Events a pixel and pair; 0 without events.
    pub target: f64,
    /// The seed.
    pub seed: u64,
    pub(super) network: Network<f32>,
    /// The kernels as they began: see [`Trainee::shape`].
    begun: Option<Shape>,
    times: Vec<f64>,
    /// What was compiled on the way.
    pub(super) chip: Option<Arc<Chip>>,
    /// What memories on the chip differ by, LSB: [`memory_spread`].
    pub(super) spread: f64,
    /// Where it is.
    pub state: State,
}

impl<'a> Trainee<'a> {
    /// An arm before its first step; thresholds are set to the target on the first clips.
    ///
    /// # Errors
    /// When no thresholds reach the target.
    pub fn new(
        (task, arm): (&'a Task, &'a Arm),
        (target, seed): (f64, u64),
        clips: &Clips,
    ) -> Result<Self, TrainError> {
        let mut trainee = Self::blank((task, arm), (target, seed));
        if arm.cells().is_some() {
            let batch = Batch::new(clips, 0..FIRST * task.batch as u64);
            trainee.state.threshold = trainee.threshold_for(&batch)?;
        }
        Ok(trainee)
    }

    /// The same without thresholds.
    #[must_use]
    pub fn blank((task, arm): (&'a Task, &'a Arm), (target, seed): (f64, u64)) -> Self {
        let network = Network::new(task.plan(arm), Size::new(task.crop, task.crop), task.batch);
        let weights = network.start(seed, task.fan());
        let shape = arm.cells().map(|cells| Shape::new(cells, seed));
        let learned = shape
            .as_ref()
            .filter(|_| arm.cells().is_some_and(|c| c.learned));
        let parameters = learned.map_or_else(Vec::new, |shape| shape.parameters.clone());
        Self {
            state: State {
                step: 0,
                kernel: (parameters.clone(), Adam::new(parameters.len())),
                network: (weights, Adam::new(network.parameters())),
                threshold: 0.1,
                means: [0.0; 2],
                pinned: 0,
                chip: [0.0; 2],
                words: None,
                history: Vec::new(),
            },
            task,
            arm,
            target,
            seed,
            network,
            begun: shape,
            chip: None,
            spread: memory_spread(&Device::scamp5()),
            times: task.scenes.times(),
        }
    }

    /// What it is called in files.
    #[must_use]
    pub fn name(&self) -> String {
        name(self.arm, self.target, self.seed)
    }

    /// The time of each frame, in seconds.
    pub(super) fn times(&self) -> &[f64] {
        &self.times
    }

    /// The network.
    #[must_use]
    pub const fn network(&self) -> &Network<f32> {
        &self.network
    }

    pub(super) fn gradient_error(&self, cause: GradientError) -> TrainError {
        TrainError::Gradient {
            arm: self.arm.name.clone(),
            step: self.state.step,
            cause,
        }
    }

    /// The few values that weights come to have.
    pub(super) fn few(&self) -> Option<&Few> {
        self.arm.cells().and_then(|cells| cells.few.as_ref())
    }

    /// Whether weights have few values at this step, and hold still.
    pub(super) fn held(&self) -> bool {
        self.few().is_some() && self.part() >= HELD
    }

    /// Of the steps, the part that is done.
    pub(super) fn part(&self) -> f64 {
        self.state.step as f64 / self.task.steps as f64
    }

    /// After a step of this rate, how far weights go of the way to their levels.
    ///
    /// Where `give` is what a weight may stand off its level, a step of the loss and `rate / give` of
    /// that way back are as long.
    pub(super) fn drawn(&self, rate: f64) -> f64 {
        let [first, last] = GIVE.map(amacrine::elementary::ln);
        let give = amacrine::elementary::exp(first + (last - first) * self.part() / HELD);
        if self.few().is_some_and(|few| few.drawn) {
            (rate / give).min(1.0)
        } else {
            0.0
        }
    }

    /// What is learned of the kernels, as it is now: the state's, which may come from a checkpoint.
    pub(super) fn shape(&self) -> Option<Shape> {
        let mut shape = self.begun.clone()?;
        if self.arm.cells().is_some_and(|cells| cells.learned) {
            shape.parameters.clone_from(&self.state.kernel.0);
        }
        Some(shape)
    }

    /// The kernels as they are applied now.
    ///
    /// # Errors
    /// When few values leave nothing of one.
    pub fn applied(&self) -> Result<Option<Applied>, TrainError> {
        let Some(shape) = self.shape() else {
            return Ok(None);
        };
        let applied = shape.apply(self.held());
        applied.map(Some).map_err(|cause| self.levels_error(cause))
    }

    fn levels_error(&self, cause: LevelsError) -> TrainError {
        TrainError::Levels {
            arm: self.arm.name.clone(),
            step: self.state.step,
            cause,
        }
    }

    /// The light that makes a signal of 1, where the chip has a program: 255 of others.
    pub(super) fn white(&self) -> f64 {
        fit::white(self.task.sensor.response).unwrap_or(255.0)
    }

    /// Whether memories snap, as the chip's do: once it is in the loop.
    pub(super) fn snaps(&self) -> bool {
        self.state.chip[1] > 0.0
    }

    /// The sensor with these kernels and this threshold.
    #[must_use]
    pub fn sensor(&self, kernels: &[Kernel], threshold: f64) -> Description {
        let cells = self.arm.cells();
        let each = if cells.is_some_and(|cells| cells.pattern) {
            4
        } else {
            1
        };
        let one = Threshold {
            on: threshold,
            off: threshold,
            sigma: threshold * self.task.sensor.mismatch,
        };
        let channel = |kernels: &[Kernel]| Channel {
            name: None,
            kernels: kernels.to_vec(),
            surrounds: None,
            thresholds: vec![one; kernels.len()],
            memory_kernel: None,
            log_temporal: false,
        };
        let response = if cells.is_some_and(|cells| cells.log) {
            Response::new(Curve::Log {
                white: 255.0,
                offset: LOG_OFFSET,
            })
        } else {
            self.task.sensor.response
        };
        Description {
            name: self.name(),
            response,
            memory: if self.snaps() {
                MemoryRule::FilteredSnap
            } else {
                MemoryRule::FilteredStep
            },
            shared: false,
            polarity: PolarityRule::Filtered,
            border: Border::Replicate,
            refractory: Refractory {
                us: self.task.sensor.refractory_us,
                rule: RefractoryRule::DeadTime,
            },
            noise: Noise::NONE,
            channels: kernels.chunks(each).map(channel).collect(),
        }
    }

    /// The sensor as it is built: a mesh of resistors in place of the kernel that stands for it.
    #[must_use]
    pub fn as_built(&self, sensor: &Description) -> Description {
        let mut sensor = sensor.clone();
        let shape = self.shape();
        let mesh = shape.as_ref().and_then(Shape::surrounds);
        if let (Some(mesh), Ok(alone)) = (mesh, Kernel::new(Plane::ones((1, 1)))) {
            for channel in &mut sensor.channels {
                channel.surrounds = Some(mesh.clone());
                channel.kernels = vec![alone.clone()];
            }
        }
        sensor
    }

    /// The threshold that meets the target on a batch.
    ///
    /// # Errors
    /// When there is none.
    pub fn threshold_for(&self, batch: &Batch) -> Result<f64, TrainError> {
        let Some(applied) = self.applied()? else {
            return Ok(self.state.threshold);
        };
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 0));
        let clips = self.light(&light, batch)?;
        let sensor = self.sensor(&applied.kernels, self.state.threshold);
        let seed = self.draw(Reason::Mismatch, u64::MAX).bits();
        let rated = rate_threshold(&sensor, clips, seed, self.target);
        let rated = rated.map_err(|cause| self.gradient_error(cause))?;
        Ok(self.state.threshold * rated.scale)
    }

    pub(super) fn draw(&self, reason: Reason, step: u64) -> Hash {
        Hash::new(self.seed).with(reason as u64).with(step)
    }

    pub(super) fn light<'b>(
        &'b self,
        light: &'b [f32],
        batch: &Batch,
    ) -> Result<Light<'b, f32>, TrainError> {
        let clips = Light::new(light, &self.times, batch.size());
        clips.map_err(|cause| self.gradient_error(cause))
    }

    /// Leaves kernels at length 1 after a step, and this part of the way nearer to their levels.
    pub(super) fn settle(&mut self, drawn: f64) -> Result<(), TrainError> {
        let Some(mut shape) = self.shape() else {
            return Ok(());
        };
        shape.settle();
        if drawn > 0.0 {
            shape
                .draw(drawn)
                .map_err(|cause| self.levels_error(cause))?;
        }
        self.state.kernel.0 = shape.parameters;
        Ok(())
    }

    pub(super) fn finite(&self, what: &str, value: f64) -> Result<(), TrainError> {
        if value.is_finite() {
            return Ok(());
        }
        Err(TrainError::NotFinite {
            arm: self.arm.name.clone(),
            step: self.state.step,
            what: what.to_owned(),
            value,
        })
    }

    /// Keeps the kernels from time to time.
    pub(super) fn keep(&mut self, applied: Option<&Applied>) {
        let each = (self.task.steps / SNAPSHOTS).max(1);
        let Some(applied) = applied else { return };
        if self.state.step != 1 && !self.state.step.is_multiple_of(each) {
            return;
        }
        self.compile(applied);
        let at = self.kernel_at(applied);
        self.state.history.push(at);
    }

    /// Takes the chip into the loop, where weights have few values and hold still.
    ///
    /// What the chip refuses is trained on without it; the report then has no rows of the chip, and says
    /// why.
    pub(super) fn compile(&mut self, applied: &Applied) {
        if self.task.chip.is_none() || no_program(self.task, self.arm).is_some() {
            return;
        }
        let [kernel] = applied.few() else { return };
        let white = self.white();
        let most = Effort::default().states;
        let states = (STATES_A_STEP * self.task.steps).clamp(FEWEST_STATES, most);
        let chip = self.chip.get_or_insert_with(|| {
            let effort = Effort::states(states);
            Arc::new(Chip::new(Device::scamp5(), effort, self.seed))
        });
        let threshold = self.state.threshold * white;
        let made = kernel.kernel().and_then(|(_, power)| {
            let kernel = std::slice::from_ref(kernel);
            Ok((chip.compile(kernel, threshold)?, power))
        });
        if let Ok((made, power)) = made {
            let unit = kernel.norm() / power * white;
            self.state.chip = [made.light_noise(0), 1.0 / (made.scale * unit)];
            self.state.words = Some(made.words as u64);
        }
    }

    /// The kernels and where they are, as they are recorded.
    #[must_use]
    pub fn kernel_at(&self, applied: &Applied) -> KernelAt {
        let rows = |kernel: &Kernel| kernel.weights().outer_iter().map(|r| r.to_vec()).collect();
        // With the chip in the loop it is one LSB at least.
        let threshold = self.state.threshold.max(self.state.chip[1]);
        let thresholds = vec![threshold; applied.kernels.len()];
        KernelAt {
            arm: self.arm.name.clone(),
            target: self.target,
            seed: self.seed,
            step: self.state.step,
            loss: self.state.means[0],
            rate: self.state.means[1],
            words: self.state.words,
            kernels: applied.kernels.iter().map(rows).collect(),
            on: thresholds.clone(),
            off: thresholds,
        }
    }
}

/// What keeps the logarithm of black finite: half a step of 8 bits.
const LOG_OFFSET: f64 = 0.5 / 255.0;

/// What an arm at a target from a seed is called in files.
#[must_use]
pub fn name(arm: &Arm, target: f64, seed: u64) -> String {
    // Colons are no part of a folder's name everywhere.
    let arm_name = arm.name.replace(':', "-");
    if arm.cells().is_some() {
        format!("{arm_name}-{target}-{seed}")
    } else {
        format!("{arm_name}-{seed}")
    }
}
