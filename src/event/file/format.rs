//! The formats: their names, their limits, who opens them.

use std::{fmt, path::Path, str::FromStr};

use super::FileError;

/// A kind of event file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Comma-separated text.
    Csv,
    /// Text with seconds, one event a line.
    Txt,
    /// numpy's structured array.
    Npy,
    /// numpy's archive of arrays.
    Npz,
    /// Prophesee EVT 2.0: 32-bit words.
    Evt2,
    /// Prophesee EVT 2.1: 64-bit words, 32 pixels of a row at a time.
    Evt21,
    /// Prophesee EVT 3.0: 16-bit words with a state.
    Evt3,
    /// Prophesee DAT: 64-bit records.
    Dat,
    /// jAER's AEDAT 2.0: 64-bit records, big-endian.
    Aedat2,
    /// cAER's AEDAT 3.1: packets of 64-bit records.
    Aedat3,
    /// DV's AEDAT 4.0: compressed packets.
    Aedat4,
    /// Event Stream: five bytes an event.
    Es,
    /// HDF5 as in the DSEC data set; needs the feature `hdf5`.
    Hdf5,
    /// Parquet; needs the feature `parquet`.
    Parquet,
}

/// What a format can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest column.
    pub x: u16,
    /// Largest row.
    pub y: u16,
    /// Latest time, in microseconds.
    pub t: u64,
    /// Longest time without an event, in microseconds, from 0 on.
    pub silence: u64,
    /// Whether it tells kinds of cells apart.
    pub channels: bool,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::Csv,
        Self::Txt,
        Self::Npy,
        Self::Npz,
        Self::Evt2,
        Self::Evt21,
        Self::Evt3,
        Self::Dat,
        Self::Aedat2,
        Self::Aedat3,
        Self::Aedat4,
        Self::Es,
        Self::Hdf5,
        Self::Parquet,
    ];

    /// What `--format` calls it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Txt => "txt",
            Self::Npy => "npy",
            Self::Npz => "npz",
            Self::Evt2 => "evt2",
            Self::Evt21 => "evt2.1",
            Self::Evt3 => "evt3",
            Self::Dat => "dat",
            Self::Aedat2 => "aedat2",
            Self::Aedat3 => "aedat3",
            Self::Aedat4 => "aedat4",
            Self::Es => "es",
            Self::Hdf5 => "hdf5",
            Self::Parquet => "parquet",
        }
    }

    /// The extension that its files usually have, without the dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Evt2 | Self::Evt21 | Self::Evt3 => "raw",
            Self::Aedat2 | Self::Aedat3 => "aedat",
            Self::Hdf5 => "h5",
            _ => self.name(),
        }
    }

    /// What it can hold.
    #[must_use]
    pub const fn limits(self) -> Limits {
        let wide = Limits {
            x: u16::MAX,
            y: u16::MAX,
            t: i64::MAX.unsigned_abs(),
            silence: u64::MAX,
            channels: true,
        };
        // Eleven bits for an address; every turn of the clock that passes is written out, so
        // the time is held to a few megabytes of turns.
        let prophesee = Limits {
            x: (1 << 11) - 1,
            y: (1 << 11) - 1,
            t: (1 << 44) - 1,
            channels: false,
            ..wide
        };
        match self {
            Self::Csv | Self::Npz | Self::Parquet => wide,
            // Its index has a number for each millisecond.
            Self::Hdf5 => Limits {
                silence: u32::MAX as u64,
                ..wide
            },
            Self::Txt => Limits {
                channels: false,
                ..wide
            },
            Self::Npy => Limits {
                x: i16::MAX.unsigned_abs(),
                y: i16::MAX.unsigned_abs(),
                ..wide
            },
            Self::Evt2 | Self::Evt21 | Self::Evt3 => prophesee,
            Self::Dat => Limits {
                x: (1 << 14) - 1,
                y: (1 << 14) - 1,
                t: u32::MAX as u64,
                channels: false,
                ..wide
            },
            // Nine bits of row, ten of column; readers take the time as 32 bits with a sign.
            Self::Aedat2 => Limits {
                x: (1 << 10) - 1,
                y: (1 << 9) - 1,
                t: i32::MAX as u64,
                channels: false,
                ..wide
            },
            Self::Aedat3 => Limits {
                x: (1 << 15) - 1,
                y: (1 << 15) - 1,
                t: (1 << 62) - 1,
                channels: false,
                ..wide
            },
            Self::Aedat4 => Limits {
                x: i16::MAX.unsigned_abs(),
                y: i16::MAX.unsigned_abs(),
                channels: false,
                ..wide
            },
            // Silence costs a byte each 127 us: an hour 28 megabytes.
            Self::Es => Limits {
                x: u16::MAX - 1,
                y: u16::MAX - 1,
                silence: u32::MAX as u64,
                channels: false,
                ..wide
            },
        }
    }

    /// The line of Python that opens a file of this format, `path` being its path.
    #[must_use]
    pub const fn python(self) -> &'static str {
        match self {
            Self::Csv => "pandas.read_csv(path)",
            Self::Txt => "numpy.loadtxt(path)",
            Self::Npy | Self::Npz => "numpy.load(path)",
            Self::Evt2 | Self::Evt3 | Self::Dat => "faery.events_stream_from_file(path).to_array()",
            Self::Evt21 => "evlib.load_events(path).collect()",
            Self::Aedat2 | Self::Aedat3 => {
                "[(e.timestamp, e.x, e.y, e.polarity) for e in dv.LegacyAedatFile(path)]"
            }
            Self::Aedat4 => "[p['events'] for p in aedat.Decoder(path) if 'events' in p]",
            Self::Es => "list(event_stream.Decoder(path))",
            Self::Hdf5 => "h5py.File(path)['events']",
            Self::Parquet => "pyarrow.parquet.read_table(path)",
        }
    }

    /// What [`Format::python`] needs to import.
    #[must_use]
    pub const fn module(self) -> &'static str {
        match self {
            Self::Csv => "pandas",
            Self::Txt | Self::Npy | Self::Npz => "numpy",
            Self::Evt2 | Self::Evt3 | Self::Dat => "faery",
            Self::Evt21 => "evlib",
            Self::Aedat2 | Self::Aedat3 => "dv",
            Self::Aedat4 => "aedat",
            Self::Es => "event_stream",
            Self::Hdf5 => "h5py",
            Self::Parquet => "pyarrow.parquet",
        }
    }

    /// The whole line of Python that opens this file.
    #[must_use]
    pub fn opened_by(self, path: &Path) -> String {
        let name = path.display().to_string();
        let name = name.replace('\\', "\\\\").replace('\'', "\\'");
        let line = self.python().replace("(path)", &format!("('{name}')"));
        format!("import {}; events = {line}", self.module())
    }

    /// The format that a file to be written asks for by its extension.
    ///
    /// # Errors
    /// When the extension is missing, unknown, or shared by several formats; the message
    /// lists those that there are.
    pub fn of(path: &Path) -> Result<Self, FileError> {
        let (path, extension) = (path.to_owned(), extension(path));
        match Self::by_extension(&extension)[..] {
            [format] => Ok(format),
            [] => Err(FileError::Extension { path, extension }),
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
        let fits = |f: &Self| {
            let other = match f {
                Self::Evt21 => "evt21",
                Self::Hdf5 => "hdf",
                _ => f.name(),
            };
            [f.name(), f.extension(), other].contains(&extension.as_str())
        };
        Self::ALL.into_iter().filter(fits).collect()
    }

    /// The format of a file to be read: by its extension where that says enough, else by its
    /// first bytes.
    ///
    /// # Errors
    /// When neither tells.
    pub fn of_content(path: &Path, start: &[u8]) -> Result<Self, FileError> {
        let known = Self::by_extension(&extension(path));
        match known[..] {
            [format] => Ok(format),
            [] => sniff(start).map_or_else(|| Self::of(path), Ok),
            _ => sniff(start).ok_or_else(|| FileError::Unknown {
                path: path.to_owned(),
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
    let binary = [
        (&b"\x93NUMPY"[..], Format::Npy),
        (b"PK\x03\x04", Format::Npz),
        (b"Event Stream", Format::Es),
        (b"\x89HDF\r\n\x1a\n", Format::Hdf5),
        (b"PAR1", Format::Parquet),
        (b"#!AER-DAT2.0", Format::Aedat2),
        (b"#!AER-DAT3.1", Format::Aedat3),
        (b"#!AER-DAT4.0", Format::Aedat4),
    ];
    let known = binary
        .into_iter()
        .find(|(magic, _)| start.starts_with(magic));
    if let Some((_, format)) = known {
        return Some(format);
    }
    let header = start
        .split(|b| *b == b'\n')
        .take_while(|line| line.starts_with(b"%"))
        .map(|line| String::from_utf8_lossy(line).to_ascii_lowercase());
    for line in header {
        let words: Vec<_> = line
            .trim_start_matches('%')
            .split([' ', ';', '\r'])
            .filter(|word| !word.is_empty())
            .collect();
        match words[..] {
            ["evt", "2.0" | "2", ..] | ["format", "evt2", ..] => return Some(Format::Evt2),
            ["evt", "2.1", ..] | ["format", "evt21", ..] => return Some(Format::Evt21),
            ["evt", "3.0" | "3", ..] | ["format", "evt3", ..] => return Some(Format::Evt3),
            ["data", "file", "containing", ..] => return Some(Format::Dat),
            _ => (),
        }
    }
    None
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no format's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{name}` is no format of event files; known are {}", names(&Format::ALL))]
#[diagnostic(help("`docs/formats.md` says what each can hold and who reads it"))]
pub struct FormatError {
    /// What was given.
    pub name: String,
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(name: &str) -> Result<Self, FormatError> {
        let found = Self::ALL.into_iter().find(|f| f.name() == name);
        found.ok_or_else(|| FormatError { name: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back_and_is_an_extension() {
        for format in Format::ALL {
            assert_eq!(format.name().parse(), Ok(format));
            let path = format!("a.{}", format.name());
            assert_eq!(Format::of(Path::new(&path)).unwrap(), format, "{path}");
        }
        assert!("raw".parse::<Format>().is_err());
        for (name, format) in [
            ("a.H5", Format::Hdf5),
            ("a.evt21", Format::Evt21),
            ("a.hdf", Format::Hdf5),
        ] {
            assert_eq!(Format::of(Path::new(name)).unwrap(), format, "{name}");
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
        assert_eq!(
            told("a.csv", b"PAR1"),
            Some(Format::Csv),
            "the extension decides"
        );
        assert!(
            Format::of(Path::new("a.raw")).is_err(),
            "it does not say which"
        );
    }
}
