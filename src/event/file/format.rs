//! The list of formats: their names, their limits, who reads and writes them.
//!
//! A new format is a file beside this one, with its [`Entry`], and a line of the list.

use std::{fmt, io, path::Path, str::FromStr};

use super::{
    FileError,
    chunks::Chunks,
    fault::Stop,
    reader::Origin,
    source::{Sink, Source},
    writer::{Compression, Head},
};

/// Makes [`Format`] from its list: the variants, [`Format::ALL`] and the entry of each.
macro_rules! formats {
    ($(#[doc = $about:literal] $format:ident => $file:ident,)+) => {
        /// A kind of event file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Format {
            $(#[doc = $about] $format,)+
        }

        impl Format {
            /// All of them, in the order in which helps and pages list them.
            pub const ALL: &'static [Self] = &[$(Self::$format),+];

            pub(super) const fn entry(self) -> &'static Entry {
                match self {
                    $(Self::$format => &super::$file::ENTRY,)+
                }
            }
        }
    };
}

// The list. What is said of a format stands in its file.
formats! {
    /// Comma-separated text.
    Csv => csv,
    /// Text with seconds, one event a line.
    Txt => txt,
    /// numpy's structured array.
    Npy => npy,
    /// numpy's archive of arrays.
    Npz => npz,
    /// Prophesee EVT 2.0: 32-bit words.
    Evt2 => evt2,
    /// Prophesee EVT 2.1: 64-bit words, 32 pixels of a row at a time.
    Evt21 => evt21,
    /// Prophesee EVT 3.0: 16-bit words with a state.
    Evt3 => evt3,
    /// Prophesee DAT: 64-bit records.
    Dat => dat,
    /// jAER's AEDAT 2.0: 64-bit records, big-endian.
    Aedat2 => aedat2,
    /// cAER's AEDAT 3.1: packets of 64-bit records.
    Aedat3 => aedat3,
    /// DV's AEDAT 4.0: compressed packets.
    Aedat4 => aedat4,
    /// Event Stream: five bytes an event.
    Es => es,
    /// HDF5 as in the DSEC data set; needs the feature `hdf5`.
    Hdf5 => hdf5,
    /// Parquet; needs the feature `parquet`.
    Parquet => parquet,
}

/// What there is to say of a format, and who reads and writes it: one in each format's file.
pub(super) struct Entry {
    /// What `--format` calls it; also an extension that its files may have.
    pub name: &'static str,
    /// The extension that its files usually have, without the dot.
    pub extension: &'static str,
    /// Other extensions that say this format.
    pub also: &'static [&'static str],
    /// What it can hold.
    pub limits: Limits,
    /// Who reads it, for people.
    pub readers: &'static str,
    /// What Python imports to open it.
    pub module: &'static str,
    /// The expression of Python that opens the file at `path`.
    pub python: &'static str,
    /// What a file of several possible formats is known by.
    pub sign: Sign,
    /// Readers and writers, unless this build has none.
    pub streams: Option<Streams>,
    /// A writer goes back to the start, where the file says how many events it has.
    pub rewinds: bool,
    /// The sensor's size is written as a number of few bits.
    pub few_bits_of_size: bool,
    /// Silence is counted from the first event on, not from time 0.
    pub clock_from_first: bool,
}

impl Entry {
    /// What most formats have in common.
    pub const PLAIN: Self = Self {
        name: "",
        extension: "",
        also: &[],
        limits: Limits::WIDE,
        readers: "",
        module: "",
        python: "",
        sign: Sign::Nothing,
        streams: None,
        rewinds: true,
        few_bits_of_size: false,
        clock_from_first: false,
    };
}

/// What the start of a file says of its format.
#[derive(Clone, Copy)]
pub(super) enum Sign {
    /// Nothing.
    Nothing,
    /// It begins with these bytes.
    Bytes(&'static [u8]),
    /// A line of its header, which is of lines that begin with `%`, has these words, in lower
    /// case.
    Line(fn(&[&str]) -> bool),
}

/// A file whose header was read, or what is wrong with it.
type Opened = Result<Box<dyn Source>, Stop>;

/// How events come from a file and go into one.
#[derive(Clone, Copy)]
pub(super) struct Streams {
    /// Reads what stands before the events; the chunks are those of the origin.
    pub source: fn(&Origin, Chunks) -> Opened,
    /// Begins to write; the error is that of temporary files.
    pub sink: fn(&Head, Compression) -> io::Result<Box<dyn Sink>>,
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

impl Limits {
    /// Those of events themselves.
    pub(super) const WIDE: Self = Self {
        x: u16::MAX,
        y: u16::MAX,
        t: i64::MAX.unsigned_abs(),
        silence: u64::MAX,
        channels: true,
    };
}

impl Format {
    /// What `--format` calls it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.entry().name
    }

    /// The extension that its files usually have, without the dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        self.entry().extension
    }

    /// What it can hold.
    #[must_use]
    pub const fn limits(self) -> Limits {
        self.entry().limits
    }

    /// Which of the field's programs read it, for people.
    #[must_use]
    pub const fn readers(self) -> &'static str {
        self.entry().readers
    }

    /// Whether this build reads and writes it: some are features of the crate.
    #[must_use]
    pub const fn is_built(self) -> bool {
        self.entry().streams.is_some()
    }

    /// The line of Python that opens a file of this format, `path` being its path.
    #[must_use]
    pub const fn python(self) -> &'static str {
        self.entry().python
    }

    /// What [`Format::python`] needs to import.
    #[must_use]
    pub const fn module(self) -> &'static str {
        self.entry().module
    }

    /// The names of all, with a space between, as helps list them.
    #[must_use]
    pub fn names() -> String {
        let names: Vec<_> = Self::ALL.iter().map(|format| format.name()).collect();
        names.join(" ")
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
    let mut all = Format::ALL.iter().copied();
    let begins = |format: &Format| match format.entry().sign {
        Sign::Bytes(magic) => start.starts_with(magic),
        Sign::Nothing | Sign::Line(_) => false,
    };
    if let Some(format) = all.find(begins) {
        return Some(format);
    }
    let mut header = start
        .split(|b| *b == b'\n')
        .take_while(|line| line.starts_with(b"%"))
        .map(|line| String::from_utf8_lossy(line).to_ascii_lowercase());
    // The first line that says a format decides.
    header.find_map(|line| {
        let words: Vec<_> = line
            .trim_start_matches('%')
            .split([' ', ';', '\r'])
            .filter(|word| !word.is_empty())
            .collect();
        let says = |format: &Format| match format.entry().sign {
            Sign::Line(says) => says(&words),
            Sign::Nothing | Sign::Bytes(_) => false,
        };
        Format::ALL.iter().copied().find(says)
    })
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
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
