//! Why a folder of results cannot be used.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::{
    damage::{Damage, damages, listed},
    difference::Disagreement,
    provenance::{NUMERICS, Provenance, SCHEMA},
};
use crate::{save::SaveError, scene::SceneError, unit::counted};

/// What to do about something that cannot be read.
fn reading(cause: &io::Error) -> &'static str {
    match cause.kind() {
        io::ErrorKind::PermissionDenied => "give yourself the right to read it",
        _ => "give a folder that `amacrine sweep` has written",
    }
}

/// In what two studies differ.
fn differ(changes: &[String]) -> String {
    if changes.is_empty() {
        return "their keys are the same, but the content of a scene, a kernel or a chip that they name has changed".to_owned();
    }
    format!("their keys differ:{}", listed(changes.iter().cloned()))
}

/// What to do about two studies that differ in this.
const fn back(changes: &[String]) -> &'static str {
    if changes.is_empty() {
        "put the files that the study names back as they were, or give another --output"
    } else {
        "give another --output, or change the study's keys back to those of the folder"
    }
}

/// What else a folder holds.
fn holds(found: Option<&Path>) -> String {
    found.map_or_else(String::new, |found| {
        format!(", and {} is none of a sweep's own files", found.display())
    })
}

/// What the folder's work gives.
pub(in crate::study::sweep) type Kept<T> = Result<T, StoreError>;

/// Why a folder of results cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StoreError {
    /// Something cannot be written.
    #[error("cannot write {}: {cause}", path.display())]
    #[diagnostic(help(
        "finished points are kept: free disk space or restore write permission, and run the same command again"
    ))]
    Save {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        cause: io::Error,
    },
    /// Something cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    #[diagnostic(help("{}", reading(cause)))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        cause: io::Error,
    },
    /// A scene that is looked at once more is not there any longer.
    #[error("cannot look at the scene {scene} again: {cause}")]
    #[diagnostic(help(
        "finished points are kept: restore the scene, and run the same command again"
    ))]
    Scene {
        /// As the study names it.
        scene: String,
        /// What is wrong with it.
        #[source]
        cause: Box<SceneError>,
    },
    /// It was stopped from outside.
    #[error("the sweep was stopped")]
    #[diagnostic(help("finished points are kept: run it again to continue"))]
    Stopped,
    /// Another process works there.
    #[error("{} is in use by another amacrine", folder.display())]
    #[diagnostic(help(
        "wait for it, or give each shard an --output of its own and join them with `amacrine merge`"
    ))]
    Busy {
        /// Which folder.
        folder: PathBuf,
    },
    /// No folder.
    #[error("there is no folder {}", folder.display())]
    #[diagnostic(help("give a folder that `amacrine sweep` or `amacrine merge` has written"))]
    Missing {
        /// Which folder.
        folder: PathBuf,
    },
    /// A folder that holds something else.
    #[error("{} is not a folder of results: it has no sweep.json{}", folder.display(), holds(found.as_deref()))]
    #[diagnostic(help(
        "give one that `amacrine sweep` or `amacrine merge` has written; as the --output of these two, one that does not exist yet"
    ))]
    Foreign {
        /// Which folder.
        folder: PathBuf,
        /// What is in it that no sweep writes, where that was looked for.
        found: Option<PathBuf>,
    },
    /// Something stands in the place of a file or a folder of the results.
    #[error("{} is {found}: results are not read or written through it", path.display())]
    #[diagnostic(help(
        "a folder of results holds files and folders of its own: move what is there away, or give another --output; nothing was changed"
    ))]
    Kind {
        /// The folder.
        path: PathBuf,
        /// What stands there.
        found: &'static str,
    },
    /// Results of a build whose numbers may differ.
    #[error(
        "{} was made by amacrine {made} (results version {schema}, numerics version {numerics}); this is amacrine {}, results version {}, numerics version {}",
        folder.display(), env!("CARGO_PKG_VERSION"), SCHEMA, NUMERICS
    )]
    #[diagnostic(help(
        "results of two versions do not belong in one table: give another --output, or go on with the version that made it; nothing was changed"
    ))]
    Version {
        /// Which folder.
        folder: PathBuf,
        /// Its version.
        made: String,
        /// The version of its results.
        schema: u64,
        /// The version of its numerics; 0: it does not say.
        numerics: u64,
    },
    /// Points of a build whose numbers may differ, in a folder of this one.
    #[error(
        "{points} points in {} are of another build, the first ({}) of amacrine {}, results version {}, numerics version {}; this is amacrine {}, results version {}, numerics version {}",
        folder.display(), first.display(), made.amacrine, made.schema, made.numerics,
        env!("CARGO_PKG_VERSION"), SCHEMA, NUMERICS
    )]
    #[diagnostic(help(
        "results of two versions do not belong in one table: move those files away to have the points computed again, or give another --output; nothing was changed"
    ))]
    OtherBuild {
        /// Which folder.
        folder: PathBuf,
        /// How many.
        points: usize,
        /// The first of their files.
        first: PathBuf,
        /// Who computed it.
        made: Box<Provenance>,
    },
    /// Results of another study.
    #[error(
        "{} holds the study \"{held}\" ({}), not \"{asked}\" ({}): {}",
        folder.display(),
        counted(*held_points, "point"),
        counted(*asked_points, "point"),
        differ(changes)
    )]
    #[diagnostic(help("{}; nothing was changed", back(changes)))]
    Study {
        /// Which folder.
        folder: PathBuf,
        /// Title of the study that it holds.
        held: String,
        /// Its points.
        held_points: usize,
        /// Title of the study that was asked for.
        asked: String,
        /// Its points.
        asked_points: usize,
        /// The keys that differ, with both values; none where what they name has changed.
        changes: Vec<String>,
    },
    /// A file that was damaged.
    #[error("{} is damaged: {why}", path.display())]
    #[diagnostic(help(
        "delete it and run `amacrine sweep` with its study again: the points are kept, and each is checked"
    ))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// Files of points that were damaged.
    #[error("{} of points {} damaged:{}", counted(damaged.len(), "file"), if damaged.len() == 1 { "is" } else { "are" }, damages(damaged))]
    #[diagnostic(help(
        "run `amacrine sweep` with the study and this folder as --output: it sets the damaged files aside and computes their points again; no result was written"
    ))]
    Points {
        /// All of them.
        damaged: Vec<Damage>,
    },
    /// Folders that say two things of one point.
    #[error(
        "the folders disagree on {}:{}",
        crate::unit::counted(*points, "point"),
        listed(disagreements.iter().map(ToString::to_string))
    )]
    #[diagnostic(help(
        "`amacrine sweep STUDY --output DIR --verify 100%` says which folder is wrong: delete the files of these points there and compute them again; no result was written"
    ))]
    Disagree {
        /// On how many points.
        points: usize,
        /// Each column of each point.
        disagreements: Vec<Disagreement>,
    },
    /// The joined results would go into one of the folders that they come from.
    #[error("{} is both joined and the --output", folder.display())]
    #[diagnostic(help("give an --output that is none of the folders; nothing was changed"))]
    Input {
        /// Which folder.
        folder: PathBuf,
    },
    /// Nothing to check.
    #[error("{} has no finished point to verify", folder.display())]
    #[diagnostic(help("run `amacrine sweep` without --verify first"))]
    Unfinished {
        /// Which folder.
        folder: PathBuf,
    },
    /// Nothing to join.
    #[error("there is no folder to merge")]
    #[diagnostic(help("give the folders of the shards: amacrine merge a b --output all"))]
    Nothing,
}

impl From<SaveError> for StoreError {
    fn from(error: SaveError) -> Self {
        Self::Save {
            path: error.path,
            cause: error.cause,
        }
    }
}
