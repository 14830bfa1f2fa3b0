//! Files written whole or not at all.
//!
//! Everything is written to a temporary name in the same folder and renamed at the end, so
//! that an error, a full disk or a kill leaves no half-written file behind.

mod draft;
mod stack;

pub use draft::Draft;
pub use stack::{Element, Stack};

use std::{
    fs,
    io::{self, Write},
    path::{Path, PathBuf},
};

/// A file could not be written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot write {}: {cause}", path.display())]
#[diagnostic(help(
    "check that the folder exists, can be written to, and has room; nothing was left half-written"
))]
pub struct SaveError {
    /// Which file.
    pub path: PathBuf,
    /// What the system said.
    #[source]
    pub cause: io::Error,
}

/// Writes `path` through `fill`, whole or not at all.
///
/// # Errors
/// When the file cannot be created, filled or renamed; whatever was at `path` is then as it was.
pub fn save<F>(path: &Path, fill: F) -> Result<(), SaveError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let mut draft = Draft::create(path)?;
    fill(&mut draft).map_err(|cause| draft.failed(cause))?;
    draft.keep()
}

/// A file without a name yet, in the folder where it will get one.
fn temporary_beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    tempfile::NamedTempFile::new_in(folder)
}

/// Temporary files are private; what a user asked for is not.
#[cfg(unix)]
fn give_ordinary_permissions(file: &fs::File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn give_ordinary_permissions(_: &fs::File) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        save(&path, |w| w.write_all(b"old")).unwrap();
        let failed = save(&path, |w| {
            w.write_all(b"half of the new")?;
            Err(io::Error::other("no more"))
        });
        assert!(failed.unwrap_err().to_string().contains("a.txt"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
