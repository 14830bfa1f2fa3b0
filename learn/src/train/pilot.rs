//! An arm as it may be once it has learned, for those who say beforehand how long it takes.

use amacrine::rng::Hash;

use crate::{arm::Start, scene::Clips};

use super::{
    error::TrainError,
    price::{MOST, SEARCHES},
    trainee::Trainee,
};

/// How far a weight is from where it began, at most, of the centre's.
const FAR: f64 = 0.5;

/// What the weights are drawn for.
const REASON: u64 = 0x6465_6e73;

impl Trainee<'_> {
    /// The same after its last step, with a kernel that has few zeros: its program is among the
    /// longest that the arm may come to.
    ///
    /// # Errors
    /// When few values leave nothing of the kernel.
    pub fn dense(&self) -> Result<Self, TrainError> {
        let mut other = self.clone();
        other.state.step = self.task.steps;
        let cells = self.arm.cells();
        if cells.is_some_and(|cells| cells.learned && matches!(cells.start, Start::Delta(_))) {
            let draw = Hash::new(self.seed).with(REASON);
            for (n, weight) in other.state.kernel.0.iter_mut().enumerate() {
                *weight += FAR * (2.0 * draw.with(n as u64).uniform() - 1.0);
            }
            other.settle(if self.few().is_some() { 1.0 } else { 0.0 })?;
        }
        if let Some(applied) = other.applied()? {
            other.compile(&applied);
        }
        Ok(other)
    }

    /// Judges one kernel as the searches of a price do; how many they judge in a run at most.
    ///
    /// # Errors
    /// When nothing is left of a kernel.
    pub fn try_search(&self, clips: &Clips) -> Result<u32, TrainError> {
        if self.task.price == [0.0; 2] || self.few().is_none() {
            return Ok(0);
        }
        let mut other = self.dense()?;
        let Some(applied) = other.applied()? else {
            return Ok(0);
        };
        other.exchange(&applied, clips, 1)?;
        let searched = other.chip.is_some();
        Ok(if searched {
            MOST as u32 * SEARCHES as u32
        } else {
            0
        })
    }
}
