//! What a dead time costs. How many crossings share an event changes with the drive, and all rules of
//! the gradient take that number for fixed: where most events are lost so, none of them points where the
//! loss falls (`docs/learning.md`).

use crate::{scene::Clips, task::Task};

use super::{
    batch::Batch,
    error::TrainError,
    run::Job,
    trainee::{FIRST, Reason, Trainee},
};

/// The share of events that are lost from which on it is told.
const MOST: f64 = 0.5;

/// How often it is halved in search of one that costs less.
const HALVINGS: u32 = 6;

/// A dead time that costs most events.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadTime {
    /// The first arm that learns by a gradient.
    pub arm: String,
    /// The targets at which it does, from the lowest up, each with the share of events that are lost.
    pub costs: Vec<(f64, f64)>,
    /// A shorter one in microseconds, which does not at the dearest of these targets, and what it costs
    /// there.
    pub shorter: Option<(f64, f64)>,
}

impl DeadTime {
    /// What that of a task costs on its first clips, by the first of these jobs that learns by a
    /// gradient, as it begins; `None` where that is not most events.
    ///
    /// # Errors
    /// When something else than a target that no thresholds meet is wrong.
    pub fn new(task: &Task, jobs: &[Job<'_>], clips: &Clips) -> Result<Option<Self>, TrainError> {
        let us = task.sensor.refractory_us;
        let learns = |job: &&Job<'_>| {
            let cells = job.arm.cells();
            cells.is_some_and(|cells| cells.learned || task.sparsity.is_some())
        };
        let Some(first) = jobs.iter().find(learns).filter(|_| us > 0.0) else {
            return Ok(None);
        };
        let is_own = |job: &&Job<'_>| job.arm.name == first.arm.name && job.seed == first.seed;
        let mut own: Vec<_> = jobs.iter().filter(is_own).collect();
        own.sort_by(|a, b| a.target.total_cmp(&b.target));
        let mut costs = Vec::new();
        // Each by itself: a higher target may lose less, where it adds cells that fire once a pair.
        for job in own {
            if let Some(share) = lost(task, job, clips)?.filter(|share| *share > MOST) {
                costs.push((job.target, share));
            }
        }
        let dearest = costs.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((target, _)) = dearest.copied() else {
            return Ok(None);
        };
        let mut shorter = None;
        let mut other = task.clone();
        for _ in 0..HALVINGS {
            other.sensor.refractory_us /= 2.0;
            let share = lost(&other, &Job { target, ..*first }, clips)?;
            if let Some(share) = share.filter(|share| *share <= MOST) {
                shorter = Some((other.sensor.refractory_us, share));
                break;
            }
        }
        Ok(Some(Self {
            arm: first.arm.name.clone(),
            costs,
            shorter,
        }))
    }
}

/// The share of its events that the dead time takes from a job as it begins; `None` where no thresholds
/// meet its target, of which others tell.
fn lost(task: &Task, job: &Job<'_>, clips: &Clips) -> Result<Option<f64>, TrainError> {
    let trainee = Trainee::new((task, job.arm), (job.target, job.seed), clips);
    match trainee.and_then(|trainee| trainee.lost(clips)) {
        Err(error) if error.is_of_the_arm() => Ok(None),
        share => share,
    }
}

impl Trainee<'_> {
    /// The share of its events that the dead time takes, of the clips that its first thresholds are set
    /// by; `None` without events.
    fn lost(&self, clips: &Clips) -> Result<Option<f64>, TrainError> {
        let Some(applied) = self.applied()? else {
            return Ok(None);
        };
        let batch = Batch::new(clips, 0..FIRST * self.task.batch as u64);
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 0));
        let light = self.light(&light, &batch)?;
        let with = self.sensor(&applied.kernels, self.state.threshold);
        let mut without = with.clone();
        without.refractory.us = 0.0;
        let rate = |sensor| {
            let rated = self.as_it_is(sensor, light);
            rated
                .map(|rated| rated.rate)
                .map_err(|cause| self.gradient_error(cause))
        };
        let (with, all) = (rate(&with)?, rate(&without)?);
        Ok((all > 0.0).then(|| 1.0 - with / all))
    }
}
