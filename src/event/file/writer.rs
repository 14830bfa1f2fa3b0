//! An event file, written a block at a time.

use std::path::{Path, PathBuf};

use super::{
    Fault, FileError, Format, about::About, aedat2, aedat3, aedat4, csv, dat, es, evt2, evt3,
    evt21, gate::Gate, npy, npz, source::Sink, txt,
};
use crate::{
    event::{Dropped, Event, Packet},
    plane::Size,
    save::AtomicFile,
    unit::Micros,
};

/// How the packets of an AEDAT4 file are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Compression {
    /// LZ4: every reader knows it.
    #[default]
    Lz4,
    /// Zstandard: smaller; not all readers know it.
    Zstd,
    /// As it is.
    None,
}

impl Compression {
    /// Its name in `--compression`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lz4 => "lz4",
            Self::Zstd => "zstd",
            Self::None => "none",
        }
    }
}

/// All of a packet but its events, which a file may say at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// Size of the sensor.
    pub size: Size,
    /// Kinds of cells.
    pub channels: u8,
    /// The time watched, where it is known to be another than that of the events.
    pub span: Option<(Micros, Micros)>,
    /// What is missing, where that is known.
    pub dropped: Option<Dropped>,
}

impl Head {
    /// That of a packet.
    #[must_use]
    pub const fn of(packet: &Packet) -> Self {
        Self {
            size: packet.size,
            channels: packet.channels,
            span: Some(packet.span),
            dropped: Some(packet.dropped),
        }
    }

    /// All of it, for a file that can say all.
    pub(super) const fn about(&self) -> About {
        About {
            size: Some(self.size),
            channels: Some(self.channels),
            span: self.span,
            dropped: self.dropped,
            ..About::NOTHING
        }
    }
}

/// An event file being written, whole or not at all: memory does not grow with its length.
///
/// Nothing is at the path before [`Writer::finish`].
pub struct Writer {
    path: PathBuf,
    draft: AtomicFile,
    sink: Box<dyn Sink>,
    gate: Gate,
    about: About,
}

impl Writer {
    /// A file of this format that will be at `path`.
    ///
    /// # Errors
    /// When the format cannot hold such a sensor, or the file cannot be made.
    pub fn create(
        path: &Path,
        format: Format,
        compression: Compression,
        head: &Head,
    ) -> Result<Self, FileError> {
        let gate =
            Gate::writing(format, head.about()).map_err(|fault| unwritable(path, 0, fault))?;
        let several = head.channels > 1;
        let mut sink: Box<dyn Sink> = match format {
            Format::Csv => Box::new(csv::sink(several)),
            Format::Txt => Box::new(txt::sink()),
            Format::Npy => Box::new(npy::sink(head)),
            Format::Npz => Box::new(npz::sink(head).map_err(|cause| FileError::Unreadable {
                path: std::env::temp_dir(),
                cause,
            })?),
            Format::Evt2 => Box::new(evt2::sink(head)),
            Format::Evt21 => Box::new(evt21::sink(head)),
            Format::Evt3 => Box::new(evt3::sink(head)),
            Format::Dat => Box::new(dat::sink(head)),
            Format::Aedat2 => Box::new(aedat2::sink(head)),
            Format::Aedat3 => Box::new(aedat3::sink(head)),
            Format::Aedat4 => Box::new(aedat4::sink(head, compression)),
            Format::Es => Box::new(es::sink(head)),
            #[cfg(feature = "hdf5")]
            Format::Hdf5 => Box::new(super::hdf5::sink(head)),
            #[cfg(feature = "parquet")]
            Format::Parquet => Box::new(super::parquet::sink(head)),
            #[allow(unreachable_patterns, reason = "unless both features are left out")]
            Format::Hdf5 | Format::Parquet => {
                let path = path.to_owned();
                return Err(FileError::NotBuilt { path, format });
            }
        };
        // Only these never go back to their start, where the others say how many events they have.
        let mut draft = match format {
            Format::Csv | Format::Txt | Format::Es | Format::Hdf5 | Format::Parquet => {
                AtomicFile::stream(path)?
            }
            _ => AtomicFile::create(path)?,
        };
        let started = sink.start(&mut draft);
        started.map_err(|cause| draft.failed(cause))?;
        Ok(Self {
            path: path.to_owned(),
            draft,
            sink,
            gate,
            about: head.about(),
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
        self.sink
            .put(&mut self.draft, events)
            .map_err(|cause| self.draft.failed(cause).into())
    }

    /// Gives the file its name; returns how many events it has.
    ///
    /// # Errors
    /// When the disk does not take it; whatever was at the path is then as it was.
    pub fn finish(mut self) -> Result<u64, FileError> {
        let about = About {
            events: Some(self.gate.events),
            times: self.gate.times(),
            ..self.about
        };
        let finished = self.sink.finish(&mut self.draft, &about);
        finished.map_err(|cause| self.draft.failed(cause))?;
        self.draft.keep()?;
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
