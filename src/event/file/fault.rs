//! Errors of event files: what is wrong, and where.

use std::{
    fmt, io,
    path::{Path, PathBuf},
};

use super::{Format, head::Compression};
use crate::{plane::Size, save::SaveError};

/// An event file could not be read or written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FileError {
    /// The extension names no format.
    #[error("{}: `{extension}` is not a known kind of event file; known are {}", path.display(), known())]
    #[diagnostic(help(
        "{}",
        if path.as_os_str() == "-" {
            "an event file is read by its name: write it to a file first, or give /dev/stdin where the bytes say what they are"
        } else if extension.eq_ignore_ascii_case("mcap") {
            "recordings for viewers are written by `amacrine show EVENTS -o NAME.mcap --window 20ms`, and none is read"
        } else if *written {
            "give a name that ends in one of these, or tell `amacrine convert` what it writes: --format NAME"
        } else if is_stream(path) {
            "the first bytes of the stream name no format: write it to a file first, whose name ends in one of these"
        } else {
            "rename the file so that its extension says what is in it, or tell `amacrine convert` what it reads: --from NAME"
        }
    ))]
    Extension {
        /// The file.
        path: PathBuf,
        /// What it ends in.
        extension: String,
        /// Whether it is to be written.
        written: bool,
    },
    /// Several formats share the extension.
    #[error("{}: `.{extension}` files come in several formats: {names}", path.display())]
    #[diagnostic(help(
        "end the name in one of these, such as `.{}`; `amacrine convert` also takes --format",
        names.split(", ").next().unwrap_or_default()
    ))]
    Ambiguous {
        /// The file.
        path: PathBuf,
        /// What it ends in.
        extension: String,
        /// The formats.
        names: String,
    },
    /// Neither the extension nor the first bytes name a format.
    #[error("{}: neither the extension nor the first bytes say what kind of event file this is", path.display())]
    #[diagnostic(help("say which with `amacrine convert --from NAME`"))]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// The format needs a feature that this program was built without.
    #[error("{}: this amacrine was built without {format}", path.display())]
    #[diagnostic(help("build it with `--features {format}`"))]
    NotBuilt {
        /// The file.
        path: PathBuf,
        /// Which format, and feature.
        format: Format,
    },
    /// The file cannot be opened or read.
    #[error("{}: {cause}", path.display())]
    #[diagnostic(help("give a file that exists and can be read"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        cause: io::Error,
    },
    /// A compression was asked for of a format that has none to choose.
    #[error("{}: compression {} was asked for, but {format} has no choice of compression", path.display(), compression.name())]
    #[diagnostic(help("leave the compression out (--compression), or write .aedat4"))]
    OneWay {
        /// The file.
        path: PathBuf,
        /// Which format.
        format: Format,
        /// What was asked for.
        compression: Compression,
    },
    /// A size was given for a file that says another.
    #[error("{}: the file states the sensor size {said}, but {asked} was given", path.display())]
    #[diagnostic(help("leave the size out (--size): it is for files that state none"))]
    OtherSize {
        /// The file.
        path: PathBuf,
        /// The size in the file.
        said: Size,
        /// The size that was given.
        asked: Size,
    },
    /// A stream of events was asked for of a file that has no such stream.
    #[error("{}: it has no stream of events of number {stream}", path.display())]
    #[diagnostic(help("{}", streams(known)))]
    NoStream {
        /// The file.
        path: PathBuf,
        /// The number that was asked for.
        stream: i32,
        /// Those that there are.
        known: Vec<i32>,
    },
    /// The file is not what its format says.
    #[error("{}:{place}: {fault}", path.display())]
    #[diagnostic(help("{}{}", fault.help(), if *opened { fault.kept() } else { "" }))]
    Bad {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong.
        fault: Fault,
        /// Whether what stands before the events was read: then those before the damage can be
        /// kept.
        opened: bool,
    },
    /// The format cannot hold this packet.
    #[error("cannot write {}: event {event}: {fault}", path.display())]
    #[diagnostic(help("{}", fault.help()))]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Number of the event, from 0.
        event: u64,
        /// What is wrong.
        fault: Fault,
    },
    /// The file cannot be saved.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Save(#[from] SaveError),
}

/// Which streams may be asked for.
fn streams(known: &[i32]) -> String {
    if known.is_empty() {
        return "leave the number out (--stream): it is for aedat4 and hdf5 files of several cameras"
            .into();
    }
    let known: Vec<_> = known.iter().map(i32::to_string).collect();
    format!("give one of those that there are: {}", known.join(", "))
}

/// The list of known extensions, for messages.
fn known() -> String {
    let names: Vec<_> = Format::ALL.iter().map(|format| format.name()).collect();
    names.join(", ")
}

/// Whether this is a pipe or a device, which has no name of its own.
fn is_stream(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|it| !it.is_file() && !it.is_dir())
}

/// A place in an event file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a text file, both from 1; the column counts bytes.
    Line {
        /// Line.
        line: u64,
        /// Column.
        column: u64,
    },
    /// In a binary file, from 0.
    Byte(u64),
    /// An event, from 0, where columns lie apart.
    Event(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line { line, column } => write!(f, "{line}:{column}"),
            Self::Byte(at) => write!(f, " byte {at}"),
            Self::Event(number) => write!(f, " event {number}"),
        }
    }
}

/// What is wrong at a place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// No header, or not the one of an event file.
    #[error("expected the header `t,x,y,p` (in any order, and perhaps `channel`), {why}")]
    Header {
        /// What is there instead.
        why: String,
        /// What to do about it.
        way: &'static str,
    },
    /// A line with too few or too many fields.
    #[error("expected {want} fields, found {got}")]
    Fields {
        /// How many there should be.
        want: usize,
        /// How many there are.
        got: usize,
    },
    /// Text of events in seconds that begins with the size of the sensor.
    #[error("the first line has two numbers, like the sensor size in a file for E2VID")]
    Size,
    /// The first line of a file for E2VID, which is not the size of the sensor.
    #[error("expected `width height`, the size of the sensor, found {}", crate::unit::counted(*got as u64, "field"))]
    NoSize {
        /// Fields of the line.
        got: usize,
    },
    /// A line longer than any event.
    #[error("a line of more than {limit} bytes")]
    LongLine {
        /// The longest that is read.
        limit: usize,
    },
    /// A field that is not a whole number.
    #[error("`{name}` should be a whole number (at most 19 digits), found `{found}`")]
    NotInteger {
        /// Name of the field.
        name: &'static str,
        /// What is there.
        found: String,
    },
    /// A time that is not in seconds.
    #[error("`t` should be seconds, found `{found}`")]
    NotSeconds {
        /// What is there.
        found: String,
    },
    /// A time outside of what a file can hold.
    #[error("`t` is {t} us; event times are 0 to {} us", i64::MAX)]
    Time {
        /// The time.
        t: i128,
    },
    /// Time runs backwards.
    #[error("time runs backwards: {now} us comes after {before} us")]
    Backwards {
        /// Time of the event before.
        before: u64,
        /// Time of this event.
        now: u64,
    },
    /// A polarity that is none.
    #[error("`p` should be 1 for ON, 0 or -1 for OFF, found {found}")]
    Polarity {
        /// What is there.
        found: i128,
    },
    /// A coordinate or channel that no address can hold.
    #[error("`{name}` is {value}; it should be 0 to {limit}")]
    Range {
        /// Name of the field.
        name: &'static str,
        /// Its value.
        value: i128,
        /// The largest that the format holds.
        limit: u64,
    },
    /// An event off the sensor.
    #[error("the event at x {x}, y {y} is off the sensor, which is {size}")]
    Outside {
        /// Its column.
        x: u16,
        /// Its row.
        y: u16,
        /// The sensor.
        size: Size,
    },
    /// An event of a kind that the sensor does not have.
    #[error("the event has channel {channel}, but there are only {channels}, counted from 0")]
    Channel {
        /// Its channel.
        channel: u8,
        /// How many there are.
        channels: u8,
    },
    /// More kinds of cells than the format can tell apart.
    #[error("the packet has {channels} kinds of cells, but .{format} stores no kinds")]
    NoChannels {
        /// How many.
        channels: u8,
        /// Which format.
        format: Format,
    },
    /// A sensor larger than the format can say.
    #[error("the sensor is {size}; {format} holds at most {most}")]
    Large {
        /// Its size.
        size: Size,
        /// The largest that the format holds.
        most: Size,
        /// Which format.
        format: Format,
    },
    /// A time later than the format can say.
    #[error("`t` is {t} us; {format} holds times up to {limit} us")]
    Late {
        /// The time.
        t: u64,
        /// The latest that the format holds.
        limit: u64,
        /// Which format.
        format: Format,
    },
    /// More time between events than the format can reasonably say.
    #[error("no event from {from} to {to} us; {format} stores gaps explicitly, up to {limit} us")]
    Silence {
        /// The event before, or 0.
        from: u64,
        /// This event.
        to: u64,
        /// The longest silence.
        limit: u64,
        /// Which format.
        format: Format,
    },
    /// A sensor larger than addresses reach.
    #[error("the sensor is {size}; a side is at most 65536")]
    SizeLimit {
        /// Its size.
        size: Size,
    },
    /// The `# amacrine …` comment does not say what it should.
    #[error("the comment `# amacrine …` {why}")]
    About {
        /// What is wrong with it.
        why: String,
    },
    /// The comment says one thing of the file, and the file is another.
    #[error("the comment `# amacrine …` says {stated}, but the file has {found}")]
    Remark {
        /// What the comment says.
        stated: String,
        /// What there is.
        found: String,
    },
    /// The file says the same thing twice, and not the same.
    #[error("the {format} file contradicts itself: {one}, {other}")]
    Twice {
        /// Which format.
        format: Format,
        /// What it says in one place, and where.
        one: String,
        /// What it says or has in the other.
        other: String,
    },
    /// A Prophesee file in an encoding that is not read.
    #[error("its header says the encoding {name}; read are EVT2, EVT2.1 and EVT3")]
    Encoding {
        /// What the header says.
        name: String,
    },
    /// Columns that are compressed, or laid out, in a way that is not read.
    #[error("the column `{column}` is stored in a way that is not read: {why}")]
    Compressed {
        /// Which column.
        column: String,
        /// What the reader says.
        why: String,
        /// What to do about it.
        way: &'static str,
    },
    /// An HDF5 file without one of the columns.
    #[error("the hdf5 file has no column `{column}`: {why}")]
    Column {
        /// Which column.
        column: String,
        /// What is there instead, or what the reader says.
        why: String,
    },
    /// Two streams of events, of two cameras, in one file.
    #[error(
        "the {format} file has two streams of events, {one} and {other}, which must not be mixed"
    )]
    Streams {
        /// Which format.
        format: Format,
        /// The number of the first, and where it is if the format says so by a name.
        one: String,
        /// The same of the other.
        other: String,
    },
    /// A word that the format does not have.
    #[error("a word of kind {kind}, which {format} does not have")]
    Word {
        /// Which format.
        format: Format,
        /// Its kind, the upper four bits.
        kind: u32,
    },
    /// The file is not laid out as its format asks.
    #[error("the {format} file {why}")]
    Layout {
        /// Which format.
        format: Format,
        /// What is wrong.
        why: String,
    },
    /// An NPZ file of other arrays than those of events.
    #[error("the npz file {why}")]
    Arrays {
        /// What is wrong with them.
        why: String,
    },
    /// Not an NPY file.
    #[error("this is not an NPY file: expected the bytes \\x93NUMPY, then a version, 1 to 3")]
    Magic,
    /// The header of an NPY file is not one of events.
    #[error("the NPY header {why}")]
    Npy {
        /// What is wrong with it.
        why: String,
    },
    /// The file ends too early.
    #[error("the file ends here, in the middle of {inside}")]
    Truncated {
        /// Where it ends.
        inside: String,
    },
    /// The file goes on after its end.
    #[error("the file goes on after its last event")]
    Trailing,
}

/// The longest side that formats with signed coordinates hold.
const NARROW: usize = 1 << 15;
const WIDE: &str = "write csv, npz, hdf5 or parquet, which hold sensors up to 65536x65536";

impl Fault {
    /// The field whose value is wrong, where it is one.
    pub(super) const fn field(&self) -> Option<&'static str> {
        match self {
            Self::Range { name, .. } => Some(name),
            Self::Polarity { .. } => Some("p"),
            Self::Time { .. } => Some("t"),
            _ => None,
        }
    }

    /// What a file says in one place, and what in the other.
    pub(super) fn twice(format: Format, one: impl Into<String>, other: impl Into<String>) -> Self {
        let (one, other) = (one.into(), other.into());
        Self::Twice { format, one, other }
    }

    /// What to do about it.
    #[must_use]
    pub fn help(&self) -> &'static str {
        match self {
            Self::Layout { format, .. } | Self::Twice { format, .. }
                if format.entry().index_at_end =>
            {
                "check that the extension (or `--from`) says what is in the file, and that it is complete: its index is at the end; write or copy it again"
            }
            Self::Late { .. } | Self::Silence { .. } => {
                "write aedat4, npy or csv, which hold any time; or let times begin at 0 (`convert --from-zero`), and cut what is longer (`--slice`)"
            }
            Self::Large { size, .. } if size.width.max(size.height) > NARROW => WIDE,
            Self::Large { .. } => "write aedat4, npy or csv, which hold larger sensors",
            Self::Layout { .. } | Self::Word { .. } => {
                "check that the extension (or `--from`) says what is in the file"
            }
            Self::Size => "read it with `amacrine convert --from e2vid`, or call it .e2vid",
            Self::NoSize { .. } => {
                "let the first line be the size, such as 346 260; or, without one, read it with `amacrine convert --from txt`, or call it .txt"
            }
            Self::Arrays { .. } => {
                "save t (whole microseconds), x, y and p (1 for ON, 0 for OFF), each an array with one whole number an event: np.savez('e.npz', t=t, x=x, y=y, p=p)"
            }
            Self::Encoding { .. } => {
                "write it in one of these, as Metavision's `metavision_file_to_raw` does, or as hdf5"
            }
            Self::Streams { .. } => {
                "choose one by its number: --stream N, in Python read(path, stream=N)"
            }
            Self::Column { .. } => {
                "read are the layouts of DSEC (events/{t,x,y,p}, in microseconds), event_utils (events/{xs,ys,ts,ps}), MVSEC (davis/{left,right}/events) and v2e (events, (N, 4)); docs/formats.md has a line of Python for that of Prophesee"
            }
            Self::Compressed { way, .. } | Self::Header { way, .. } => way,
            Self::Fields { .. } => {
                "write one event per line, with one field for each column, separated by commas in csv and by blanks in txt and e2vid"
            }
            Self::LongLine { .. } | Self::Magic => {
                "check that the extension says what is in the file"
            }
            Self::NotInteger { .. } => {
                "write coordinates in whole pixels, and times in whole microseconds (in txt and e2vid in seconds)"
            }
            Self::NotSeconds { .. } => {
                "write times as decimal seconds, such as 0.001250000; a first line of names has a `#` in front"
            }
            Self::Time { .. } => {
                "shift the recording so that it starts at 0 or later, in microseconds"
            }
            Self::Backwards { .. } => {
                "sort the events by time: `amacrine convert A B --sort` writes a file that is in order"
            }
            Self::Polarity { .. } => "write 1 for ON and 0 for OFF",
            Self::Range { name, value, .. } => match name.as_bytes() {
                b"channel" => "number the channels from 0",
                _ if *value < 0 || *value > 65535 => {
                    "coordinates count from 0 at the top left, to 65535 at most"
                }
                _ if *value >= NARROW as i128 => WIDE,
                _ => {
                    "coordinates count from 0 at the top left; if this one is right, another format may hold it"
                }
            },
            Self::Outside { .. } | Self::SizeLimit { .. } => {
                "correct the size, or the events that lie outside"
            }
            Self::Channel { .. } => "correct the number of channels, or the channel of the event",
            Self::NoChannels { .. } => {
                "write csv, npy, npz, hdf5 or parquet, which keep them; or one kind with `convert --kind N`, or one file a kind with `convert --each-kind`"
            }
            Self::About { .. } => {
                "it should read like `# amacrine size=346x260 channels=1 span=0..2000000 dropped=0,0`, before the first event, once; all but `amacrine` may be left out"
            }
            Self::Remark { .. } | Self::Twice { .. } => {
                "the file was cut short, damaged, or edited without updating the rest: write or copy it again"
            }
            Self::Npy { .. } => {
                "save a one-dimensional array of dtype [('t','<i8'),('x','<i2'),('y','<i2'),('p','i1')], and perhaps ('channel','u1')"
            }
            Self::Truncated { .. } => "the file was cut short: write or copy it again",
            Self::Trailing => "store one array a file",
        }
    }

    /// Whether the file is good, and in a layout or an encoding that is not read, or of several
    /// cameras, of which none was chosen.
    #[must_use]
    pub const fn is_foreign(&self) -> bool {
        matches!(
            self,
            Self::Encoding { .. }
                | Self::Compressed { .. }
                | Self::Column { .. }
                | Self::Streams { .. }
        )
    }

    /// How to keep the events before the damage, where some may be good.
    const fn kept(&self) -> &'static str {
        match self {
            Self::Layout { .. }
            | Self::Word { .. }
            | Self::Backwards { .. }
            | Self::Remark { .. }
            | Self::Twice { .. }
            | Self::Truncated { .. } => "; `convert --salvage` keeps the events before the damage",
            _ => "",
        }
    }
}

/// Why a reader stops; the name of the file is added by the caller.
#[derive(Debug)]
pub enum Stop {
    /// The system failed.
    Io(io::Error),
    /// The file is wrong.
    Fault(Place, Fault),
}

impl Stop {
    /// A file that is not laid out as its format is, from this byte on.
    pub fn layout(format: Format, byte: u64, why: impl Into<String>) -> Self {
        let why = why.into();
        Self::Fault(Place::Byte(byte), Fault::Layout { format, why })
    }

    /// A file that says two different things, found at this byte.
    pub fn twice(
        format: Format,
        byte: u64,
        one: impl Into<String>,
        other: impl Into<String>,
    ) -> Self {
        Self::Fault(Place::Byte(byte), Fault::twice(format, one, other))
    }
}

impl From<io::Error> for Stop {
    fn from(cause: io::Error) -> Self {
        Self::Io(cause)
    }
}
