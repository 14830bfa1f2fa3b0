//! The one place where texts and small files of numbers are read.
//!
//! A file is read up to its limit and one byte further: one that never ends, a device or a pipe,
//! is refused there. Pipes and `/dev/stdin` are read like files.

use std::{
    fmt,
    fs::File,
    io::{self, BufRead, Read},
    path::{Path, PathBuf},
};

use crate::{
    limit::{LINE_BYTES, NUMBERS_BYTES, TEXT_BYTES},
    npy::MAGIC,
};

/// What some editors begin a text with.
const MARK: char = '\u{feff}';

/// A file that cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot read {}: {cause}", path.display())]
#[diagnostic(help("{help}"))]
pub struct SourceError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub cause: Cause,
    /// What the user can do about it.
    pub help: String,
}

/// What is wrong with a file.
#[derive(Debug)]
pub enum Cause {
    /// An error of the system.
    System(io::Error),
    /// It is a folder.
    Folder,
    /// It goes on beyond the limit.
    Long {
        /// The limit, in bytes.
        most: u64,
        /// Which kind of file has this limit.
        kind: &'static str,
    },
    /// A line goes on beyond the limit.
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// Bytes of the line.
        bytes: usize,
    },
    /// Not text.
    NotText {
        /// Number of the line, from 1.
        line: usize,
        /// Column of the byte, from 1, in characters.
        column: usize,
        /// The first byte that is no text.
        byte: u8,
    },
    /// Not what `numpy.save` writes.
    NotNumbers,
}

impl std::error::Error for Cause {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::System(cause) => Some(cause),
            _ => None,
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(cause) => cause.fmt(f),
            Self::Folder => f.write_str("it is a directory"),
            Self::Long { most, kind } => {
                write!(f, "it goes on; a {kind} file holds at most {most} bytes")
            }
            Self::Line { line, bytes } => write!(
                f,
                "line {line} has {bytes} bytes; a line holds at most {LINE_BYTES}"
            ),
            Self::NotText { line, column, byte } => write!(
                f,
                "it is not text in UTF-8: byte {byte:#04x} in line {line}, column {column}"
            ),
            Self::NotNumbers => f.write_str("it is no .npy: it does not begin with \\x93NUMPY"),
        }
    }
}

impl SourceError {
    fn new(path: &Path, cause: Cause, help: &str) -> Self {
        let alone = match &cause {
            Cause::System(_) | Cause::Folder | Cause::NotNumbers => help,
            Cause::Long { .. } => "give a smaller file; one that never ends is no file",
            Cause::Line { .. } => "break the line",
            Cause::NotText { .. } => "save the file as UTF-8",
        };
        // It may be a file of another kind.
        let both = matches!(cause, Cause::NotText { .. }) && !help.is_empty();
        Self {
            path: path.to_owned(),
            help: if both {
                format!("{help}; a text file: {alone}")
            } else {
                alone.to_owned()
            },
            cause,
        }
    }
}

impl From<SourceError> for io::Error {
    /// What the system said stays what it is; the rest becomes an error of its own.
    fn from(error: SourceError) -> Self {
        match error.cause {
            Cause::System(cause) => cause,
            cause => Self::other(cause.to_string()),
        }
    }
}

/// Reads a text file; `help` says what to give in its place.
///
/// # Errors
/// When it cannot be read, is longer than a text may be, or is not text.
pub fn text(path: &Path, help: &str) -> Result<String, SourceError> {
    text_of(path, help, |bytes| bytes)
}

/// Reads a file of program code, as [`text`]; bytes that are no UTF-8, as comments and texts of
/// other encodings have them, become the character that stands for such.
///
/// # Errors
/// As [`text`], but for such bytes.
pub fn code(path: &Path, help: &str) -> Result<String, SourceError> {
    text_of(path, help, |bytes| {
        String::from_utf8_lossy(&bytes).into_owned().into_bytes()
    })
}

fn text_of(
    path: &Path,
    help: &str,
    decoded: fn(Vec<u8>) -> Vec<u8>,
) -> Result<String, SourceError> {
    let read = || {
        let bytes = rest(open(path)?, Vec::new(), TEXT_BYTES, "text")?;
        let mut text = checked(decoded(bytes))?;
        // The byte order mark of some editors takes no column.
        if text.starts_with(MARK) {
            text.drain(..MARK.len_utf8());
        }
        Ok(text)
    };
    read().map_err(|cause| SourceError::new(path, cause, help))
}

/// Reads a `.npy`; `help` says what to give in its place.
///
/// # Errors
/// When it cannot be read, does not begin as a `.npy` does, or is longer than one may be.
pub fn numbers(path: &Path, help: &str) -> Result<Vec<u8>, SourceError> {
    let read = || {
        let mut file = open(path)?;
        let mut start = Vec::new();
        let read = (&mut file).take(MAGIC.len() as u64).read_to_end(&mut start);
        read.map_err(Cause::System)?;
        if start != MAGIC {
            return Err(Cause::NotNumbers);
        }
        rest(file, start, NUMBERS_BYTES, ".npy")
    };
    read().map_err(|cause| SourceError::new(path, cause, help))
}

/// Reads a small file that may be a text or a `.npy`; `help` says what to give in its place.
///
/// # Errors
/// When it cannot be read, or is longer than a text may be.
pub fn bytes(path: &Path, help: &str) -> Result<Vec<u8>, SourceError> {
    let read = || rest(open(path)?, Vec::new(), TEXT_BYTES, "text");
    read().map_err(|cause| SourceError::new(path, cause, help))
}

/// One line of a stream, without its end; nothing at the end of the stream.
///
/// # Errors
/// When it cannot be read, is longer than a line may be, or is not text.
pub fn line(mut from: impl BufRead) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    (&mut from)
        .take(LINE_BYTES + 1)
        .read_until(b'\n', &mut bytes)?;
    if bytes.is_empty() {
        return Ok(None);
    }
    if bytes.last() == Some(&b'\n') {
        bytes.pop();
    } else if bytes.len() as u64 > LINE_BYTES {
        return Err(io::Error::other(format!(
            "a line holds at most {LINE_BYTES} bytes"
        )));
    }
    let text = String::from_utf8(bytes).map_err(|_| io::Error::other("not text in UTF-8"))?;
    Ok(Some(text))
}

/// A folder can be opened, but not read.
fn open(path: &Path) -> Result<File, Cause> {
    let file = File::open(path).map_err(Cause::System)?;
    if file.metadata().is_ok_and(|about| about.is_dir()) {
        return Err(Cause::Folder);
    }
    Ok(file)
}

/// What comes after these bytes, up to the limit.
fn rest(file: File, mut bytes: Vec<u8>, most: u64, kind: &'static str) -> Result<Vec<u8>, Cause> {
    let left = (most + 1).saturating_sub(bytes.len() as u64);
    let read = file.take(left).read_to_end(&mut bytes);
    read.map_err(Cause::System)?;
    if bytes.len() as u64 > most {
        return Err(Cause::Long { most, kind });
    }
    Ok(bytes)
}

/// Text, in lines that a person can be shown.
fn checked(bytes: Vec<u8>) -> Result<String, Cause> {
    let text = String::from_utf8(bytes).map_err(|error| {
        let (good, bad) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let before = String::from_utf8_lossy(good);
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        Cause::NotText {
            line: before.matches('\n').count() + 1,
            column: before[start..].chars().count() + 1,
            byte: bad.first().copied().unwrap_or_default(),
        }
    })?;
    let long = (1..)
        .zip(text.split('\n'))
        .find(|(_, line)| line.len() as u64 > LINE_BYTES);
    match long {
        Some((line, found)) => Err(Cause::Line {
            line,
            bytes: found.len(),
        }),
        None => Ok(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        file
    }

    fn message(bytes: &[u8]) -> String {
        text(file(bytes).path(), "help")
            .unwrap_err()
            .cause
            .to_string()
    }

    #[test]
    fn a_text_ends_at_its_limit() {
        let mut bytes = vec![b'\n'; TEXT_BYTES as usize];
        assert_eq!(text(file(&bytes).path(), "").unwrap().len(), bytes.len());
        bytes.push(b'\n');
        assert!(message(&bytes).contains("at most 4194304 bytes"));
    }

    #[test]
    fn a_line_ends_at_its_limit() {
        let mut bytes = vec![b'x'; LINE_BYTES as usize];
        bytes.insert(0, b'\n');
        assert!(text(file(&bytes).path(), "").is_ok());
        bytes.push(b'x');
        assert_eq!(
            message(&bytes),
            "line 2 has 65537 bytes; a line holds at most 65536"
        );
    }

    #[test]
    fn what_is_no_text_has_its_place() {
        assert_eq!(
            message(b"ab\n\xc3\xa4\xff"),
            "it is not text in UTF-8: byte 0xff in line 2, column 2"
        );
    }

    #[test]
    fn a_folder_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = text(folder.path(), "give a file").unwrap_err();
        assert!(error.to_string().ends_with("it is a directory"));
    }

    #[test]
    fn what_never_ends_is_refused() {
        let error = text(Path::new("/dev/zero"), "").unwrap_err();
        assert!(matches!(error.cause, Cause::Long { .. }));
        let error = bytes(Path::new("/dev/zero"), "").unwrap_err();
        assert!(matches!(error.cause, Cause::Long { .. }));
        let error = numbers(Path::new("/dev/zero"), "").unwrap_err();
        assert!(matches!(error.cause, Cause::NotNumbers));
    }

    #[test]
    fn a_line_of_a_stream_is_bounded() {
        let mut two = &b"one\ntwo"[..];
        assert_eq!(line(&mut two).unwrap().as_deref(), Some("one"));
        assert_eq!(line(&mut two).unwrap().as_deref(), Some("two"));
        assert_eq!(line(&mut two).unwrap(), None);
        assert!(line(io::BufReader::new(io::repeat(b'x'))).is_err());
    }
}
