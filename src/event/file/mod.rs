//! Event files that the field's tools open, chosen by extension.
//!
//! | extension | what | the line of Python that opens it |
//! |---|---|---|
//! | `.csv` | header `t,x,y,p` (and `channel` when there are several), integer microseconds, p 0 or 1 | `pandas.read_csv(path)` or `numpy.genfromtxt(path, delimiter=',', names=True, dtype=int)` |
//! | `.npy` | structured array, fields `t x y p` (and `channel`) | `numpy.load(path)` |
//! | `.txt` | `t x y p`, seconds with nine decimals, one channel | `numpy.loadtxt(path)` |
//!
//! Time is absolute, y runs down. `.npy` carries the whole packet (see [`npy`]); `.csv` and
//! `.txt` are written bare, so that the plainest reader can open them. A file that does not
//! say its size gets the smallest that holds its events, and [`Loaded`] tells so.
//!
//! A new format is a variant of [`Format`], a file beside these, and the arms that the
//! compiler then asks for.

mod about;
pub mod csv;
mod fault;
mod intake;
mod line;
pub mod npy;
pub mod txt;

use std::{
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
};

use fault::Stop;
pub use fault::{Fault, FileError, Place};

use super::Packet;
use crate::save::save;

/// A kind of event file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Comma-separated text.
    Csv,
    /// numpy's structured array.
    Npy,
    /// Text with seconds, one event a line.
    Txt,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Csv, Self::Npy, Self::Txt];

    /// Its extension, without the dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Npy => "npy",
            Self::Txt => "txt",
        }
    }

    /// The format that a file name asks for.
    ///
    /// # Errors
    /// When the extension is missing or unknown; the message lists the known ones.
    pub fn of(path: &Path) -> Result<Self, FileError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        Self::ALL
            .into_iter()
            .find(|f| f.extension().eq_ignore_ascii_case(extension))
            .ok_or_else(|| FileError::Extension {
                path: path.to_owned(),
                extension: extension.to_owned(),
            })
    }
}

/// A packet from a file, and how much of it the file said itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loaded {
    /// The packet.
    pub packet: Packet,
    /// The file gave the size; otherwise it is the smallest that holds the events.
    pub size_known: bool,
    /// The file gave the number of channels; otherwise it is the smallest that holds the events.
    pub channels_known: bool,
}

impl Loaded {
    /// Widens what this file did not say itself to what `other` has, so that two files of one
    /// sensor can be compared although each saw other corners of it.
    pub fn widen_to(&mut self, other: &Packet) {
        let own = &mut self.packet;
        if !self.size_known {
            own.size.height = own.size.height.max(other.size.height);
            own.size.width = own.size.width.max(other.size.width);
        }
        if !self.channels_known {
            own.channels = own.channels.max(other.channels);
        }
    }
}

/// Writes a packet, whole or not at all, in the format that the extension names.
///
/// # Errors
/// When the extension is unknown, the format cannot hold the packet (nothing is flattened or
/// clipped), or the file cannot be written.
pub fn write(path: &Path, packet: &Packet) -> Result<(), FileError> {
    let format = Format::of(path)?;
    intake::check(packet, format).map_err(|(event, fault)| FileError::Unwritable {
        path: path.to_owned(),
        event,
        fault,
    })?;
    save(path, |out| match format {
        Format::Csv => csv::write(out, packet),
        Format::Npy => npy::write(out, packet),
        Format::Txt => txt::write(out, packet),
    })?;
    Ok(())
}

/// Reads an event file in the format that its extension names.
///
/// # Errors
/// When the extension is unknown, the file cannot be opened, or anything in it is not as the
/// format says; the message names the line and column, or the byte.
pub fn read(path: &Path) -> Result<Loaded, FileError> {
    let format = Format::of(path)?;
    let unreadable = |cause| FileError::Unreadable {
        path: PathBuf::from(path),
        cause,
    };
    let mut input = BufReader::with_capacity(1 << 16, File::open(path).map_err(unreadable)?);
    let loaded = match format {
        Format::Csv => csv::read(&mut input),
        Format::Npy => npy::read(&mut input),
        Format::Txt => txt::read(&mut input),
    };
    loaded.map_err(|stop| match stop {
        Stop::Io(cause) => unreadable(cause),
        Stop::Fault(place, fault) => FileError::Bad {
            path: path.to_owned(),
            place,
            fault,
        },
    })
}
