//! Event files that the field's tools open, one file a format.
//!
//! `docs/formats.md` has the table: what each format holds, who reads it, and the line of
//! Python that opens it ([`Format::python`]). [`read`] and [`write()`] move whole packets;
//! [`Reader`] and [`Writer`] go block by block in memory that does not grow.
//!
//! Time is absolute, y runs down. What a format cannot hold is refused, never clipped or
//! flattened. A file that does not say its size gets the smallest that holds its events, and
//! [`Loaded`] says so.
//!
//! A new format is a file beside these and a line of the list in `format.rs`;
//! `docs/extending.md` walks through it.

mod about;
mod aedat2;
mod aedat3;
mod aedat4;
mod chunks;
#[cfg(any(feature = "hdf5", feature = "parquet"))]
mod columns;
mod csv;
mod dat;
mod e2vid;
mod e2vid_zip;
mod encoding;
mod entry;
mod es;
mod evt2;
mod evt21;
mod evt3;
mod fault;
mod flat;
mod format;
mod gate;
mod hdf5;
mod head;
mod header;
mod line;
mod npy;
mod npz;
mod origin;
mod packed;
mod packets;
mod parquet;
mod prophesee;
mod reader;
mod recognise;
mod source;
mod txt;
mod writer;

use std::path::Path;

pub use about::About;
pub use entry::Limits;
pub use fault::{Fault, FileError, Place};
pub use format::Format;
pub use head::{Compression, Head};
pub use reader::{Opening, Reader};
pub use recognise::FormatError;
pub use writer::Writer;

pub(super) use npz::Steady;

use super::{Event, Packet};

/// A packet from a file, and how much of it the file said itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loaded {
    /// The packet.
    pub packet: Packet,
    /// The file gave the size; otherwise it is the smallest that holds the events.
    pub size_known: bool,
    /// The file gave the number of channels; otherwise it is the smallest that holds the events.
    pub channels_known: bool,
    /// The file gave the drops; otherwise those of the packet are 0.
    pub dropped_known: bool,
    /// Records that are no events of a pixel and were left out, see [`Reader::skipped`].
    pub skipped: u64,
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
/// When the extension is unknown or shared by several formats, the format cannot hold the
/// packet (nothing is flattened or clipped), or the file cannot be written.
pub fn write(path: &Path, packet: &Packet) -> Result<(), FileError> {
    write_as(
        path,
        Format::from_path(path)?,
        Compression::default(),
        packet,
    )
}

/// Writes a packet in this format, whatever the file is called.
///
/// # Errors
/// As [`write()`].
pub fn write_as(
    path: &Path,
    format: Format,
    compression: Compression,
    packet: &Packet,
) -> Result<(), FileError> {
    let mut writer = Writer::create(path, format, compression, &Head::from_packet(packet))?;
    writer.put(&packet.events)?;
    writer.finish()?;
    Ok(())
}

/// Reads an event file in the format that its extension names, or its first bytes where
/// several formats share the extension.
///
/// # Errors
/// When the format is not known, the file cannot be opened, or anything in it is not as the
/// format says; the message names the line and column, or the byte.
pub fn read(path: &Path) -> Result<Loaded, FileError> {
    read_as(path, &Opening::default())
}

/// Reads an event file, with what `how` says about it.
///
/// # Errors
/// As [`read`].
pub fn read_as(path: &Path, how: &Opening) -> Result<Loaded, FileError> {
    match salvage(path, how)? {
        (loaded, None) => Ok(loaded),
        (_, Some(error)) => Err(error),
    }
}

/// Reads all events before the first damage, and says what the damage is.
///
/// # Errors
/// When there is nothing to read: the file cannot be opened, or its header is not as the
/// format says.
pub fn salvage(path: &Path, how: &Opening) -> Result<(Loaded, Option<FileError>), FileError> {
    Reader::open(path, how).map(all)
}

/// Reads the events that are left, up to the first damage, and says what the damage is.
#[must_use]
pub fn all(mut reader: Reader) -> (Loaded, Option<FileError>) {
    let (loaded, damage, _) = up_to(&mut reader, usize::MAX);
    (loaded, damage)
}

/// As [`all`], but no more than `most` events and those of one block; and whether the file went
/// on after them.
#[must_use]
pub fn up_to(reader: &mut Reader, most: usize) -> (Loaded, Option<FileError>, bool) {
    let mut block: Vec<Event> = Vec::new();
    let mut events = Vec::new();
    // What a file says of itself may be wrong: where there is no such room, it grows.
    let said = reader.about().events.unwrap_or(0);
    let _ = events.try_reserve_exact(usize::try_from(said).unwrap_or(most).min(most));
    let mut more = false;
    let damage = loop {
        if events.len() > most {
            more = true;
            break None;
        }
        match reader.next_block(&mut block) {
            Ok(true) => events.append(&mut block),
            Ok(false) => break None,
            Err(error) => break Some(error),
        }
    };
    (reader.loaded(events), damage, more)
}
