//! Sensor files by path, and those that come with the library by name.

use std::{io, path::Path};

use crate::{
    bundled::{self, Kind},
    config::Faults,
    source::{self, SourceError},
};

use super::Description;

/// A sensor file cannot be read, or is not what it should be.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum OpenError {
    /// It cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Source(#[from] SourceError),
    /// It says something wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Faults(#[from] Faults),
}

impl Description {
    /// Reads a sensor file, with the kernel files beside it that it names; where there is no such
    /// file, the sensor of this name that comes with the library: `rgc-4`, `dvs`, `authors/dvs`.
    ///
    /// # Errors
    /// When a file cannot be read; what is wrong in it, each with its line and column.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        Self::open_with(path.as_ref(), &|path| Ok(source::bytes(path, "")?))
    }

    /// The same, where `read` reads the kernel files.
    ///
    /// # Errors
    /// As [`open`](Self::open) does; what `read` says of a kernel file is told with its line.
    pub fn open_with(
        path: &Path,
        read: &dyn Fn(&Path) -> io::Result<Vec<u8>>,
    ) -> Result<Self, OpenError> {
        // A folder is no sensor.
        let name = path.to_str().filter(|_| !path.exists() || path.is_dir());
        if let Some(file) = name.and_then(|name| bundled::find(Kind::Sensor, name)) {
            // None of them names another file.
            let read = |_: &str| Err(io::ErrorKind::NotFound.into());
            return Ok(Self::parse(&file.path(), file.text, &read)?);
        }
        let help = if path.extension().is_some_and(|ending| ending == "npy") {
            "give a sensor file, such as rgc; an array of kernels goes after --kernel, beside it"
        } else {
            "give a sensor file, or a name that `amacrine list sensors` prints"
        };
        let help = name.map_or_else(
            || help.to_owned(),
            |name| bundled::meant(Kind::Sensor, name, help),
        );
        let text = source::text(path, &help)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let read = |name: &str| read(&folder.join(name));
        Ok(Self::parse(&path.display().to_string(), &text, &read)?)
    }
}
