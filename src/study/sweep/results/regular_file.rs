//! The files of a results folder are regular files: nothing is read or written through a
//! symlink, a FIFO or a device that stands in the place of one.

use std::{
    fs::{self, File, Metadata, OpenOptions},
    io::{self, Read},
    path::Path,
};

/// Why there is no file to work with.
#[derive(Debug)]
pub(super) enum Unusable {
    /// Nothing is there.
    Absent,
    /// Something else is there.
    Kind(&'static str),
    /// It is longer than such a file can be.
    Long(u64),
    /// The system said so.
    System(io::Error),
}

impl From<io::Error> for Unusable {
    fn from(cause: io::Error) -> Self {
        match cause.kind() {
            io::ErrorKind::NotFound => Self::Absent,
            _ => Self::System(cause),
        }
    }
}

/// What stands at a path; a symlink is a symlink, wherever it leads.
pub(super) fn kind(path: &Path) -> io::Result<Option<&'static str>> {
    match fs::symlink_metadata(path) {
        Ok(found) => Ok(Some(named(&found))),
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(cause) => Err(cause),
    }
}

/// What [`kind`] calls a regular file.
pub(super) const FILE: &str = "a file";
/// What [`kind`] calls a folder.
pub(super) const FOLDER: &str = "a folder";

fn named(found: &Metadata) -> &'static str {
    let kind = found.file_type();
    if kind.is_file() {
        FILE
    } else if kind.is_dir() {
        FOLDER
    } else if kind.is_symlink() {
        "a symlink"
    } else {
        "a FIFO, a socket or a device"
    }
}

/// Opens a regular file. Looked at first, for a true message; the flags hold against whoever
/// swaps it in between.
pub(super) fn open(path: &Path, options: &mut OpenOptions) -> Result<File, Unusable> {
    let check = |kind| {
        if kind == FILE {
            Ok(())
        } else {
            Err(Unusable::Kind(kind))
        }
    };
    if let Some(kind) = kind(path)? {
        check(kind)?;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        // A FIFO would wait for its other end.
        options.custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK);
    }
    let file = options.open(path)?;
    check(named(&file.metadata()?))?;
    Ok(file)
}

/// All bytes of a regular file that has at most so many.
pub(super) fn read(path: &Path, most: u64) -> Result<Vec<u8>, Unusable> {
    let file = open(path, OpenOptions::new().read(true))?;
    let long = file.metadata()?.len();
    if long > most {
        return Err(Unusable::Long(long));
    }
    let mut bytes = Vec::new();
    // It may grow while it is read.
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(Unusable::Long(bytes.len() as u64));
    }
    Ok(bytes)
}
