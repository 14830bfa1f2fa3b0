//! The entry of a format in the list of formats: what is said of it, and its reader and writer.

use std::{fmt, io, path::Path};

use super::{
    chunks::Chunks,
    fault::{FileError, Stop},
    format::{Format, formats},
    head::{Compression, Head},
    origin::Origin,
    source::{Sink, Source},
};

/// The entry of a format; each format's file has one.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a statement of its own"
)]
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
    /// How the start of a file shows that it is of this format.
    pub sign: Sign,
    /// Readers and writers, unless this build has none.
    pub streams: Option<Streams>,
    /// Whether the writer goes back to the start at the end, to fill in how many events there are.
    pub rewinds: bool,
    /// Whether the sensor's size is written in few bits, which limits it.
    pub few_bits_of_size: bool,
    /// Whether it has room for what a packet knows of itself: the time watched, drops, names.
    pub remarks: bool,
    /// Whether its packets may be compressed as is asked for.
    pub compresses: bool,
    /// Whether silences are counted from the first event on, not from time 0.
    pub clock_from_first: bool,
    /// Whether where its parts lie is said at the end, so that a file cut short is lost whole.
    pub index_at_end: bool,
}

impl Entry {
    /// The values that most formats share.
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
        remarks: true,
        compresses: false,
        clock_from_first: false,
        index_at_end: false,
    };
}

/// How a format is recognised by the start of a file.
#[derive(Clone, Copy)]
pub(super) enum Sign {
    /// Nothing.
    Nothing,
    /// It begins with these bytes.
    Bytes(&'static [u8]),
    /// It is a zip archive whose first member has this extension.
    Archive(&'static str),
    /// A line of its header, which is of lines that begin with `%`, has these words, in lower
    /// case.
    Line(fn(&[&str]) -> bool),
    /// A line of such a header names it as the encoding.
    Encoding,
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
    /// Longest time without an event, in microseconds, time 0 to the first event included.
    pub silence: u64,
    /// Whether it tells kinds of cells apart.
    pub channels: bool,
}

impl Limits {
    /// The limits of [`Event`](crate::event::Event) itself.
    pub(super) const WIDE: Self = Self {
        x: u16::MAX,
        y: u16::MAX,
        t: i64::MAX.unsigned_abs(),
        silence: u64::MAX,
        channels: true,
    };
}

/// Gives each format of the list its entry.
macro_rules! entries {
    ($(#[doc = $about:literal] $format:ident => $file:ident,)+) => {
        impl Format {
            pub(super) const fn entry(self) -> &'static Entry {
                match self {
                    $(Self::$format => &super::$file::ENTRY,)+
                }
            }
        }
    };
}

formats!(entries);

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

    /// Refuses a compression that was asked for of a format that is written in one way.
    ///
    /// # Errors
    /// [`FileError::OneWay`].
    pub fn check_compression(self, path: &Path, compression: Compression) -> Result<(), FileError> {
        if self.entry().compresses {
            return Ok(());
        }
        Err(FileError::OneWay {
            path: path.to_owned(),
            format: self,
            compression,
        })
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

    /// Whether it keeps the time watched, the drops and the names of kinds.
    #[must_use]
    pub const fn has_remarks(self) -> bool {
        self.entry().remarks
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
        let line = self.python().replace("(path", &format!("('{name}'"));
        format!("import {}; events = {line}", self.module())
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
