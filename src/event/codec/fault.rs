//! Errors of coded events: what is wrong, and where.

use crate::plane::Size;

/// Events could not be written or read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum CodecError {
    /// An event that the sensor does not have.
    #[error(
        "event {event}: x {x}, y {y}, channel {channel} on a sensor of {size} with {}",
        crate::unit::counted(*channels, "channel")
    )]
    #[diagnostic(help("give the packet the size and the channels that its events have"))]
    Cell {
        /// Number of the event, from 0.
        event: usize,
        /// Column.
        x: u16,
        /// Row.
        y: u16,
        /// Kind.
        channel: u8,
        /// The sensor's size.
        size: Size,
        /// The sensor's kinds.
        channels: u8,
    },
    /// A kind that has no word.
    #[error("event {event}: the code book has no word for channel {channel}")]
    #[diagnostic(help("make the book from frequencies in which this channel is not 0"))]
    NoCode {
        /// Number of the event, from 0.
        event: usize,
        /// Its kind.
        channel: u8,
    },
    /// More or fewer bytes than the bits ask for.
    #[error("{} are {}; there are {found}", crate::unit::counted(*bits, "bit"), crate::unit::counted(*want, "byte"))]
    #[diagnostic(help("pass on the bytes as they were written"))]
    Bytes {
        /// Bits that there should be.
        bits: u64,
        /// Bytes that hold them.
        want: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// The words end early.
    #[error("bit {bit}: the words end at bit {end}, within event {event}, before its {field}")]
    #[diagnostic(help("the end is missing, or these are not words of this sensor and coding"))]
    Truncated {
        /// Where the field should begin.
        bit: u64,
        /// Where the words end.
        end: u64,
        /// Which field.
        field: &'static str,
        /// Number of the event, from 0.
        event: usize,
    },
    /// A field with a value that the sensor does not have.
    #[error("bit {bit}: {field} {value}, of a sensor that has {limit}")]
    #[diagnostic(help("the words are damaged, or not of this sensor and coding"))]
    Outside {
        /// Where the field begins.
        bit: u64,
        /// Which field.
        field: &'static str,
        /// What it holds.
        value: u32,
        /// How many values there are.
        limit: usize,
    },
    /// A burst does not begin with its row.
    #[error("bit 0: the words begin with a column, before any row")]
    #[diagnostic(help("the beginning is missing, or these are not bursts"))]
    NoRow,
    /// A row without columns.
    #[error("bit {bit}: a second row where the first has no column yet")]
    #[diagnostic(help("the words are damaged, or these are not bursts"))]
    EmptyRow {
        /// Where the second begins.
        bit: u64,
    },
    /// More words than events.
    #[error("bit {bit}: all events are read, and {left} bits are left")]
    #[diagnostic(help("the arrival times are of fewer events than the words"))]
    Left {
        /// Where the rest begins.
        bit: u64,
        /// How much it is.
        left: u64,
    },
    /// The last byte is not filled up with zeros.
    #[error("byte {byte}: the bits behind the last word are not zero")]
    #[diagnostic(help("the words are damaged"))]
    Padding {
        /// The last byte, from 0.
        byte: u64,
    },
    /// The code book is not one.
    #[error("code book, byte {byte}: {fault}")]
    #[diagnostic(help("the book is damaged, or there is none: ask for it again from the sender"))]
    Book {
        /// Where in the book, from 0.
        byte: usize,
        /// What is wrong.
        fault: BookFault,
    },
}

/// What is wrong with a code book.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BookFault {
    /// It ends early.
    #[error("it ends here")]
    Short,
    /// It is for another sensor.
    #[error("it is for {found} kinds; the sensor has {want}")]
    Kinds {
        /// Kinds of the book.
        found: u8,
        /// Kinds of the sensor.
        want: u8,
    },
    /// A word longer than there are.
    #[error("a word of {length} bits; the longest has 127")]
    Length {
        /// Its length.
        length: u8,
    },
    /// Its words do not fill the space of words exactly (Kraft's sum is not 1).
    #[error("its words are {}", if *.over { "more than lengths like these allow" } else { "fewer than lengths like these need" })]
    Kraft {
        /// The sum is more than 1.
        over: bool,
    },
    /// It is not what was sent.
    #[error("checksum {found:08x}; the book's is {want:08x}")]
    Checksum {
        /// What stands there.
        found: u32,
        /// What the bytes before it give.
        want: u32,
    },
}
