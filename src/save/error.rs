//! Why a file could not be written.

use std::{
    io,
    path::{Path, PathBuf},
};

/// A file could not be written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot write {}: {cause}", path.display())]
#[diagnostic(help(
    "{}what it held before is as it was",
    if cause.kind() == io::ErrorKind::InvalidData {
        ""
    } else {
        "check that its folder can be written to and has room; "
    }
))]
pub struct SaveError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// The error of the system, which is part of the message.
    #[source]
    pub cause: io::Error,
}

impl SaveError {
    /// Gives an error of the system the name of its file.
    pub(super) fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |cause| Self { path, cause }
    }
}
