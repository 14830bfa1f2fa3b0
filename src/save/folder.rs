//! Folders that are made for what is written, and synced.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

use super::SaveError;

/// Makes a folder and those that it is in, where they are missing.
///
/// # Errors
/// When the system does not allow it.
pub fn make_folder(path: &Path) -> Result<(), SaveError> {
    make(path).map(|_| ()).map_err(SaveError::at(path))
}

/// As [`make_folder`]; when it returns, the names of the new folders are on the disk.
///
/// # Errors
/// As [`make_folder`].
pub fn make_folder_durably(path: &Path) -> Result<(), SaveError> {
    make(path)
        .and_then(|made| sync_names(&made))
        .map_err(SaveError::at(path))
}

/// Makes what is missing of a folder; which those are, the outermost first.
pub(super) fn make(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut missing = Vec::new();
    let mut at = folder;
    loop {
        if at.as_os_str().is_empty() {
            break;
        }
        match fs::metadata(at) {
            Ok(found) if found.is_dir() => break,
            Ok(_) => return Err(io::ErrorKind::NotADirectory.into()),
            Err(e) if e.kind() == io::ErrorKind::NotFound => missing.push(at),
            Err(e) => return Err(e),
        }
        match at.parent() {
            Some(parent) => at = parent,
            None => break,
        }
    }
    let mut made = Vec::new();
    for folder in missing.into_iter().rev() {
        match fs::create_dir(folder) {
            Ok(()) => made.push(folder.to_owned()),
            Err(_) if folder.is_dir() => {}
            Err(e) => {
                unmake(&made);
                return Err(e);
            }
        }
    }
    Ok(made)
}

/// Removes folders again, as far as they are empty.
pub(super) fn unmake(made: &[PathBuf]) {
    for folder in made.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
}

/// Waits until the disk has the names of these.
pub(super) fn sync_names(made: &[PathBuf]) -> io::Result<()> {
    made.iter().try_for_each(|path| sync_name(path))
}

/// Waits until the disk has the name of this file or folder.
#[cfg(unix)]
pub(super) fn sync_name(path: &Path) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    sync(&File::open(folder)?)
}

/// Waits until the disk has what this file or folder holds, as far as its file system can: some
/// sync no folders, and shares of a network that a Mac sees take no `F_FULLFSYNC`, which the
/// standard library asks for there.
///
/// # Errors
/// When the disk does not take it.
#[cfg(unix)]
pub fn sync(file: &File) -> io::Result<()> {
    use rustix::io::Errno;
    let cannot = [
        Errno::INVAL,
        Errno::NOSYS,
        Errno::NOTSUP,
        Errno::NOTTY,
        Errno::OPNOTSUPP,
    ];
    let is_refused = |e: &io::Error| Errno::from_io_error(e).is_some_and(|e| cannot.contains(&e));
    match file.sync_all() {
        Err(e) if is_refused(&e) => match rustix::fs::fsync(file) {
            Err(e) if !cannot.contains(&e) => Err(e.into()),
            _ => Ok(()),
        },
        synced => synced,
    }
}

/// Waits until the disk has what this file holds.
///
/// # Errors
/// When the disk does not take it.
#[cfg(not(unix))]
pub fn sync(file: &File) -> io::Result<()> {
    file.sync_all()
}

#[cfg(not(unix))]
pub(super) fn sync_name(path: &Path) -> io::Result<()> {
    let _ = path;
    Ok(())
}
