//! A file that nobody else sees, for work that needs a path.

use std::{fs::File, io, path::Path};

use super::temporary::Temporary;

/// An empty file in the system's folder for temporaries, which goes with this.
#[derive(Debug)]
pub struct Spool {
    temporary: Option<Temporary>,
    file: File,
}

impl Spool {
    /// A new one.
    ///
    /// # Errors
    /// When the system does not allow it.
    pub fn new() -> io::Result<Self> {
        let (temporary, file) = Temporary::elsewhere()?;
        Ok(Self {
            temporary: Some(temporary),
            file,
        })
    }

    /// Its name, as long as it has one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.temporary.as_ref().map(Temporary::path)
    }

    /// Takes its name away, where the system allows that: then nothing is left of it however the
    /// process ends. Whoever has it open goes on with it.
    pub fn hide(&mut self) {
        if cfg!(unix) {
            self.temporary = None;
        }
    }

    /// What is in it.
    pub const fn file(&mut self) -> &mut File {
        &mut self.file
    }
}
