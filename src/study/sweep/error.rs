//! Why a folder of results cannot be used.

use std::{io, path::PathBuf};

use super::SCHEMA;
use crate::save::SaveError;

/// Why a folder of results cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StoreError {
    /// Something cannot be written.
    #[error("cannot write {}: {cause}", path.display())]
    #[diagnostic(help(
        "the points that are finished are kept: make room or give the folder back its rights, and run the same command again"
    ))]
    Save {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// Something cannot be read.
    #[error("cannot read {}: {cause}", path.display())]
    #[diagnostic(help("give a folder that `amacrine sweep` has written"))]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// Another process works there.
    #[error("{} is in use by another amacrine", folder.display())]
    #[diagnostic(help(
        "wait for it, or give each shard an --output of its own and join them with `amacrine merge`"
    ))]
    Busy {
        /// Which folder.
        folder: PathBuf,
    },
    /// A folder that holds something else.
    #[error("{} is not a folder of results: it has no sweep.json", folder.display())]
    #[diagnostic(help("give an --output that does not exist yet, or one of an earlier sweep"))]
    Foreign {
        /// Which folder.
        folder: PathBuf,
    },
    /// Results of another version.
    #[error(
        "{} was made by amacrine {made} (results version {schema}); this is amacrine {}, results version {}",
        folder.display(), env!("CARGO_PKG_VERSION"), SCHEMA
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
    },
    /// Results of another study.
    #[error(
        "{} holds the study \"{held}\" ({held_points} points), not \"{asked}\" ({asked_points} points): their points differ",
        folder.display()
    )]
    #[diagnostic(help("give another --output; nothing was changed"))]
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
    },
    /// A file that was damaged.
    #[error("{} is damaged: {why}", path.display())]
    #[diagnostic(help("delete it to have it made again; all other points are kept"))]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
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
