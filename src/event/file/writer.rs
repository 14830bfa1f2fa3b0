//! An event file, written a block at a time.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use super::{
    Fault, FileError, Format,
    about::About,
    gate::Gate,
    head::{Compression, Head},
    source::{BLOCK, Sink},
};
use crate::{
    event::{Dropped, Event},
    save::{AtomicFile, SaveError},
    unit::Micros,
};

/// An event file being written, whole or not at all: memory does not grow with its length.
///
/// Nothing is at the path before [`Writer::finish`].
pub struct Writer {
    path: PathBuf,
    file: AtomicFile,
    sink: Box<dyn Sink>,
    gate: Gate,
    about: About,
    /// Events that do not fill a block yet: what is written must not depend on how many come at
    /// a time.
    rest: Vec<Event>,
}

impl fmt::Debug for Writer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Writer")
            .field("path", &self.path)
            .field("about", &self.about)
            .finish_non_exhaustive()
    }
}

impl Writer {
    /// A file of this format that will be at `path`.
    ///
    /// # Errors
    /// When the format cannot hold such a sensor or has no such compression, or the file cannot be
    /// made.
    pub fn create(
        path: &Path,
        format: Format,
        compression: Compression,
        head: &Head,
    ) -> Result<Self, FileError> {
        let gate =
            Gate::writing(format, head.about()).map_err(|fault| unwritable(path, 0, fault))?;
        let entry = format.entry();
        let Some(streams) = entry.streams else {
            let path = path.to_owned();
            return Err(FileError::NotBuilt { path, format });
        };
        // Who leaves it open has the default, which says nothing of this format.
        if compression != Compression::default() {
            format.check_compression(path, compression)?;
        }
        let mut sink = (streams.sink)(head, compression).map_err(|cause| {
            // What comes in columns waits for its end in temporary files.
            let path = std::env::temp_dir();
            SaveError { path, cause }
        })?;
        let mut file = if entry.rewinds {
            AtomicFile::create(path)?
        } else {
            AtomicFile::stream(path)?
        };
        let started = sink.start(&mut file);
        started.map_err(|cause| file.failed(cause))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            sink,
            gate,
            about: head.about(),
            rest: Vec::new(),
        })
    }

    /// Writes the next events.
    ///
    /// # Errors
    /// When the format cannot hold one of them, they are not in order or not on the sensor,
    /// or the disk does not take them. The file is then not worth going on with.
    pub fn put(&mut self, events: &[Event]) -> Result<(), FileError> {
        let before = self.gate.events;
        self.gate
            .admit(events)
            .map_err(|(i, fault)| unwritable(&self.path, before + i as u64, fault))?;
        let mut events = events;
        while self.rest.len() + events.len() >= BLOCK {
            let (now, later) = events.split_at(BLOCK - self.rest.len());
            if self.rest.is_empty() {
                self.block(now)?;
            } else {
                self.rest.extend_from_slice(now);
                self.flush()?;
            }
            events = later;
        }
        self.rest.extend_from_slice(events);
        Ok(())
    }

    fn block(&mut self, events: &[Event]) -> Result<(), FileError> {
        let put = self.sink.put(&mut self.file, events);
        put.map_err(|cause| self.file.failed(cause).into())
    }

    fn flush(&mut self) -> Result<(), FileError> {
        let mut events = std::mem::take(&mut self.rest);
        self.block(&events)?;
        events.clear();
        self.rest = events;
        Ok(())
    }

    /// Says what the head could not know: the time that was watched, and what is missing.
    pub const fn state(&mut self, span: (Micros, Micros), dropped: Dropped) {
        (self.about.span, self.about.dropped) = (Some(span), Some(dropped));
    }

    /// Gives the file its name; returns how many events it has.
    ///
    /// # Errors
    /// When the disk does not take it; whatever was at the path is then as it was.
    pub fn finish(mut self) -> Result<u64, FileError> {
        if !self.rest.is_empty() {
            self.flush()?;
        }
        let about = About {
            events: Some(self.gate.events),
            times: self.gate.times(),
            ..self.about
        };
        let finished = self.sink.finish(&mut self.file, &about);
        finished.map_err(|cause| self.file.failed(cause))?;
        self.file.keep()?;
        Ok(self.gate.events)
    }
}

fn unwritable(path: &Path, event: u64, fault: Fault) -> FileError {
    FileError::Unwritable {
        path: path.to_owned(),
        event,
        fault,
    }
}
