//! One arm at one target from one seed: its network, its kernels, its thresholds.

use std::{ops::Range, sync::Arc};

use amacrine::{
    compile::Effort,
    gradient::{
        Ask, Clips as Light, ConstantRate, Gradient, GradientError, Model, Rule, Slope,
        rate_threshold,
    },
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
use rayon::prelude::*;

use crate::{
    arm::{Applied, Arm, Few, Shape},
    levels::{Chip, LevelsError, memory_spread},
    network::{Adam, Maps, Network},
    record::KernelAt,
    scene::Clips,
    task::Task,
};

use super::{
    batch::{Batch, Loss},
    error::{PINNED, TrainError},
};

/// What randomness is for.
#[derive(Clone, Copy)]
pub(super) enum Reason {
    Light = 1,
    Mismatch,
    Test,
}

/// How much of a running mean a step is.
const MEMORY: f64 = 0.02;

/// By how much the logarithm of a threshold follows a rate that is twice the target, in a step.
const FOLLOW: f64 = 0.02;

/// A step's rate counts as at most so many targets above the target: a bound that is seldom met, else
/// the mean would lie above the target.
const MOST: f64 = 5.0;

/// Of the first rate of learning, what is left at the end.
const LEFT: f64 = 0.01;

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
const FIRST: u64 = 4;

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
    spread: f64,
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
    fn held(&self) -> bool {
        self.few().is_some() && self.part() >= HELD
    }

    /// Of the steps, the part that is done.
    fn part(&self) -> f64 {
        self.state.step as f64 / self.task.steps as f64
    }

    /// After a step of this rate, how far weights go of the way to their levels.
    ///
    /// Where `give` is what a weight may stand off its level, a step of the loss and `rate / give` of
    /// that way back are as long.
    fn drawn(&self, rate: f64) -> f64 {
        let [first, last] = GIVE.map(amacrine::elementary::ln);
        let give = amacrine::elementary::exp(first + (last - first) * self.part() / HELD);
        if self.few().is_some_and(|few| few.drawn) {
            (rate / give).min(1.0)
        } else {
            0.0
        }
    }

    /// What is learned of the kernels, as it is now: the state's, which may come from a checkpoint.
    fn shape(&self) -> Option<Shape> {
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

    /// Whether memories snap, as the chip's do: once it is in the loop.
    fn snaps(&self) -> bool {
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

    /// The numbers of the clips of a step.
    fn numbers(&self) -> Range<u64> {
        let each = self.task.batch as u64;
        self.state.step * each..(self.state.step + 1) * each
    }

    /// What is left of the rates of learning: half a cosine.
    fn left(&self) -> f64 {
        let cosine = amacrine::elementary::cos(std::f64::consts::PI * self.part().min(1.0));
        LEFT + (1.0 - LEFT) * 0.5 * (1.0 + cosine)
    }

    /// One step.
    ///
    /// # Errors
    /// When something is not finite, no weight is left of a kernel, or the target is out of reach.
    pub fn step(&mut self, clips: &Clips) -> Result<(), TrainError> {
        let batch = Batch::new(clips, self.numbers());
        let applied = self.applied()?;
        let step = self.state.step;
        let [by_chip, whole] = self.state.chip;
        let own = self.task.sensor.light_noise;
        let noise = (own * own + by_chip * by_chip).sqrt();
        let light = batch.light(noise, self.draw(Reason::Light, step));
        let mismatch = self.draw(Reason::Mismatch, step).bits();
        let mut model = None;
        if let Some(applied) = &applied {
            let threshold = if whole > 0.0 {
                // Straight through: what follows the target is the threshold before.
                (self.state.threshold / whole).round().max(1.0) * whole
            } else {
                self.state.threshold
            };
            let mut sensor = self.sensor(&applied.kernels, threshold);
            for channel in &mut sensor.channels {
                for own in &mut channel.thresholds {
                    own.sigma = amacrine::elementary::hypot(own.sigma, self.spread * whole);
                }
            }
            let made = Model::<f32>::new(sensor, batch.size(), mismatch);
            let made = made.map_err(|cause| self.gradient_error(cause))?;
            let seen = made.forward(self.light(&light, &batch)?);
            model = Some((made, seen.map_err(|cause| self.gradient_error(cause))?));
        }
        let seen = model.as_ref().map(|(_, seen)| seen);
        let rate = seen.map_or(0.0, amacrine::gradient::Forward::rate);
        let shape = self.network.shape();
        let weights = &self.state.network.0;
        let packed = self.network.packed(weights);
        let (answers, kept): (Vec<_>, Vec<_>) = batch
            .groups(shape)
            .into_par_iter()
            .map(|clips| {
                let input = batch.input((self.task, shape), clips, seen);
                self.network.forward(weights, &packed, input)
            })
            .unzip();
        let loss = Loss::new(self.task, shape, &batch, &answers);
        if !loss.mean.is_finite() {
            let voxels = seen.map_or(&[][..], |seen| seen.voxels());
            return Err(self.not_finite(&light, voxels, loss.mean));
        }
        let learning = !self.held() && self.arm.cells().is_some_and(|cells| cells.learned);
        // Where events have a price, thresholds are learned: those of kernels that are given too, and
        // on when a kernel is held.
        let priced = self.task.sparsity.is_some() && self.arm.cells().is_some();
        let learned = learning || priced;
        let back: Vec<_> = { kept.par_iter().zip(loss.asked) }
            .map(|(seen, asked)| {
                let mut gradient = vec![0.0; weights.len()];
                let further = self
                    .network
                    .backward(&packed, seen, asked, (&mut gradient, learned));
                (gradient, further)
            })
            .collect();
        let mut gradient = vec![0.0f32; weights.len()];
        let mut inputs = Vec::with_capacity(back.len());
        for (own, input) in back {
            for (sum, own) in gradient.iter_mut().zip(own) {
                *sum += own;
            }
            inputs.extend(input);
        }
        if let Some(n) = gradient.iter().position(|g| !g.is_finite()) {
            let what = format!("the gradient of {}", self.network.place(n));
            self.finite(&what, f64::from(gradient[n]))?;
        }
        let moved = match (&model, &applied) {
            (Some((model, seen)), Some(applied)) if learned => {
                let voxels = self.voxels(&batch, &inputs);
                Some(self.pulled((model, seen), &voxels, applied)?)
            }
            _ => None,
        };
        let left = self.left();
        let (weights, adam) = &mut self.state.network;
        adam.step(weights, &gradient, self.task.rates.0 * left);
        if let Some((kernel, by_threshold)) = moved {
            let rate = self.task.rates.1 * left;
            if learning {
                let (parameters, adam) = &mut self.state.kernel;
                adam.step(parameters, &kernel, rate);
                self.settle(self.drawn(rate))?;
            }
            if priced {
                // The price of events moves the threshold as well.
                let way = by_threshold.signum() * self.task.rates.1 * left;
                self.state.threshold *= amacrine::elementary::exp(-way);
            }
        }
        self.follow(loss.mean, rate)?;
        self.state.step += 1;
        self.keep(applied.as_ref());
        self.turn(learning, clips)
    }

    /// What is due between two steps: to hold still, to look for what is worth more.
    fn turn(&mut self, learning: bool, clips: &Clips) -> Result<(), TrainError> {
        if learning && self.held() {
            // Their last step: they are levels from here on.
            self.settle(1.0)?;
            if let Some(applied) = self.applied()? {
                self.compile(&applied);
            }
        }
        if self.search_due()
            && let Some(applied) = self.applied()?
        {
            self.compile(&applied);
            self.exchange(&applied, clips, super::price::MOST)?;
        }
        Ok(())
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

    /// The first tensor on the way to the loss that is not finite.
    fn not_finite(&self, light: &[f32], voxels: &[f32], loss: f64) -> TrainError {
        let bad = |values: &[f32]| values.iter().position(|v| !v.is_finite());
        let weights = &self.state.network.0;
        let (what, value) = if let Some(n) = bad(light) {
            ("the light".to_owned(), f64::from(light[n]))
        } else if let Some(n) = bad(voxels) {
            ("the voxels".to_owned(), f64::from(voxels[n]))
        } else if let Some(n) = bad(weights) {
            (self.network.place(n), f64::from(weights[n]))
        } else {
            ("the loss".to_owned(), loss)
        };
        TrainError::NotFinite {
            arm: self.arm.name.clone(),
            step: self.state.step,
            what,
            value,
        }
    }

    /// What the loss asks of the voxels, clip after clip.
    fn voxels(&self, batch: &Batch, inputs: &[Maps<f32>]) -> Vec<f32> {
        let shape = self.network.shape();
        let first = self.task.pictures();
        let mut voxels = Vec::new();
        for (clips, maps) in batch.groups(shape).into_iter().zip(inputs) {
            for place in 0..clips.len() {
                for c in first..maps.channels() {
                    for y in 0..shape.size().height {
                        voxels.extend_from_slice(maps.row(shape, (place, c), y));
                    }
                }
            }
        }
        voxels
    }

    /// The gradient of what is learned of the kernels, along the surface of constant rate; and, where
    /// events have a price, that of the logarithm of the thresholds.
    fn pulled(
        &self,
        (model, seen): (&Model<f32>, &amacrine::gradient::Forward<f32>),
        voxels: &[f32],
        applied: &Applied,
    ) -> Result<(Vec<f64>, f64), TrainError> {
        let wrong = |cause| self.gradient_error(cause);
        let rule = if self.snaps() {
            Rule::Reset
        } else {
            Rule::Mean
        };
        let ask = Ask {
            voxels: Some(voxels),
            ..Ask::default()
        };
        let loss = model.backward(seen, &ask, rule).map_err(wrong)?;
        let slope = if self.task.sparsity.is_some() {
            Slope::Fired
        } else {
            Slope::All
        };
        let ask = Ask {
            events: 1.0,
            slope,
            ..Ask::default()
        };
        let events = model.backward(seen, &ask, rule).map_err(wrong)?;
        let planes = |gradient: &Gradient<f32>| -> Vec<Plane<f64>> {
            gradient
                .channels
                .iter()
                .flat_map(|c| c.kernels.iter().cloned())
                .collect()
        };
        let mut asked = planes(&loss);
        let mut by_threshold = 0.0;
        if let Some(price) = self.task.sparsity {
            for (asked, events) in asked.iter_mut().zip(planes(&events)) {
                *asked += &(events * price);
            }
            let sum = |gradient: &Gradient<f32>| -> f64 {
                let sides = gradient
                    .channels
                    .iter()
                    .flat_map(|c| c.on.iter().chain(&c.off));
                sides.sum()
            };
            by_threshold = sum(&loss) + price * sum(&events);
        } else if let Some(reduced) = ConstantRate::new(model.description(), &loss, &events) {
            asked = reduced.kernels.into_iter().flatten().collect();
        }
        let Some(shape) = self.shape() else {
            return Ok((Vec::new(), 0.0));
        };
        let pulled = shape.pull(applied, &asked);
        self.finite(
            "the kernel's gradient",
            pulled.iter().map(|g| g.abs()).sum(),
        )?;
        Ok((pulled, by_threshold))
    }

    /// Takes a step's loss and rate into the running means, and lets the threshold follow the target.
    fn follow(&mut self, loss: f64, rate: f64) -> Result<(), TrainError> {
        let state = &mut self.state;
        for (mean, new) in state.means.iter_mut().zip([loss, rate]) {
            let part = if state.step == 0 { 1.0 } else { MEMORY };
            *mean += part * (new - *mean);
        }
        if self.arm.cells().is_none() || self.task.sparsity.is_some() {
            return Ok(());
        }
        // The step's own rate: a running mean comes late, and the threshold would swing.
        let off = (rate / self.target - 1.0).clamp(-1.0, MOST);
        state.threshold *= amacrine::elementary::exp(FOLLOW * off);
        let rate = state.means[1];
        let far = !(0.5..=2.0).contains(&(rate / self.target));
        state.pinned = if far { state.pinned + 1 } else { 0 };
        if state.pinned >= PINNED {
            return Err(TrainError::Pinned {
                arm: self.arm.name.clone(),
                step: state.step,
                rate,
                target: self.target,
            });
        }
        Ok(())
    }

    /// Keeps the kernels from time to time.
    fn keep(&mut self, applied: Option<&Applied>) {
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
    /// What the chip refuses is trained on without it; the report then has no rows of the chip.
    pub(super) fn compile(&mut self, applied: &Applied) {
        let cells = self.arm.cells();
        let alone = cells.is_some_and(|cells| cells.kinds == 1 && !cells.pattern && !cells.log);
        if !alone || self.task.chip.is_none() || self.task.sensor.refractory_us > 0.0 {
            return;
        }
        let [kernel] = applied.few() else { return };
        let most = Effort::default().states;
        let states = (STATES_A_STEP * self.task.steps).clamp(FEWEST_STATES, most);
        let chip = self.chip.get_or_insert_with(|| {
            let effort = Effort { states };
            Arc::new(Chip::new(Device::scamp5(), effort, self.seed))
        });
        let threshold = self.state.threshold * 255.0;
        let made = kernel.kernel().and_then(|(_, power)| {
            let kernel = std::slice::from_ref(kernel);
            Ok((chip.compile(kernel, threshold)?, power))
        });
        if let Ok((made, power)) = made {
            let unit = kernel.norm() / power * 255.0;
            self.state.chip = [made.light_noise(0), 1.0 / (made.scale * unit)];
            self.state.words = Some(made.words as u64);
        }
    }

    /// The kernels and where they are, as they are recorded.
    #[must_use]
    pub fn kernel_at(&self, applied: &Applied) -> KernelAt {
        let rows = |kernel: &Kernel| kernel.weights().outer_iter().map(|r| r.to_vec()).collect();
        let thresholds = vec![self.state.threshold; applied.kernels.len()];
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
