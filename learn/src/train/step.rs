//! One step of an arm: what its kernels, thresholds and network learn of a batch.

use std::ops::Range;

use amacrine::{
    gradient::{Ask, ConstantRate, Forward, Gradient, Model, Rule, Slope},
    plane::Plane,
};
use rayon::prelude::*;

use super::{
    batch::{Batch, Loss},
    error::{PINNED, TrainError},
    trainee::{Reason, Trainee},
};
use crate::{arm::Applied, network::Maps, scene::Clips};

/// How much of a running mean a step is.
const MEMORY: f64 = 0.02;

/// By how much the logarithm of a threshold follows a rate that is twice the target, in a step.
const FOLLOW: f64 = 0.02;

/// A step's rate counts as at most so many targets above the target: a bound that is seldom met, else
/// the mean would lie above the target.
const MOST: f64 = 5.0;

/// Of the first rate of learning, what is left at the end.
const LEFT: f64 = 0.01;

impl Trainee<'_> {
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
        let rate = seen.map_or(0.0, Forward::rate);
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
        (model, seen): (&Model<f32>, &Forward<f32>),
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
}
