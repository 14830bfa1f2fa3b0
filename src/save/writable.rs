//! Whether something can be written at a place, and how much, before the work whose result it is.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use super::{SaveError, destination::Destination, temporary::Temporary};

/// Tries what writing a file begins with: a file in its folder, or in the nearest that is there,
/// which goes again. Nothing is tried with what is written through: a reader would hear of it.
///
/// # Errors
/// When the system does not allow it.
pub fn check_writable(path: &Path) -> Result<(), SaveError> {
    let tried = match Destination::from_path(path) {
        Ok(Destination::File { target, .. }) => try_beside(&target),
        Ok(Destination::Node { .. } | Destination::Descriptor(..)) => Ok(()),
        Err(cause) => Err(cause),
    };
    tried.map_err(SaveError::at(path))
}

/// The same of a folder that is to be filled, there or not.
///
/// # Errors
/// As [`check_writable`].
pub fn check_folder_writable(folder: &Path) -> Result<(), SaveError> {
    try_beside(&folder.join("file")).map_err(SaveError::at(folder))
}

/// Bytes that are free for a file at `path`, where the system says so.
#[must_use]
pub fn free_space(path: &Path) -> Option<u64> {
    space(&nearest_folder(path).ok()?)
}

fn try_beside(target: &Path) -> io::Result<()> {
    // No folder is made: another process may be about to fill it.
    let folder = nearest_folder(target)?;
    Temporary::beside(&folder.join("file")).map(|_| ())
}

/// The nearest folder above a file that is there.
fn nearest_folder(target: &Path) -> io::Result<PathBuf> {
    for folder in target.ancestors().skip(1) {
        let folder = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            folder
        };
        match fs::metadata(folder) {
            Ok(found) if found.is_dir() => return Ok(folder.to_owned()),
            Ok(_) => return Err(io::ErrorKind::NotADirectory.into()),
            Err(cause) if cause.kind() == io::ErrorKind::NotFound => {}
            Err(cause) => return Err(cause),
        }
    }
    Ok(PathBuf::from("."))
}

#[cfg(unix)]
fn space(folder: &Path) -> Option<u64> {
    let found = rustix::fs::statvfs(folder).ok()?;
    // A file system that counts no blocks does not say.
    (found.f_blocks > 0).then(|| found.f_bavail.saturating_mul(found.f_frsize))
}

#[cfg(not(unix))]
fn space(_: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_tried_and_left_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("old.txt"), "old").unwrap();
        check_writable(&at("new.txt")).unwrap();
        check_writable(&at("a/b/new.txt")).unwrap();
        check_writable(&at("old.txt")).unwrap();
        check_folder_writable(&at("c")).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!(fs::read(at("old.txt")).unwrap(), b"old");
        let inside = at("old.txt/x/new.txt");
        let error = check_writable(&inside).unwrap_err().to_string();
        assert!(error.contains("old.txt/x/new.txt"), "{error}");
        check_folder_writable(&at("old.txt")).unwrap_err();
        assert!(free_space(&at("a/b/new.txt")).is_some_and(|bytes| bytes > 0));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn no_file_is_made_in_proc_and_a_device_is_left_alone() {
        check_writable(Path::new("/proc/x/y.txt")).unwrap_err();
        check_folder_writable(Path::new("/proc/x")).unwrap_err();
        check_writable(Path::new("/dev/full")).unwrap();
        check_writable(Path::new(super::super::STDOUT)).unwrap();
    }
}
