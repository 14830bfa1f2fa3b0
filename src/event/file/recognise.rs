//! Recognising the format of a file: by its extension, its first bytes, or a given name.

use std::{path::Path, str::FromStr};

use super::{
    encoding::Encoding,
    entry::{Entry, Sign},
    fault::{Fault, FileError, Place},
    format::Format,
};

impl Format {
    /// The format that a file to be written asks for by its extension.
    ///
    /// # Errors
    /// When the extension is missing, unknown, or shared by several formats; the message
    /// lists those that there are.
    pub fn from_path(path: &Path) -> Result<Self, FileError> {
        let (path, extension) = (path.to_owned(), extension(path));
        match Self::by_extension(&extension)[..] {
            [format] => Ok(format),
            [] => Err(FileError::Extension {
                path,
                extension,
                written: true,
            }),
            ref several => Err(FileError::Ambiguous {
                path,
                extension,
                names: names(several),
            }),
        }
    }

    /// All formats whose files may have this name; of some there are several, and of most
    /// names none.
    #[must_use]
    pub fn named(path: &Path) -> Vec<Self> {
        Self::by_extension(&extension(path))
    }

    /// All formats whose files have this extension.
    fn by_extension(extension: &str) -> Vec<Self> {
        let extension = extension.to_ascii_lowercase();
        let fits = |format: &Self| {
            let Entry {
                name,
                extension: usual,
                also,
                ..
            } = format.entry();
            [name, usual].contains(&&&*extension) || also.contains(&&*extension)
        };
        Self::ALL.iter().copied().filter(fits).collect()
    }

    /// The format of a file to be read: by its extension where that says enough, else by its
    /// first bytes.
    ///
    /// # Errors
    /// When neither says which.
    pub fn of_content(path: &Path, start: &[u8]) -> Result<Self, FileError> {
        let known = Self::by_extension(&extension(path));
        match known[..] {
            [format] => Ok(format),
            [] => sniff(start).ok_or_else(|| FileError::Extension {
                path: path.to_owned(),
                extension: extension(path),
                written: false,
            }),
            _ => sniff(start).ok_or_else(|| {
                match lines(start).find_map(|it| Encoding::of_line(&it)) {
                    Some(Encoding { name, .. }) => FileError::Bad {
                        path: path.to_owned(),
                        place: Place::Byte(0),
                        fault: Fault::Encoding { name },
                        opened: false,
                    },
                    None => FileError::Unknown {
                        path: path.to_owned(),
                    },
                }
            }),
        }
    }
}

/// What follows the last dot of a name that has one.
fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    let extension = extension.to_string_lossy().into_owned();
    // `recording.evt2.1` ends in `.1` as far as the system is concerned.
    let name = path.to_string_lossy().to_ascii_lowercase();
    if extension == "1" && name.ends_with(".evt2.1") {
        return "evt2.1".into();
    }
    extension
}

/// Names, with commas between.
fn names(formats: &[Format]) -> String {
    let names: Vec<_> = formats.iter().map(|f| f.name()).collect();
    names.join(", ")
}

/// The format that says so in its first bytes.
fn sniff(start: &[u8]) -> Option<Format> {
    let mut all = Format::ALL.iter().copied();
    let begins = |format: &Format| match format.entry().sign {
        Sign::Bytes(magic) => start.starts_with(magic),
        Sign::Archive(member) => first_member(start).is_some_and(|name| {
            let extension = Path::new(name).extension();
            extension.is_some_and(|its| its.eq_ignore_ascii_case(member))
        }),
        Sign::Nothing | Sign::Line(_) | Sign::Encoding => false,
    };
    if let Some(format) = all.find(begins) {
        return Some(format);
    }
    // The first line that says a format decides.
    lines(start).find_map(|line| {
        let words = line.to_ascii_lowercase();
        let words: Vec<_> = words
            .trim_start_matches('%')
            .split([' ', ';', '\r'])
            .filter(|word| !word.is_empty())
            .collect();
        let named = Encoding::of_line(&line).and_then(|it| it.format);
        let says = |format: &Format| match format.entry().sign {
            Sign::Line(says) => says(&words),
            Sign::Encoding => named == Some(*format),
            Sign::Nothing | Sign::Bytes(_) | Sign::Archive(_) => false,
        };
        Format::ALL.iter().copied().find(says)
    })
}

/// The lines of a header whose lines begin with `%`.
fn lines(start: &[u8]) -> impl Iterator<Item = std::borrow::Cow<'_, str>> {
    let lines = start.split(|b| *b == b'\n');
    lines
        .take_while(|line| line.starts_with(b"%"))
        .map(String::from_utf8_lossy)
}

/// What the first member of a zip archive is called; `start` are its first bytes.
fn first_member(start: &[u8]) -> Option<&str> {
    /// A local file header up to the name: APPNOTE 6.3.10, section 4.3.7.
    const HEADER: usize = 30;
    let header = start.strip_prefix(b"PK\x03\x04").and(start.get(..HEADER))?;
    let length = usize::from(u16::from_le_bytes([header[26], header[27]]));
    std::str::from_utf8(start.get(HEADER..HEADER + length)?).ok()
}

/// A name that is no format's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error(
    "`{name}` is no format of event files; known are {}",
    names(Format::ALL)
)]
#[diagnostic(help("`docs/formats.md` says what each can hold and who reads it"))]
pub struct FormatError {
    /// What was given.
    pub name: String,
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(name: &str) -> Result<Self, FormatError> {
        let found = Self::ALL.iter().copied().find(|f| f.name() == name);
        found.ok_or_else(|| FormatError { name: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back_and_is_an_extension() {
        for &format in Format::ALL {
            assert_eq!(format.name().parse(), Ok(format));
            let path = format!("a.{}", format.name());
            assert_eq!(
                Format::from_path(Path::new(&path)).unwrap(),
                format,
                "{path}"
            );
        }
        assert!("raw".parse::<Format>().is_err());
        for (name, format) in [
            ("a.H5", Format::Hdf5),
            ("a.evt21", Format::Evt21),
            ("a.hdf", Format::Hdf5),
        ] {
            assert_eq!(
                Format::from_path(Path::new(name)).unwrap(),
                format,
                "{name}"
            );
        }
    }

    #[test]
    fn shared_extensions_are_told_apart_by_content() {
        let told = |name: &str, start: &[u8]| Format::of_content(Path::new(name), start).ok();
        assert_eq!(told("a.raw", b"% date x\n% evt 3.0\n"), Some(Format::Evt3));
        assert_eq!(
            told("a.raw", b"% format EVT21;height=1\n"),
            Some(Format::Evt21)
        );
        assert_eq!(told("a.raw", b"% evt 2.0\r\n"), Some(Format::Evt2));
        assert_eq!(told("a.aedat", b"#!AER-DAT3.1\r\n"), Some(Format::Aedat3));
        assert_eq!(told("a", b"PAR1"), Some(Format::Parquet));
        assert_eq!(told("a.raw", b"\x00\x01"), None);
        let zip = |name: &str| {
            let mut start = b"PK\x03\x04".to_vec();
            start.resize(26, 0);
            start.extend([name.len() as u8, 0, 0, 0]);
            start.extend(name.bytes());
            start
        };
        assert_eq!(told("a.bin", &zip("t.npy")), Some(Format::Npz));
        assert_eq!(told("a.bin", &zip("events.txt")), Some(Format::E2vidZip));
        assert_eq!(told("a.bin", &zip("a.png")), None);
        assert_eq!(told("a.bin", b"PK\x03\x04"), None);
        assert_eq!(
            told("a.csv", b"PAR1"),
            Some(Format::Csv),
            "the extension decides"
        );
        assert!(
            Format::from_path(Path::new("a.raw")).is_err(),
            "it does not say which"
        );
    }
}
