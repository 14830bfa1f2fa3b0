//! Reading AEDAT 4.0.

use super::{
    super::{
        Fault, Format, Place,
        about::About,
        aedat3::magic,
        chunks::Chunks,
        fault::Stop,
        flat::{Table, identifier},
        gate::Raw,
        packed::{LONGEST, Unpacking},
        packets::{self, Row},
        source::{BLOCK, Source},
    },
    COMPRESSIONS, EVENT, MAGIC,
};
use crate::{
    event::{Event, Polarity},
    plane::Size,
    unit::Micros,
};

/// The signs of an event's time, column and row.
const SIGNS: u128 = 1 << 63 | 1 << 79 | 1 << 95;

pub(super) struct Reading {
    chunks: Chunks,
    about: About,
    unpacking: Unpacking,
    /// Place of the table of packets as the header states it; -1 where there is none.
    table: i64,
    /// The streams that the header describes.
    streams: Vec<Described>,
    /// The stream of the events, and whether it was chosen, so that others are left out.
    stream: Option<i32>,
    chosen: bool,
    /// The packets read so far, for comparison with the table.
    found: Vec<Row>,
    /// The first disagreement with the table, reported after all packets were read.
    damage: Option<Stop>,
    /// Whether the recording was not closed, so that it has no table.
    unclosed: bool,
    /// The packet being read, with its size in front, and the same as it stands in the file.
    packet: Vec<u8>,
    block: Vec<u8>,
    at: u64,
    /// Where its events start and end in it, the next one, and the first of the last block.
    start: usize,
    end: usize,
    next: usize,
    first: usize,
    skipped: u64,
}

fn wrong(at: u64, why: impl Into<String>) -> Stop {
    Stop::layout(Format::Aedat4, at, why)
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Reading, Stop> {
    magic(&mut chunks, MAGIC, Format::Aedat4)?;
    chunks.eat(MAGIC.len());
    let at = chunks.at();
    let length = u32::from_le_bytes(chunks.take("the length of its header")?) as usize;
    if length > LONGEST {
        return Err(wrong(at, format!("has a header of {length} bytes")));
    }
    let header = chunks.block(length, "the header")?;
    let read = || {
        let table = Table::root(&header)?;
        let (xml, _) = table.vector(2, 1)?;
        let compression = table.i32(0).unwrap_or(0);
        Some((compression, table.i64(1).unwrap_or(-1), xml))
    };
    let (compression, end, xml) =
        read().ok_or_else(|| wrong(at, "has a header that cannot be read"))?;
    if !(0..=4).contains(&compression) {
        let why = format!("is compressed in a way numbered {compression}; 0 to 4 are known");
        return Err(wrong(at, why));
    }
    let (about, streams) = describe(&String::from_utf8_lossy(xml), compression)
        .map_err(|fault| Stop::Fault(Place::Byte(at), fault))?;
    Ok(Reading {
        chunks,
        about,
        unpacking: Unpacking::new(compression),
        table: end,
        streams,
        stream: None,
        chosen: false,
        found: Vec::new(),
        damage: None,
        unclosed: false,
        packet: Vec::new(),
        block: Vec::new(),
        at,
        start: 0,
        end: 0,
        next: 0,
        first: 0,
        skipped: 0,
    })
}

/// A stream as the XML of the header describes it.
#[derive(Clone, Debug)]
struct Described {
    number: i32,
    /// Four letters, such as `EVTS`.
    kind: String,
    /// What it says of its events.
    about: About,
}

/// What the XML of the header says of its streams, and of the first one of events.
fn describe(xml: &str, compression: i32) -> Result<(About, Vec<Described>), Fault> {
    let document = roxmltree::Document::parse(xml.trim_end_matches('\0').trim());
    let document = document.map_err(|e| Fault::Layout {
        format: Format::Aedat4,
        why: format!("describes its streams in XML that cannot be read: {e}"),
    })?;
    let nodes = document.descendants();
    let typed = nodes.filter_map(|node| Some((node, value(node, "typeIdentifier")?)));
    let (mut first, mut streams) = (None, Vec::new());
    for (node, kind) in typed {
        let about = if kind == "EVTS" {
            let about = described(node, compression)?;
            first.get_or_insert_with(|| about.clone());
            about
        } else {
            About::NOTHING
        };
        if let Some(Ok(number)) = node.attribute("name").map(str::parse) {
            streams.push(Described {
                number,
                kind,
                about,
            });
        }
    }
    Ok((first.unwrap_or(About::NOTHING), streams))
}

/// The value of a key in the XML.
fn value(node: roxmltree::Node<'_, '_>, key: &str) -> Option<String> {
    let mut children = node.children();
    let child = children.find(|c| c.attribute("key") == Some(key))?;
    child.text().map(str::to_owned)
}

/// What the XML says of a stream of events.
fn described(stream: roxmltree::Node<'_, '_>, compression: i32) -> Result<About, Fault> {
    let mut about = About::NOTHING;
    let mut children = stream.children();
    let Some(info) = children.find(|c| c.attribute("name") == Some("info")) else {
        return Ok(about);
    };
    let side = |key| {
        value(info, key)?
            .trim()
            .parse::<u16>()
            .ok()
            .map(usize::from)
    };
    if let (Some(width), Some(height)) = (side("sizeX"), side("sizeY")) {
        about.size = Some(Size { height, width });
    }
    if let Some(comment) = value(info, "amacrine")
        && let Some(ours) = About::parse(&comment)?
    {
        let twice = |one, other| Err(Fault::twice(Format::Aedat4, one, other));
        if let (Some(stated), Some(other)) = (ours.size, about.size)
            && stated != other
        {
            let one = format!("its remark says that the sensor is {stated}");
            return twice(one, format!("`sizeX` and `sizeY` say {other}"));
        }
        let named = value(stream, "compression");
        let known = usize::try_from(compression).ok();
        let known = known.and_then(|number| COMPRESSIONS.get(number));
        if let (Some(named), Some(known)) = (named, known)
            && named.trim() != *known
        {
            let one = format!("its header says that packets are compressed by {known}");
            return twice(one, format!("its description says {named}"));
        }
        about = ours;
    }
    Ok(about)
}

impl Reading {
    /// Moves to the next packet with events; false at the end of the file.
    fn next_packet(&mut self) -> Result<bool, Stop> {
        let next = self.next();
        match (next, self.damage.is_some()) {
            (Ok(true), _) => Ok(true),
            (other, false) => other,
            (_, true) => self.damage.take().map_or(Ok(false), Err),
        }
    }

    fn next(&mut self) -> Result<bool, Stop> {
        loop {
            let at = self.chunks.at();
            let here = self.chunks.ahead(12)?;
            if packets::starts(here) {
                self.hold_to_table(at)?;
                return Ok(false);
            }
            if here.is_empty() {
                self.without_table(at)?;
                return Ok(false);
            }
            let table = u64::try_from(self.table).ok();
            if let Some(table) = table.filter(|table| *table <= at && self.damage.is_none()) {
                let one = format!("its header says that the table of packets is at byte {table}");
                let other = if table == at {
                    "what starts there is no table".to_owned()
                } else {
                    format!("packets go on at byte {at}")
                };
                self.damage = Some(Stop::twice(Format::Aedat4, at, one, other));
            }
            if self.packet(at)? {
                return Ok(true);
            }
        }
    }

    /// Reads a packet; returns whether it holds events.
    fn packet(&mut self, at: u64) -> Result<bool, Stop> {
        let header: [u8; 8] = self.chunks.take("the header of a packet")?;
        let [s0, s1, s2, s3, b0, b1, b2, b3] = header;
        let stream = i32::from_le_bytes([s0, s1, s2, s3]);
        let length = u32::from_le_bytes([b0, b1, b2, b3]);
        if length as usize > LONGEST {
            return Err(wrong(at, format!("has a packet of {length} bytes")));
        }
        (self.start, self.end, self.next) = (0, 0, 0);
        let into = &mut self.block;
        self.chunks.block_into(length as usize, into, "a packet")?;
        self.unpacking
            .unpack(&mut self.block, &mut self.packet)
            .map_err(|why| wrong(at, why))?;
        // Without the size in front, which says it again.
        let Some(body) = packets::whole(&self.packet) else {
            let one = "a packet says its own size".to_owned();
            let other = format!("it has {} bytes in all", self.packet.len());
            return Err(Stop::twice(Format::Aedat4, at, one, other));
        };
        let mut row = Row {
            at: at + 8,
            stream,
            bytes: length,
            events: None,
        };
        let kind = identifier(body).unwrap_or_default();
        self.hold_to_description(at, stream, kind)?;
        if kind != *b"EVTS" {
            self.found.push(row);
            self.skipped += 1;
            return Ok(false);
        }
        let one = *self.stream.get_or_insert(stream);
        if one != stream && !self.chosen {
            let fault = Fault::Streams {
                format: Format::Aedat4,
                one: one.to_string(),
                other: stream.to_string(),
            };
            return Err(Stop::Fault(Place::Byte(at), fault));
        }
        let events = Table::root(body).and_then(|table| table.vector(0, EVENT));
        let Some((events, start)) = events else {
            return Err(wrong(at, "has a packet that cannot be read"));
        };
        let (records, _) = events.as_chunks::<EVENT>();
        let time = |record: Option<&[u8; EVENT]>| {
            record.map_or(0, |record| u128::from_le_bytes(*record) as i64)
        };
        let ends = (time(records.first()), time(records.last()));
        row.events = Some((records.len() as u64, ends.0, ends.1));
        self.found.push(row);
        if one != stream {
            return Ok(false);
        }
        // Behind the size.
        self.start = start + 4;
        self.end = self.start + events.len();
        (self.at, self.next) = (at, self.start);
        Ok(self.start < self.end)
    }

    /// Checks a packet against the description of its stream in the header.
    fn hold_to_description(&self, at: u64, stream: i32, kind: [u8; 4]) -> Result<(), Stop> {
        let kind = String::from_utf8_lossy(&kind);
        let mut streams = self.streams.iter();
        let Some(described) = streams.find(|described| described.number == stream) else {
            // Of files that describe nothing, nothing is asked; nor of what is left out.
            if self.streams.is_empty() || kind != "EVTS" {
                return Ok(());
            }
            let one = "its header describes other streams";
            let other = format!("a packet of events is of stream {stream}");
            return Err(Stop::twice(Format::Aedat4, at, one, other));
        };
        // A type that is not that of events is left out whatever it is.
        if described.kind == kind || (described.kind != "EVTS" && kind != "EVTS") {
            return Ok(());
        }
        let one = format!(
            "its header says that stream {stream} is of {}",
            described.kind
        );
        let other = format!("a packet of it is of {kind}");
        Err(Stop::twice(Format::Aedat4, at, one, other))
    }

    /// Checks the table of packets against those that were read, at the end of the file.
    fn hold_to_table(&mut self, at: u64) -> Result<(), Stop> {
        let stated = match u64::try_from(self.table) {
            Ok(table) if table == at => None,
            Ok(table) => Some(format!("is at byte {table}")),
            Err(_) => Some("is not there (-1)".into()),
        };
        if let (Some(stated), None) = (stated, &self.damage) {
            let one = format!("its header says that the table of packets {stated}");
            let other = format!("it is at byte {at}");
            return Err(Stop::twice(Format::Aedat4, at, one, other));
        }
        let mut table = Vec::new();
        loop {
            let here = self.chunks.ahead(1)?;
            let eaten = here.len();
            if eaten == 0 {
                break;
            }
            table.extend_from_slice(here);
            self.chunks.eat(eaten);
            if table.len() > LONGEST {
                return Err(wrong(at, "has a table of packets that is too long"));
            }
        }
        self.unpacking
            .unpack(&mut table, &mut self.packet)
            .map_err(|_| wrong(at, "has a table of packets that cannot be decompressed"))?;
        let rows = packets::read(&self.packet)
            .ok_or_else(|| wrong(at, "has a table of packets that cannot be read"))?;
        packets::agree(&self.found, &rows).map_err(|fault| Stop::Fault(Place::Byte(at), fault))
    }

    /// Checks the end of a file without a table.
    fn without_table(&mut self, at: u64) -> Result<(), Stop> {
        if self.table == -1 {
            self.unclosed = true;
            return Ok(());
        }
        let one = format!(
            "its header says that the table of packets is at byte {}",
            self.table
        );
        let other = format!("the file ends at byte {at} without one");
        Err(Stop::twice(Format::Aedat4, at, one, other))
    }
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about.clone()
    }

    fn streams(&self) -> Vec<i32> {
        let events = self.streams.iter().filter(|it| it.kind == "EVTS");
        events.map(|it| it.number).collect()
    }

    fn choose(&mut self, stream: i32) {
        let mut streams = self.streams.iter();
        if let Some(described) = streams.find(|it| it.number == stream && it.kind == "EVTS") {
            self.about = described.about.clone();
            (self.stream, self.chosen) = (Some(stream), true);
        }
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        if self.next >= self.end && !self.next_packet()? {
            (self.start, self.end, self.next) = (0, 0, 0);
            return Ok(false);
        }
        self.first = self.next;
        let (records, _) = self.packet[self.next..self.end].as_chunks::<EVENT>();
        let records = &records[..records.len().min(BLOCK)];
        let plain = |word: u128| Event {
            t: Micros(word as u64),
            x: (word >> 64) as u16,
            y: (word >> 80) as u16,
            polarity: Polarity::of(word >> 96 & 0xFF != 0),
            channel: 0,
        };
        // Time and place have a sign, which is almost never there: all at once, and one by one
        // only where it is.
        let words = records.iter().map(|record| u128::from_le_bytes(*record));
        let signs = words.clone().fold(0, |signs, word| signs | word) & SIGNS;
        if signs == 0 {
            events.extend(words.map(plain));
        } else {
            for word in words {
                let raw = Raw {
                    t: i128::from(word as i64),
                    x: i128::from((word >> 64) as i16),
                    y: i128::from((word >> 80) as i16),
                    ..Raw::default()
                };
                raw.event()
                    .map_err(|fault| Stop::Fault(self.place(events.len()), fault))?;
                events.push(plain(word));
            }
        }
        self.next += records.len() * EVENT;
        Ok(true)
    }

    fn note(&self) -> Option<&'static str> {
        self.unclosed.then_some(
            "the recording was not closed: it has no table of packets, which would tell whether any are missing at its end",
        )
    }

    fn place(&self, event: usize) -> Place {
        if self.start == self.end {
            return Place::Byte(self.chunks.at());
        }
        if self.unpacking.is_plain() {
            let inside = self.first + event * EVENT;
            return Place::Byte(self.at + 8 + inside as u64);
        }
        // No byte of a compressed packet is that of an event.
        Place::Byte(self.at)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }
}
