//! AEDAT 2.0 as jAER writes it for DAVIS and DVS128 sensors: 64 bits an event, big-endian,
//! `dv.LegacyAedatFile(path)`.
//!
//! `#!AER-DAT2.0` and comments, then for each event an address (bit 31 set for frames and
//! motion; y in 30 to 22, x in 21 to 12, the sign in 11, bit 10 set for what comes from
//! outside) and the time in 32 bits, which readers take with a sign: 35 minutes. Coordinates
//! are written and read as they are; jAER itself counts rows from the bottom and columns from the
//! right, and so does v2e, which writes for it.
//! Readers take every line that starts with `#` for a comment, so a first event whose bytes
//! start like that is led by an empty frame sample. Source:
//! <https://docs.inivation.com/software/software-advanced-usage/file-formats/aedat-2.0.html>.
//!
//! A header whose `AEChip` is a DVS128 (or its forerunner, Tmpdiff128) says other addresses: y in
//! 14 to 8, x in 7 to 1, bit 0 set for OFF, bits 15 and 31 set for what comes from outside. Source:
//! the class of that name in jAER. Such files are read, not written.

use std::io;

use super::{
    Fault, Format,
    about::{About, BLANK},
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    head::Head,
    header::{Header, complete},
    source::{Out, Sink, Stream, Words},
};
use crate::{
    event::{Event, Polarity},
    plane::Size,
    unit::Micros,
};

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
    readers: "dv",
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

/// What the bits of an address say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Chip {
    #[default]
    Davis,
    Dvs128,
}

impl Chip {
    /// That of a header. What other programs write has the addresses of a DAVIS, whatever name they
    /// give it.
    fn of(header: &Header) -> Self {
        let name = header.get("aechip").unwrap_or_default();
        let name = name.to_ascii_lowercase();
        if name.contains("dvs128") || name.contains("tmpdiff128") {
            Self::Dvs128
        } else {
            Self::Davis
        }
    }

    /// The event of an address; none of what no pixel made.
    fn event(self, address: u32, t: u32) -> Option<Event> {
        let (x, y, on) = match self {
            Self::Davis if address & (OTHER | SPECIAL) != 0 => return None,
            Self::Davis => (
                address >> 12 & 0x3FF,
                address >> 22 & 0x1FF,
                address >> 11 & 1 == 1,
            ),
            Self::Dvs128 if address & (OTHER | 1 << 15) != 0 => return None,
            Self::Dvs128 => (address >> 1 & 0x7F, address >> 8 & 0x7F, address & 1 == 0),
        };
        Some(Event {
            t: Micros(t.into()),
            x: x as u16,
            y: y as u16,
            polarity: Polarity::of(on),
            channel: 0,
        })
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Aedat2 {
    chip: Chip,
    /// Whether a record was read already.
    begun: bool,
    skipped: u64,
    /// What is to be known of whose it is.
    note: Option<&'static str>,
}

/// Of a file of v2e.
const OF_V2E: &str = "written by v2e for jAER, whose rows run up and whose columns are mirrored: --flip xy, with --size WxH, turns it";

/// Of a file of somebody else.
const OF_OTHERS: &str = "not written by amacrine: rows run up and columns are mirrored where jAER wrote it, and --flip xy, with --size WxH, turns it";

/// What a header says of who counted rows and columns.
fn note(header: &Header) -> Option<&'static str> {
    let names_v2e = |(key, value): &(String, String)| key == "v2e" || value.contains("v2e");
    match header.ours {
        true => None,
        false if header.lines.iter().any(names_v2e) => Some(OF_V2E),
        false => Some(OF_OTHERS),
    }
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Aedat2>, Stop> {
    super::aedat3::magic(&mut chunks, MAGIC, Format::Aedat2)?;
    let mut header = Header::read(&mut chunks, Format::Aedat2, b'#', "")?;
    let chip = Chip::of(&header);
    if chip == Chip::Dvs128 {
        header.about.size = header.about.size.or(Some(Size::new(128, 128)));
    }
    let words = Aedat2 {
        chip,
        note: note(&header),
        ..Aedat2::default()
    };
    Ok(Stream::new(chunks, words, header.about))
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
            match self.chip.event(address, t) {
                Some(event) => events.push(event),
                None => self.skipped += u64::from(!leader),
            }
        }
        Ok(words.len() * 8)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }

    fn note(&self) -> Option<&'static str> {
        self.note
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
