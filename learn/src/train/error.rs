//! Why training stops.

use std::{io::ErrorKind, path::PathBuf};

use amacrine::{
    gradient::GradientError, memory::TooMuch, save::SaveError, study::design::DesignError,
};

use crate::{levels::LevelsError, scene::SceneError};

/// Why training stops.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum TrainError {
    /// There is nothing to train on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A sensor that cannot be differentiated, or what it sees.
    #[error("arm {arm}, step {step}: {cause}")]
    Gradient {
        /// The arm.
        arm: String,
        /// The step.
        step: u64,
        /// Why.
        #[source]
        #[diagnostic_source]
        cause: GradientError,
    },
    /// Few values that leave nothing of a kernel.
    #[error("arm {arm}, step {step}: {cause}")]
    #[diagnostic(help("give the kernel more levels, or lower rates.kernel"))]
    Levels {
        /// The arm.
        arm: String,
        /// The step.
        step: u64,
        /// Why.
        cause: LevelsError,
    },
    /// NaN or infinity.
    #[error("arm {arm}, step {step}: {what} is {value}")]
    #[diagnostic(help("lower rates.network, or rates.kernel where it is the kernel"))]
    NotFinite {
        /// The arm.
        arm: String,
        /// The step.
        step: u64,
        /// Which tensor.
        what: String,
        /// What it is.
        value: f64,
    },
    /// A target that the arm does not reach.
    #[error(
        "arm {arm}, step {step}: {rate:.2e} events a pixel and pair for {PINNED} steps, and {target} are the target"
    )]
    #[diagnostic(help(
        "the scenes do not move enough for it, or too much: change the target, scenes.pan or sensor.refractory-us"
    ))]
    Pinned {
        /// The arm.
        arm: String,
        /// The step.
        step: u64,
        /// What it makes.
        rate: f64,
        /// What it should make.
        target: f64,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Save(#[from] SaveError),
    /// A file that cannot be read.
    #[error("{}: {cause}", path.display())]
    #[diagnostic(help("{}", unreadable(cause)))]
    Unreadable {
        /// Which.
        path: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
    /// A checkpoint of something else.
    #[error("{}: {what}", path.display())]
    #[diagnostic(help(
        "resume with the task, the photographs and the version that it was made with, or begin in another folder"
    ))]
    Checkpoint {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// What a finished arm has left, damaged.
    #[error("{}: not what a finished arm leaves: {cause}", path.display())]
    #[diagnostic(help(
        "remove {}: this arm then begins anew with --resume",
        path.parent().unwrap_or(path).display()
    ))]
    Finished {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        cause: serde_json::Error,
    },
    /// A run that would hold too much.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Memory(#[from] TooMuch),
    /// A folder with a run in it.
    #[error("{}: a run has begun there", path.display())]
    #[diagnostic(help("go on with it by --resume, or give another folder"))]
    Begun {
        /// The folder.
        path: PathBuf,
    },
    /// A folder in which there is something else.
    #[error("{}: there is `{name}`, which is of no run", path.display())]
    #[diagnostic(help("give a folder of the run's own"))]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// What is in it.
        name: String,
    },
    /// A folder in which another process trains.
    #[error("{}: another amacrine-learn trains in it", path.display())]
    #[diagnostic(help("wait until it has ended, or give another folder"))]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// A kernel that the chip does not take.
    #[error("arm {arm}: {cause}")]
    Design {
        /// The arm.
        arm: String,
        /// Why.
        #[source]
        #[diagnostic_source]
        cause: DesignError,
    },
}

/// What is to be done about a file that cannot be read.
fn unreadable(cause: &std::io::Error) -> &'static str {
    match cause.kind() {
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file is in the way: -o names a folder, which is made where there is none"
        }
        _ => "see that it may be read and written, or give another folder",
    }
}

/// Steps that an arm may be far from its target.
pub const PINNED: u64 = 200;

impl TrainError {
    /// The keys of a task that it is about, the nearest first; none where it is about none.
    #[must_use]
    pub const fn keys(&self) -> &'static [&'static str] {
        match self {
            Self::Scene(_) => &["photographs", "video", "crop"],
            Self::Gradient { .. } | Self::Pinned { .. } => &["targets"],
            Self::Levels { .. } | Self::Design { .. } => &["arms"],
            Self::NotFinite { .. } => &["rates", "arms"],
            Self::Save(_)
            | Self::Unreadable { .. }
            | Self::Checkpoint { .. }
            | Self::Finished { .. }
            | Self::Memory(_)
            | Self::Begun { .. }
            | Self::Foreign { .. }
            | Self::Busy { .. } => &[],
        }
    }

    /// Whether it is one arm's own: others may go on.
    #[must_use]
    pub const fn is_of_the_arm(&self) -> bool {
        matches!(
            self,
            Self::Gradient { .. }
                | Self::Levels { .. }
                | Self::NotFinite { .. }
                | Self::Pinned { .. }
        )
    }
}
