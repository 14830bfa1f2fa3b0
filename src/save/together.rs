//! Files that belong together: none has its name before all of them are written.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::{atomic_file::AtomicFile, error::SaveError, whole::filled};

/// Files that belong together could not all be written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{cause}{}", told(kept))]
#[diagnostic(forward(cause))]
pub struct TogetherError {
    /// Those that have their names all the same.
    pub kept: Vec<PathBuf>,
    /// Why the next could not be written.
    pub cause: SaveError,
}

impl From<SaveError> for TogetherError {
    fn from(cause: SaveError) -> Self {
        Self {
            kept: Vec::new(),
            cause,
        }
    }
}

fn told(kept: &[PathBuf]) -> String {
    if kept.is_empty() {
        return String::new();
    }
    let names: Vec<String> = kept.iter().map(|path| path.display().to_string()).collect();
    format!(
        "; of what belongs together there is {}, and no more",
        names.join(", ")
    )
}

/// Files of one result, each under a temporary name until all are [kept](Self::keep): what fails
/// or is killed before that leaves what was there.
#[derive(Debug, Default)]
pub struct Together {
    files: Vec<AtomicFile>,
}

impl Together {
    /// None yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Writes one more through `fill`. A device or a FIFO has it at once.
    ///
    /// # Errors
    /// When the file cannot be created or filled.
    pub fn add<F>(&mut self, path: &Path, fill: F) -> Result<(), SaveError>
    where
        F: FnOnce(&mut dyn Write) -> io::Result<()>,
    {
        let mut file = filled(path, fill)?;
        // Who reads one FIFO to its end may open the next only then.
        if file.is_written_through() {
            return file.keep();
        }
        // What is still in hand may be what the disk has no room for.
        file.flush().map_err(|cause| file.failed(cause))?;
        self.files.push(file);
        Ok(())
    }

    /// Gives all files their names, in the order in which they were added.
    ///
    /// # Errors
    /// When a name cannot be given: the files before it, which have theirs, are told.
    pub fn keep(self) -> Result<(), TogetherError> {
        let mut kept = Vec::new();
        for file in self.files {
            let path = file.path().to_owned();
            if let Err(cause) = file.keep() {
                return Err(TogetherError { kept, cause });
            }
            kept.push(path);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn none_is_there_before_all_are() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "old").unwrap();
        let mut files = Together::new();
        files.add(&at("a"), |out| out.write_all(b"new")).unwrap();
        files.add(&at("in/b"), |out| out.write_all(b"new")).unwrap();
        let failed = files.add(&at("c"), |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("no more"))
        });
        assert!(failed.unwrap_err().to_string().contains('c'));
        assert_eq!(fs::read(at("a")).unwrap(), b"old");
        drop(files);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        let mut files = Together::new();
        files.add(&at("a"), |out| out.write_all(b"new")).unwrap();
        files.add(&at("in/b"), |out| out.write_all(b"new")).unwrap();
        files.keep().unwrap();
        for name in ["a", "in/b"] {
            assert_eq!(fs::read(at(name)).unwrap(), b"new");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
        // A name that cannot be given: those before it are told.
        let mut files = Together::new();
        files.add(&at("a"), |out| out.write_all(b"newer")).unwrap();
        files.add(&at("c"), |out| out.write_all(b"newer")).unwrap();
        fs::create_dir(at("c")).unwrap();
        let said = files.keep().unwrap_err().to_string();
        let there = format!("there is {}, and no more", at("a").display());
        assert!(said.contains(&there), "{said}");
    }
}
