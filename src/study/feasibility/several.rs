//! Several kernels on one chip: each on its own, and all of them in one program.

use super::{Feasibility, FeasibilityError, Question, Shared, Snapshot, ask::answered};
use crate::{
    scene::{Frame, Reopen},
    study::waterfall::check_crossings,
};

/// The answer for several kernels.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Several {
    /// The version that computed it.
    pub amacrine: &'static str,
    /// The command that computes it again.
    pub command: String,
    /// The seed in it.
    pub seed: u64,
    /// All kernels in one program.
    pub together: Shared,
    /// Each kernel on its own.
    pub kernels: Vec<Feasibility>,
}

/// Asks the question of each kernel, and then of all together; they have one chip, scene and
/// window. `seen` is called after each frame that is watched for them.
pub(super) fn ask_several(
    questions: &[Question<'_>],
    open: &Reopen<'_>,
    mut seen: impl FnMut(&Frame),
) -> Result<(Several, Vec<Snapshot>), FeasibilityError> {
    let Some(first) = questions.first() else {
        return Err(FeasibilityError::NoKernel);
    };
    let designs: Vec<_> = questions.iter().map(Question::design).collect();
    check_crossings(&designs, &mut *open()?)?;
    let (mut kernels, mut snapshots) = (Vec::new(), Vec::new());
    for question in questions {
        let (answer, snapshot) = answered(question, open, &mut seen)?;
        kernels.push(answer);
        snapshots.push(snapshot);
    }
    let together = Shared::new(first, questions, &kernels, &mut *open()?, &mut seen)?;
    let several = Several {
        amacrine: env!("CARGO_PKG_VERSION"),
        command: first.command.to_owned(),
        seed: first.seed,
        together,
        kernels,
    };
    Ok((several, snapshots))
}
