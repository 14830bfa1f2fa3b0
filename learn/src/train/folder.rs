//! The folder of a run: nothing else is in it.

use std::{io::ErrorKind, path::Path};

use super::{error::TrainError, lock::LOCK, run::ARMS};
use crate::record::KEPT_TASK;

/// What a run writes.
const OWN: [&str; 5] = [ARMS, KEPT_TASK, LOCK, "learn.json", "report.html"];

/// Refuses a folder in which there is something that no run writes.
///
/// # Errors
/// When there is such a thing, or it cannot be looked for.
pub(super) fn check(folder: &Path) -> Result<(), TrainError> {
    let unreadable = |cause| TrainError::Unreadable {
        path: folder.to_owned(),
        cause,
    };
    let entries = match std::fs::read_dir(folder) {
        Err(cause) if cause.kind() == ErrorKind::NotFound => return Ok(()),
        entries => entries.map_err(unreadable)?,
    };
    for entry in entries {
        let name = entry.map_err(unreadable)?.file_name();
        let name = name.to_string_lossy();
        if !OWN.contains(&&*name) && !name.starts_with('.') {
            return Err(TrainError::Foreign {
                path: folder.to_owned(),
                name: name.into_owned(),
            });
        }
    }
    Ok(())
}
