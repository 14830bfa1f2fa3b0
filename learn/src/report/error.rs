//! Runs that cannot be told of.

use std::path::PathBuf;

use crate::record::VERSION;

/// A run that cannot be told of.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ReportError {
    /// No record.
    #[error("{}: {cause}", path.display())]
    #[diagnostic(help("give the folder of a run: the one after -o when it was trained"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
    /// Something else than a record.
    #[error("{}: no record of a run: {cause}", path.display())]
    #[diagnostic(help("run it again with --resume, which rewrites the file"))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: serde_json::Error,
    },
    /// A record of another version.
    #[error("{}: version {got} of the record; this program reads version {VERSION}", path.display())]
    #[diagnostic(help("use the program that made the run, or run it again"))]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        got: u32,
    },
    /// A record without a row.
    #[error("{}: nothing was measured yet", path.display())]
    #[diagnostic(help("go on with --resume until an arm is finished"))]
    Nothing {
        /// The file.
        path: PathBuf,
    },
}
