//! The reply to a question about one kernel, or about several that share a chip.

use serde::{Serialize, Serializer};

use super::{
    Feasibility, FeasibilityError, Question, Several, Snapshot, ask::ask_one, question::alone,
    several::ask_several,
};
use crate::{
    rig::guard::Warning,
    scene::{Frame, Reopen},
};

/// The reply to a question about one kernel, or about several that share a chip. As JSON it is the
/// numbers without the pictures.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// One kernel in a program of its own: the numbers, and the pictures.
    One(Box<Feasibility>, Snapshot),
    /// Each kernel on its own, and all in one program: the numbers, and the pictures of each.
    Several(Several, Vec<Snapshot>),
}

impl Serialize for Reply {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::One(one, _) => one.serialize(to),
            Self::Several(several, _) => several.serialize(to),
        }
    }
}

/// Asks about each kernel, and where there are several, or the memory asked for is none of a kernel
/// on its own, about all together; they have one chip, scene and window. The scene is opened again
/// and again; `seen` is called after each frame that is watched.
///
/// # Errors
/// When there is no kernel, a threshold is not positive, a kernel is all 0 or not to be had in the
/// values that were asked for, or the scene cannot be read.
pub fn ask(
    questions: &[Question<'_>],
    open: &Reopen<'_>,
    seen: impl FnMut(&Frame),
) -> Result<Reply, FeasibilityError> {
    if let Some(question) = alone(questions) {
        let (numbers, snapshot) = ask_one(question, open, seen)?;
        return Ok(Reply::One(Box::new(numbers), snapshot));
    }
    let (several, snapshots) = ask_several(questions, open, seen)?;
    Ok(Reply::Several(several, snapshots))
}

impl Reply {
    /// Of each kernel on its own.
    #[must_use]
    pub fn kernels(&self) -> &[Feasibility] {
        match self {
            Self::One(one, _) => std::slice::from_ref(one),
            Self::Several(several, _) => &several.kernels,
        }
    }

    /// Puts the warnings of the scene before those of each kernel, and takes what was seen of the
    /// light in place of what the scene says beforehand.
    pub fn saw(&mut self, of_scene: &[Warning], light: Option<&str>) {
        let kernels = match self {
            Self::One(one, _) => std::slice::from_mut(&mut **one),
            Self::Several(several, _) => &mut several.kernels,
        };
        for kernel in kernels {
            kernel.saw(of_scene, light);
        }
    }
}
