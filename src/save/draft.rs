//! A file that is being written and has no name yet.

use std::{
    io::{self, BufWriter, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use super::{SaveError, give_ordinary_permissions, temporary_beside};

/// What becomes the file at its path when it is [kept](Self::keep), and nothing before.
///
/// For writers that live longer than one closure; [`super::save`] is the simpler door.
#[derive(Debug)]
pub struct Draft {
    path: PathBuf,
    file: BufWriter<NamedTempFile>,
}

impl Draft {
    /// An empty draft of the file that will be at `path`.
    ///
    /// # Errors
    /// When no file can be made in that folder.
    pub fn create(path: &Path) -> Result<Self, SaveError> {
        let file = temporary_beside(path).map_err(|cause| failed(path, cause))?;
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 16, file),
        })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// When the disk does not take it; whatever was at the path is then as it was.
    pub fn keep(self) -> Result<(), SaveError> {
        let Self { path, file } = self;
        let keep = || -> io::Result<()> {
            let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            give_ordinary_permissions(file.as_file())?;
            file.persist(&path).map_err(|e| e.error)?;
            Ok(())
        };
        keep().map_err(|cause| failed(&path, cause))
    }

    /// An error of the system, with the name of this file.
    #[must_use]
    pub fn failed(&self, cause: io::Error) -> SaveError {
        failed(&self.path, cause)
    }
}

fn failed(path: &Path, cause: io::Error) -> SaveError {
    SaveError {
        path: path.to_owned(),
        cause,
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Draft {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}
