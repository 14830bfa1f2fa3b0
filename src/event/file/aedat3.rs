//! AEDAT 3.1 as cAER writes it: packets of 64-bit events, `dv.LegacyAedatFile(path)`.
//!
//! A header of lines up to `#!END-HEADER`, then packets, each with 28 bytes of header (kind,
//! source, bytes of an event, place of the time in it, turns of the time, room, events, valid
//! events) and its events: a word with x (31 to 17), y (16 to 2), the sign (1) and whether it
//! is valid (0), then the time in 31 bits. Little-endian. Source:
//! <https://docs.inivation.com/software/software-advanced-usage/file-formats/aedat-3.1.html>.

use std::io;

use super::{
    Fault, Format, Place,
    about::{About, BLANK},
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    head::Head,
    header::{Header, complete},
    source::{BLOCK, Out, Sink, Source},
};
use crate::{
    event::{Event, Polarity},
    plane::Size,
    unit::Micros,
};

/// The first bytes of a file.
const MAGIC: &[u8] = b"#!AER-DAT3.1";

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "aedat3",
    extension: "aedat",
    limits: Limits {
        x: (1 << 15) - 1,
        y: (1 << 15) - 1,
        t: (1 << 62) - 1,
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

/// The type number of packets with polarity events.
const POLARITY: u16 = 1;

/// Bytes of an event.
const EVENT: usize = 8;

/// Bits of the time within an event; the packet's header has the upper bits.
const LOW: u32 = 31;

/// Checks the first line of a file.
pub fn magic(chunks: &mut Chunks, line: &[u8], format: Format) -> Result<(), Stop> {
    if chunks.ahead(line.len())?.starts_with(line) {
        return Ok(());
    }
    let why = format!(
        "does not start with `{}`",
        String::from_utf8_lossy(line).trim_end()
    );
    Err(chunks.stop(Fault::Layout { format, why }))
}

/// The packet being read.
#[derive(Clone, Copy, Debug, Default)]
struct Packet {
    /// Whether it holds polarity events.
    events: bool,
    /// Overflows of the 31-bit time.
    turns: u64,
    /// Bytes of a record.
    record: usize,
    /// Records left.
    left: u32,
    /// Bytes of room behind its records.
    unused: u64,
    /// Its place in the file, how many of its records should be valid, and how many were.
    at: u64,
    valid: (u32, u32),
}

pub(super) struct Reading {
    chunks: Chunks,
    about: About,
    packet: Packet,
    /// Places in the file of the events of the last block.
    places: Vec<u64>,
    skipped: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Reading, Stop> {
    magic(&mut chunks, MAGIC, Format::Aedat3)?;
    let header = Header::read(&mut chunks, Format::Aedat3, b'#', "!END-HEADER")?;
    // As this writes it: `Source 1: amacrine 346x260`.
    let source = header.get("source").unwrap_or_default();
    let named = source.rsplit_once(" amacrine ").map(|(_, size)| size);
    if let (Some(size), Some(named)) = (header.about.size, named)
        && named != size.to_string()
    {
        let one = format!("its remark says that the sensor is {size}");
        let other = format!("its source says {named}");
        return Err(Stop::twice(Format::Aedat3, 0, one, other));
    }
    Ok(Reading {
        chunks,
        about: header.about,
        packet: Packet::default(),
        places: Vec::new(),
        skipped: 0,
    })
}

impl Reading {
    /// Leaves bytes out, in parts: a frame may be large.
    fn pass(&mut self, bytes: u64) -> Result<(), Stop> {
        let mut rest = bytes;
        while rest > 0 {
            let here = (self.chunks.ahead(1)?.len() as u64).min(rest);
            if here == 0 {
                return Err(self.chunks.truncated("a packet".into()));
            }
            self.chunks.eat(here as usize);
            rest -= here;
        }
        Ok(())
    }

    /// The header of the next packet; false at the end of the file.
    fn next_packet(&mut self) -> Result<bool, Stop> {
        let Packet { events, valid, .. } = self.packet;
        if events && valid.0 != valid.1 {
            let one = format!("a packet says that {} of its events are valid", valid.0);
            let other = format!("{} are", valid.1);
            return Err(Stop::twice(Format::Aedat3, self.packet.at, one, other));
        }
        self.pass(self.packet.unused)?;
        if self.chunks.ahead(1)?.is_empty() {
            return Ok(false);
        }
        let at = self.chunks.at();
        let header: [u8; 28] = self.chunks.take("the header of a packet")?;
        let (fields, _) = header[4..].as_chunks();
        let [size, offset, turns, room, number, valid] =
            std::array::from_fn(|i| fields.get(i).map_or(0, |f| u32::from_le_bytes(*f)));
        let wrong = |why| {
            let format = Format::Aedat3;
            Err(Stop::Fault(Place::Byte(at), Fault::Layout { format, why }))
        };
        let events = u16::from_le_bytes([header[0], header[1]]) == POLARITY;
        if events && (size as usize != EVENT || offset != 4) {
            return wrong(format!(
                "has a packet of events of {size} bytes, the time at byte {offset}; they have 8, the time at byte 4"
            ));
        }
        if number > room {
            let one = format!("a packet says that it has room for {room} records");
            let other = format!("it says that it has {number}");
            return Err(Stop::twice(Format::Aedat3, at, one, other));
        }
        if size == 0 || size > 1 << 26 || valid > number || turns > i32::MAX as u32 {
            return wrong(format!(
                "has a packet with {valid} of {number} records valid, {size} bytes each, after {turns} turns of the clock"
            ));
        }
        self.packet = Packet {
            events,
            turns: turns.into(),
            record: size as usize,
            left: number,
            unused: u64::from(room - number) * u64::from(size),
            at,
            valid: (valid, 0),
        };
        Ok(true)
    }
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about.clone()
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        self.places.clear();
        while events.len() < BLOCK {
            if self.packet.left == 0 {
                if !self.next_packet()? {
                    return Ok(!events.is_empty());
                }
                continue;
            }
            let Packet { record, turns, .. } = self.packet;
            if !self.packet.events {
                self.pass(record as u64)?;
                self.skipped += 1;
                self.packet.left -= 1;
                continue;
            }
            let want = EVENT * (self.packet.left as usize).min(BLOCK - events.len());
            let from = self.chunks.at();
            let here = self.chunks.ahead(EVENT)?;
            let (words, _) = here[..here.len().min(want)].as_chunks();
            let before = events.len();
            for (i, word) in words.iter().enumerate() {
                let word = u64::from_le_bytes(*word);
                let (address, low) = (word as u32, (word >> 32) as u32);
                if address & 1 == 0 {
                    self.skipped += 1;
                    continue;
                }
                events.push(Event {
                    t: Micros(turns << LOW | u64::from(low & i32::MAX as u32)),
                    x: (address >> 17) as u16,
                    y: (address >> 2 & 0x7FFF) as u16,
                    polarity: Polarity::of(address >> 1 & 1 == 1),
                    channel: 0,
                });
                self.places.push(from + (i * EVENT) as u64);
            }
            let read = words.len();
            if read == 0 {
                return Err(self.chunks.truncated("an event".into()));
            }
            self.chunks.eat(read * EVENT);
            self.packet.left -= read as u32;
            self.packet.valid.1 += (events.len() - before) as u32;
        }
        Ok(true)
    }

    fn place(&self, event: usize) -> Place {
        Place::Byte(self.places.get(event).copied().unwrap_or(self.chunks.at()))
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    let Size { height, width } = head.size;
    Writing {
        header: format!(
            "#!AER-DAT3.1\r\n#Format: RAW\r\n#Source 1: amacrine {width}x{height}\r\n\
             #Start-Time: 1970-01-01 00:00:00 (TZ+0000)\r\n# {}{BLANK}\r\n#!END-HEADER\r\n",
            head.about()
        ),
        bytes: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    header: String,
    bytes: Vec<u8>,
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(self.header.as_bytes())
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.bytes.clear();
        // All events of a packet must share the overflow count of its header.
        for part in events.chunk_by(|a, b| a.t.0 >> LOW == b.t.0 >> LOW) {
            let number = part.len() as u32;
            let turns = part.first().map_or(0, |e| (e.t.0 >> LOW) as u32);
            self.bytes.extend_from_slice(&POLARITY.to_le_bytes());
            self.bytes.extend_from_slice(&1_u16.to_le_bytes());
            for field in [EVENT as u32, 4, turns, number, number, number] {
                self.bytes.extend_from_slice(&field.to_le_bytes());
            }
            for e in part {
                let sign = u32::from(e.polarity.bit()) << 1;
                let address = u32::from(e.x) << 17 | u32::from(e.y) << 2 | sign | 1;
                let low = e.t.0 as u32 & i32::MAX as u32;
                let word = u64::from(low) << 32 | u64::from(address);
                self.bytes.extend_from_slice(&word.to_le_bytes());
            }
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        complete(out, self.header.as_bytes(), about)
    }
}
