//! The network trained on with the events of another form of its sensor.

use rayon::prelude::*;

use crate::network::Adam;

use super::{
    batch::{Batch, Loss},
    error::TrainError,
    evaluate::Told,
    trainee::Trainee,
};

/// Of the task's rate, that of the first step.
const RATE: f64 = 0.3;

impl Trainee<'_> {
    /// The same with a network that has gone so many steps further on these clips, as they are told.
    /// The sensor stays.
    ///
    /// # Errors
    /// When something is not finite.
    pub(super) fn retrained(
        &self,
        steps: u64,
        clips: &Batch,
        told: &Told,
    ) -> Result<Self, TrainError> {
        let mut other = self.clone();
        let shape = self.network.shape();
        let each = self.task.batch.min(clips.clips.len());
        let mut adam = Adam::new(self.network.parameters());
        for step in 0..steps {
            let first = step as usize * each;
            let of: Vec<usize> = (first..first + each)
                .map(|n| n % clips.clips.len())
                .collect();
            let batch = clips.some(&of);
            let weights = &other.state.network.0;
            let packed = self.network.packed(weights);
            let voxels = |n: usize| Some(&told.voxels[of[n]][..]);
            let (answers, kept): (Vec<_>, Vec<_>) = batch
                .groups(shape)
                .into_par_iter()
                .map(|clips| {
                    let given = (self.task, shape);
                    let input = batch.given(given, clips, self.arm.kinds(), voxels);
                    self.network.forward(weights, &packed, input)
                })
                .unzip();
            let loss = Loss::new(self.task, shape, &batch, &answers);
            self.finite("the loss of a network that is retrained", loss.mean)?;
            let back: Vec<_> = { kept.par_iter().zip(loss.asked) }
                .map(|(seen, asked)| {
                    let mut gradient = vec![0.0; weights.len()];
                    self.network
                        .backward(&packed, seen, asked, (&mut gradient, false));
                    gradient
                })
                .collect();
            let mut gradient = vec![0.0f32; weights.len()];
            for own in back {
                for (sum, own) in gradient.iter_mut().zip(own) {
                    *sum += own;
                }
            }
            let left = 1.0 - step as f64 / steps as f64;
            let rate = self.task.rates.0 * RATE * left;
            adam.step(&mut other.state.network.0, &gradient, rate);
        }
        Ok(other)
    }
}
