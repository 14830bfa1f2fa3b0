//! One process at a time trains in a folder.

use std::{
    fs::{File, TryLockError},
    io::ErrorKind,
    path::Path,
};

use amacrine::save::make_folder;

use super::error::TrainError;

/// The file that is locked; it stays, since another process may wait for it.
pub(super) const LOCK: &str = "lock";

/// Makes the folder and locks it, as long as what is given lives and the process does.
///
/// # Errors
/// When another process trains in it, or it cannot be made.
pub(super) fn take(folder: &Path) -> Result<File, TrainError> {
    make_folder(folder)?;
    let path = folder.join(LOCK);
    let unreadable = |cause| TrainError::Unreadable {
        path: path.clone(),
        cause,
    };
    let mut options = File::options();
    let file = options.write(true).create(true).truncate(false).open(&path);
    let file = file.map_err(unreadable)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(TrainError::Busy {
            path: folder.to_owned(),
        }),
        // Not every file system has locks: there it is up to the user.
        Err(TryLockError::Error(cause)) if cause.kind() == ErrorKind::Unsupported => Ok(file),
        Err(TryLockError::Error(cause)) => Err(unreadable(cause)),
    }
}
