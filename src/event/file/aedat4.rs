//! AEDAT 4.0 as DV writes it: compressed packets,
//! `[p['events'] for p in aedat.Decoder(path) if 'events' in p]`.
//!
//! `#!AER-DAT4.0`, a header (how packets are compressed, where the table of packets is, and
//! XML that describes the streams), then packets: number of the stream, bytes, and a
//! `FlatBuffer`, compressed; an event has 16 bytes, t in 64 bits, x and y in 16 with a sign,
//! and the sign of the event. At the end the table of packets, so that players can seek.
//! Source: <https://docs.inivation.com/software/software-advanced-usage/file-formats/aedat-4.0.html>
//! and the schemata at <https://gitlab.com/inivation/dv/dv-core>.

use std::io::{self, Read, SeekFrom};

use lz4_flex::frame::{FrameDecoder, FrameEncoder, FrameInfo};

use super::{
    Format, Place,
    about::About,
    aedat3::magic,
    chunks::Chunks,
    evt2::polarity,
    fault::Stop,
    flat::{Builder, Table, identifier},
    gate::Raw,
    source::{BLOCK, Out, Sink, Source},
    writer::{Compression, Head},
};
use crate::{event::Event, plane::Size};

const MAGIC: &[u8] = b"#!AER-DAT4.0\r\n";

/// Bytes of an event.
const EVENT: usize = 16;

/// No packet or header is longer, compressed or not.
const LONGEST: usize = 1 << 26;

pub(super) struct Reading {
    chunks: Chunks,
    about: About,
    compression: i32,
    /// Where the table of packets starts; before, there are packets.
    end: Option<u64>,
    /// The stream of the events.
    stream: Option<i32>,
    /// The packet being read, where it is, and how much of it has been read.
    packet: Vec<u8>,
    at: u64,
    next: usize,
    /// Where the events of the packet start, and the first of the last block.
    start: usize,
    first: usize,
    skipped: u64,
}

fn wrong(at: u64, why: impl Into<String>) -> Stop {
    Stop::layout(Format::Aedat4, at, why)
}

/// Reads the events.
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
    let about = describe(&String::from_utf8_lossy(xml)).map_err(|why| wrong(at, why))?;
    Ok(Reading {
        chunks,
        about,
        compression,
        end: u64::try_from(end).ok().filter(|end| *end > 0),
        stream: None,
        packet: Vec::new(),
        at,
        next: 0,
        start: 0,
        first: 0,
        skipped: 0,
    })
}

/// What the XML of the header says of the first stream of events.
fn describe(xml: &str) -> Result<About, String> {
    let document = match roxmltree::Document::parse(xml.trim_end_matches('\0').trim()) {
        Ok(document) => document,
        Err(e) => {
            return Err(format!(
                "describes its streams in XML that cannot be read: {e}"
            ));
        }
    };
    let value = |node: roxmltree::Node<'_, '_>, key: &str| {
        let mut children = node.children();
        let child = children.find(|c| c.attribute("key") == Some(key))?;
        child.text().map(str::to_owned)
    };
    let stream = document
        .descendants()
        .find(|node| value(*node, "typeIdentifier").as_deref() == Some("EVTS"));
    let mut about = About::NOTHING;
    let Some(info) = stream.and_then(|stream| {
        let mut children = stream.children();
        children.find(|c| c.attribute("name") == Some("info"))
    }) else {
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
    if let Some(comment) = value(info, "amacrine") {
        let ours = About::parse(&comment).map_err(|e| e.to_string())?;
        about = ours.unwrap_or(about);
    }
    Ok(about)
}

impl Reading {
    /// The next packet with events; false at the end.
    fn next_packet(&mut self) -> Result<bool, Stop> {
        loop {
            let at = self.chunks.at();
            if self.end.is_some_and(|end| at >= end) || self.chunks.ahead(1)?.is_empty() {
                return Ok(false);
            }
            let header: [u8; 8] = self.chunks.take("the header of a packet")?;
            let [s0, s1, s2, s3, b0, b1, b2, b3] = header;
            let stream = i32::from_le_bytes([s0, s1, s2, s3]);
            let length = u32::from_le_bytes([b0, b1, b2, b3]) as usize;
            if length > LONGEST {
                return Err(wrong(at, format!("has a packet of {length} bytes")));
            }
            let block = self.chunks.block(length, "a packet")?;
            let packet = inflate(self.compression, block).map_err(|why| wrong(at, why))?;
            // Without the size in front, which says it again.
            let body = packet.get(4..).unwrap_or(&[]);
            if identifier(body) != Some(*b"EVTS") {
                self.skipped += 1;
                continue;
            }
            if *self.stream.get_or_insert(stream) != stream {
                return Err(wrong(at, "has two streams of events, which would be mixed"));
            }
            let events = Table::root(body).and_then(|table| table.vector(0, EVENT));
            let Some((events, start)) = events else {
                return Err(wrong(at, "has a packet that cannot be read"));
            };
            self.packet = events.to_vec();
            (self.at, self.start, self.next) = (at, start + 4, 0);
            if !self.packet.is_empty() {
                return Ok(true);
            }
        }
    }
}

/// A packet as it was before it was compressed.
fn inflate(compression: i32, block: Vec<u8>) -> Result<Vec<u8>, String> {
    let mut packet = Vec::new();
    let read = match compression {
        0 => return Ok(block),
        1 | 2 => FrameDecoder::new(&block[..])
            .take(LONGEST as u64 + 1)
            .read_to_end(&mut packet),
        _ => zstd::stream::read::Decoder::with_buffer(&block[..])
            .and_then(|decoder| decoder.take(LONGEST as u64 + 1).read_to_end(&mut packet)),
    };
    match read {
        Ok(bytes) if bytes > LONGEST => Err("has a packet that is too long".into()),
        Ok(_) => Ok(packet),
        Err(e) => Err(format!("has a packet that cannot be decompressed: {e}")),
    }
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        if self.next >= self.packet.len() && !self.next_packet()? {
            return Ok(false);
        }
        self.first = self.next;
        let (records, _) = self.packet[self.next..].as_chunks::<EVENT>();
        for record in records.iter().take(BLOCK) {
            let word = u128::from_le_bytes(*record);
            let raw = Raw {
                t: i128::from(word as i64),
                x: i128::from((word >> 64) as i16),
                y: i128::from((word >> 80) as i16),
                p: 0,
                channel: 0,
            };
            let mut event = raw
                .event()
                .map_err(|fault| Stop::Fault(self.place(events.len()), fault))?;
            event.polarity = polarity(word >> 96 & 0xFF != 0);
            events.push(event);
            self.next += EVENT;
        }
        Ok(true)
    }

    fn place(&self, event: usize) -> Place {
        if self.compression == 0 {
            let inside = self.start + self.first + event * EVENT;
            return Place::Byte(self.at + 8 + inside as u64);
        }
        // No byte of a compressed packet is that of an event.
        Place::Byte(self.at)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// Writes the events.
pub(super) fn sink(head: &Head, compression: Compression) -> Writing {
    Writing {
        head: *head,
        compression,
        table: Vec::new(),
        at: 0,
        position: 0,
        rest: Vec::new(),
    }
}

/// A row of the table of packets.
#[derive(Clone, Copy, Debug)]
struct Row {
    at: u64,
    bytes: u32,
    events: u64,
    from: u64,
    to: u64,
}

#[derive(Debug)]
pub(super) struct Writing {
    head: Head,
    compression: Compression,
    table: Vec<Row>,
    /// Bytes so far.
    at: u64,
    /// Where the header says where the table is.
    position: u64,
    /// Events that do not fill a packet yet.
    rest: Vec<Event>,
}

impl Writing {
    fn deflate(&self, bytes: Vec<u8>) -> io::Result<Vec<u8>> {
        match self.compression {
            Compression::None => Ok(bytes),
            Compression::Lz4 => {
                // With a check sum: damage is seen.
                let info = FrameInfo::new().content_checksum(true);
                let mut encoder = FrameEncoder::with_frame_info(info, Vec::new());
                io::Write::write_all(&mut encoder, &bytes)?;
                encoder.finish().map_err(io::Error::other)
            }
            Compression::Zstd => {
                let mut compressor = zstd::bulk::Compressor::new(1)?;
                compressor.include_checksum(true)?;
                compressor.compress(&bytes)
            }
        }
    }

    fn packet(&mut self, out: &mut dyn Out) -> io::Result<()> {
        let (Some(first), Some(last)) = (self.rest.first(), self.rest.last()) else {
            return Ok(());
        };
        // A table of one field, the vector, right behind it.
        let mut builder = Builder::new(*b"EVTS", 8, &[4]);
        let bytes = &mut builder.bytes;
        bytes.reserve(self.rest.len() * EVENT + 8);
        bytes.extend(4_u32.to_le_bytes());
        bytes.extend((self.rest.len() as u32).to_le_bytes());
        for e in &self.rest {
            let word = u128::from(e.t.0)
                | u128::from(e.x) << 64
                | u128::from(e.y) << 80
                | u128::from(e.polarity.bit()) << 96;
            bytes.extend(word.to_le_bytes());
        }
        let row = Row {
            at: self.at + 8,
            bytes: 0,
            events: self.rest.len() as u64,
            from: first.t.0,
            to: last.t.0,
        };
        let packet = self.deflate(builder.finish())?;
        let length = u32::try_from(packet.len()).map_err(io::Error::other)?;
        out.write_all(&0_i32.to_le_bytes())?;
        out.write_all(&length.to_le_bytes())?;
        out.write_all(&packet)?;
        self.at += 8 + packet.len() as u64;
        self.table.push(Row {
            bytes: length,
            ..row
        });
        self.rest.clear();
        Ok(())
    }

    /// The XML that describes the one stream.
    fn description(&self) -> String {
        let Size { height, width } = self.head.size;
        let compression = match self.compression {
            Compression::Lz4 => "LZ4",
            Compression::Zstd => "ZSTD",
            Compression::None => "NONE",
        };
        format!(
            r#"<dv version="2.0">
    <node name="outInfo" path="/mainloop/Recorder/outInfo/">
        <node name="0" path="/mainloop/Recorder/outInfo/0/">
            <attr key="compression" type="string">{compression}</attr>
            <attr key="originalModuleName" type="string">amacrine</attr>
            <attr key="originalOutputName" type="string">events</attr>
            <attr key="typeDescription" type="string">Array of events (polarity ON/OFF).</attr>
            <attr key="typeIdentifier" type="string">EVTS</attr>
            <node name="info" path="/mainloop/Recorder/outInfo/0/info/">
                <attr key="amacrine" type="string">{}</attr>
                <attr key="sizeX" type="int">{width}</attr>
                <attr key="sizeY" type="int">{height}</attr>
                <attr key="source" type="string">amacrine</attr>
            </node>
        </node>
    </node>
</dv>
"#,
            self.head.about()
        )
    }
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        let number = match self.compression {
            Compression::None => 0_i32,
            Compression::Lz4 => 1,
            Compression::Zstd => 3,
        };
        // Fields: compression, place of the table, description.
        let mut builder = Builder::new(*b"IOHE", 20, &[12, 4, 16]);
        let position = builder.bytes.len();
        let text = self.description();
        builder.bytes.extend((-1_i64).to_le_bytes());
        builder.bytes.extend(number.to_le_bytes());
        builder.bytes.extend(4_u32.to_le_bytes());
        builder.bytes.extend((text.len() as u32).to_le_bytes());
        builder.bytes.extend(text.as_bytes());
        // A text ends in a zero, and the buffer at a multiple of 8.
        builder.bytes.push(0);
        while !(builder.bytes.len() + 4).is_multiple_of(8) {
            builder.bytes.push(0);
        }
        let header = builder.finish();
        out.write_all(MAGIC)?;
        out.write_all(&header)?;
        self.position = (MAGIC.len() + 4 + position) as u64;
        self.at = (MAGIC.len() + header.len()) as u64;
        Ok(())
    }

    fn put(&mut self, out: &mut dyn Out, mut events: &[Event]) -> io::Result<()> {
        while !events.is_empty() {
            let room = BLOCK - self.rest.len();
            let (now, later) = events.split_at(room.min(events.len()));
            self.rest.extend_from_slice(now);
            events = later;
            if self.rest.len() == BLOCK {
                self.packet(out)?;
            }
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut dyn Out) -> io::Result<()> {
        self.packet(out)?;
        let table = self.deflate(table(&self.table))?;
        out.write_all(&table)?;
        out.seek(SeekFrom::Start(self.position))?;
        out.write_all(&self.at.to_le_bytes())?;
        out.seek(SeekFrom::End(0))?;
        Ok(())
    }
}

/// The table of packets: a vector of offsets to tables of one shape.
fn table(rows: &[Row]) -> Vec<u8> {
    /// Bytes of a row's table; its fields follow its offset to the table of fields.
    const ROW: usize = 44;
    let mut builder = Builder::new(*b"FTAB", 8, &[4]);
    let bytes = &mut builder.bytes;
    bytes.extend(4_u32.to_le_bytes());
    bytes.extend((rows.len() as u32).to_le_bytes());
    let offsets = bytes.len();
    // One table of fields for all: place, packet (stream and bytes), events, first, last.
    let mut fields = offsets + 4 * rows.len();
    while !(fields + 14).is_multiple_of(8) {
        fields += 1;
    }
    let first = fields + 14;
    // Rows of 44 bytes at multiples of 8.
    let stride = ROW + 4;
    for i in 0..rows.len() {
        let from = offsets + 4 * i;
        bytes.extend(((first + i * stride - from) as u32).to_le_bytes());
    }
    bytes.resize(fields, 0);
    for field in [14_u16, ROW as u16, 4, 36, 12, 20, 28] {
        bytes.extend(field.to_le_bytes());
    }
    for row in rows {
        bytes.extend(((bytes.len() - fields) as u32).to_le_bytes());
        for number in [row.at, row.events, row.from, row.to] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(0_i32.to_le_bytes());
        bytes.extend(row.bytes.to_le_bytes());
        bytes.extend([0; 4]);
    }
    builder.finish()
}
