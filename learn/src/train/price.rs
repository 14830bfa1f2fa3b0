//! Words and losses of the chip as a part of the loss: neighbours of a kernel of few values are
//! compiled, and judged on the same clips.
//!
//! A word is a step function of a kernel, without a gradient: so the kernel is exchanged for a
//! neighbour that is worth more, and training goes on from there.

use amacrine::{
    gradient::{Model, rate_threshold},
    kernel::Kernel,
};
use rayon::prelude::*;

use crate::{
    arm::Applied,
    levels::{OnChip, Projected, search},
    network::Adam,
    scene::Clips,
};

use super::{
    batch::{Batch, Loss},
    error::TrainError,
    trainee::{Reason, Trainee},
};

/// Searches in a run, evenly over the part in which the chip is in the loop.
pub(super) const SEARCHES: u64 = 3;

/// The most kernels that a search judges.
pub(super) const MOST: usize = 25;

/// Batches that kernels are judged on.
const JUDGED: u64 = 4;

impl Trainee<'_> {
    /// Whether a search is due after this many steps.
    pub(super) fn search_due(&self) -> bool {
        let (step, steps) = (self.state.step, self.task.steps);
        let due = |n: u64| step == steps * (SEARCHES + n) / (2 * SEARCHES);
        self.task.price != [0.0; 2] && (0..SEARCHES).any(due)
    }

    /// Exchanges the kernel for the best of its neighbours, thresholds with it, where one is worth
    /// more than it is itself; at most so many kernels are judged.
    ///
    /// # Errors
    /// When nothing is left of a kernel.
    pub(super) fn exchange(
        &mut self,
        applied: &Applied,
        clips: &Clips,
        most: usize,
    ) -> Result<(), TrainError> {
        let levels = self.few().map(|few| &few.levels);
        let ([kernel], [latent], Some(levels), Some(chip)) =
            (applied.few(), applied.latent(), levels, self.chip.clone())
        else {
            return Ok(());
        };
        let batch = Batch::new(clips, 0..JUDGED * self.task.batch as u64);
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 0));
        let [word, lost] = self.task.price;
        let white = self.white();
        let threshold = self.state.threshold * white;
        // Each at the threshold that it is trained on with: its program hangs on that.
        let score = |kernel: &Projected, _: &OnChip| {
            let Some((own, loss)) = self.worth(kernel, (&batch, &light)) else {
                return f64::INFINITY;
            };
            let made = chip.compile(std::slice::from_ref(kernel), own * white);
            made.map_or(f64::INFINITY, |made| {
                loss + word * made.words as f64 + lost * (1.0 - made.correlation)
            })
        };
        // What the chip refuses is trained on as it is.
        let Ok(found) = search(levels, (kernel, latent), (&chip, threshold), most, score) else {
            return Ok(());
        };
        if found.kernel.levels == kernel.levels {
            return Ok(());
        }
        let Some((threshold, _)) = self.worth(&found.kernel, (&batch, &light)) else {
            return Ok(());
        };
        self.state.threshold = threshold;
        let parameters: Vec<f64> = found.kernel.unit().iter().copied().collect();
        let adam = Adam::new(parameters.len());
        self.state.kernel = (parameters, adam);
        if let Some(applied) = self.applied()? {
            self.compile(&applied);
        }
        Ok(())
    }

    /// The threshold that meets the target with a kernel, and the loss there; `None` where none
    /// does.
    fn worth(&self, kernel: &Projected, (batch, light): (&Batch, &[f32])) -> Option<(f64, f64)> {
        let kernels = [Kernel::new(kernel.unit()).ok()?];
        let seed = self.draw(Reason::Mismatch, u64::MAX).bits();
        let clips = self.light(light, batch).ok()?;
        let sensor = self.sensor(&kernels, self.state.threshold);
        let rated = rate_threshold(&sensor, clips, seed, self.target).ok()?;
        let threshold = self.state.threshold * rated.scale;
        let sensor = self.sensor(&kernels, threshold);
        let model = Model::<f32>::new(sensor, batch.size(), seed).ok()?;
        let seen = model.forward(self.light(light, batch).ok()?).ok()?;
        let shape = self.network.shape();
        let weights = &self.state.network.0;
        let packed = self.network.packed(weights);
        let answers: Vec<_> = batch
            .groups(shape)
            .into_par_iter()
            .map(|clips| {
                let input = batch.input((self.task, shape), clips, Some(&seen));
                self.network.forward(weights, &packed, input).0
            })
            .collect();
        let loss = Loss::new(self.task, shape, batch, &answers).mean;
        loss.is_finite().then_some((threshold, loss))
    }
}
