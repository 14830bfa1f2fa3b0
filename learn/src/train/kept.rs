//! The copy of its task that a run's folder keeps, and what has changed since.

use amacrine::save;

use crate::{record::KEPT_TASK, task::Task};

use super::{
    checkpoint,
    error::TrainError,
    run::{ARMS, Job, Run},
};

impl Run<'_> {
    /// Leaves the task beside what is trained by it, as its file has it; `told` goes behind it as
    /// comments.
    ///
    /// # Errors
    /// When the folder's run is one of another task, or the file cannot be written.
    pub fn keep_task(&self, text: &str, told: &[String]) -> Result<(), TrainError> {
        let path = self.folder.join(KEPT_TASK);
        let begun = self.folder.join(ARMS).exists();
        if let (true, Some(changed)) = (begun, self.changed()) {
            return Err(TrainError::Checkpoint {
                path,
                what: checkpoint::another_task(&changed),
            });
        }
        save::save(&path, |out| {
            writeln!(out, "{}\n", text.trim_end())?;
            told.iter().try_for_each(|line| writeln!(out, "# {line}"))
        })?;
        Ok(())
    }

    /// The first key of the task that is not as in the folder's run, where it keeps its task.
    fn changed(&self) -> Option<String> {
        let was = std::fs::read_to_string(self.folder.join(KEPT_TASK)).ok()?;
        self.task.changed(&Task::parse(KEPT_TASK, &was).ok()?)
    }

    /// What tells a checkpoint from what it is to be.
    pub(super) fn other(&self, theirs: &str, job: &Job<'_>) -> String {
        checkpoint::other(theirs, &self.identity(job), self.changed().as_deref())
    }
}
