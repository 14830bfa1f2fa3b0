//! AEDAT 2.0 as jAER writes it for DAVIS sensors: 64 bits an event, big-endian,
//! `dv.LegacyAedatFile(path)`.
//!
//! `#!AER-DAT2.0` and comments, then for each event an address (bit 31 set for frames and
//! motion; y in 30 to 22, x in 21 to 12, the sign in 11, bit 10 set for what comes from
//! outside) and the time in 32 bits, which readers take with a sign: 35 minutes. Coordinates
//! are written as they are; jAER itself shows rows from the bottom and mirrors columns.
//! Readers take every line that starts with `#` for a comment, so a first event whose bytes
//! start like that is led by an empty frame sample. Source:
//! <https://docs.inivation.com/software/software-advanced-usage/file-formats/aedat-2.0.html>.

use std::io;

use super::{
    Fault, Format,
    about::{About, BLANK},
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    evt2::polarity,
    fault::Stop,
    head::Head,
    header::{Header, complete},
    source::{Out, Sink, Stream, Words},
};
use crate::{event::Event, unit::Micros};

/// The first bytes of a file.
const MAGIC: &[u8] = b"#!AER-DAT2.0";

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "aedat2",
    extension: "aedat",
    // Nine bits of row, ten of column; readers take the time as 32 bits with a sign.
    limits: Limits {
        x: (1 << 10) - 1,
        y: (1 << 9) - 1,
        t: i32::MAX as u64,
        channels: false,
        ..Limits::WIDE
    },
    readers: "dv, tonic (mirrored, as jAER shows it)",
    module: "dv",
    python: "[(e.timestamp, e.x, e.y, e.polarity) for e in dv.LegacyAedatFile(path)]",
    sign: Sign::Bytes(MAGIC),
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks)?)),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    ..Entry::PLAIN
};

/// The bit that marks frames and motion samples.
const OTHER: u32 = 1 << 31;

/// The bit that marks external events, which no pixel made.
const SPECIAL: u32 = 1 << 10;

#[derive(Clone, Debug, Default)]
pub(super) struct Aedat2 {
    /// Whether a record was read already.
    begun: bool,
    skipped: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Aedat2>, Stop> {
    super::aedat3::magic(&mut chunks, MAGIC, Format::Aedat2)?;
    let header = Header::read(&mut chunks, Format::Aedat2, b'#', "")?;
    Ok(Stream::new(chunks, Aedat2::default(), header.about))
}

impl Words for Aedat2 {
    const STEP: usize = 8;

    fn read(&mut self, bytes: &[u8], events: &mut Vec<Event>) -> Result<usize, (usize, Fault)> {
        let (words, _) = bytes.as_chunks();
        events.reserve(words.len());
        for word in words {
            let word = u64::from_be_bytes(*word);
            let (address, t) = ((word >> 32) as u32, word as u32);
            // The empty frame sample at the start, which `sink` may have written.
            let leader = address == OTHER && !self.begun;
            self.begun = true;
            if address & (OTHER | SPECIAL) != 0 {
                self.skipped += u64::from(!leader);
                continue;
            }
            events.push(Event {
                t: Micros(t.into()),
                x: (address >> 12 & 0x3FF) as u16,
                y: (address >> 22 & 0x1FF) as u16,
                polarity: polarity(address >> 11 & 1 == 1),
                channel: 0,
            });
        }
        Ok(words.len() * 8)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        header: format!(
            "#!AER-DAT2.0\r\n# This is a raw AE data file - do not edit\r\n\
             # Data format is int32 address, int32 timestamp (8 bytes total), repeated for each event\r\n\
             # Timestamps tick is 1 us\r\n# {}{BLANK}\r\n",
            head.about()
        ),
        begun: false,
        bytes: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    header: String,
    begun: bool,
    bytes: Vec<u8>,
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(self.header.as_bytes())
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        let address = |e: &Event| {
            let sign = u32::from(e.polarity.bit()) << 11;
            u32::from(e.y) << 22 | u32::from(e.x) << 12 | sign
        };
        let record = |address: u32, e: &Event| {
            let t = e.t.0 as u32;
            (u64::from(address) << 32 | u64::from(t)).to_be_bytes()
        };
        if let (false, Some(first)) = (self.begun, events.first()) {
            self.begun = true;
            if address(first) >> 24 == u32::from(b'#') {
                out.write_all(&record(OTHER, first))?;
            }
        }
        self.bytes.resize(8 * events.len(), 0);
        for (bytes, e) in self.bytes.as_chunks_mut().0.iter_mut().zip(events) {
            *bytes = record(address(e), e);
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        complete(out, self.header.as_bytes(), about)
    }
}
