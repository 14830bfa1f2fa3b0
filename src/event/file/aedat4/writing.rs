//! Writing AEDAT 4.0.

use std::io::{self, SeekFrom};

use super::{
    super::{
        about::{About, BLANK},
        flat::Builder,
        head::{Compression, Head},
        header::complete,
        packed::Packing,
        packets::{self, Row},
        source::{BLOCK, Out, Sink},
    },
    COMPRESSIONS, EVENT, MAGIC,
};
use crate::{event::Event, plane::Size};

/// The number of a way of compression in the header: its place among [`COMPRESSIONS`].
const fn number(compression: Compression) -> u8 {
    match compression {
        Compression::None => 0,
        Compression::Lz4 => 1,
        Compression::Zstd => 3,
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head, compression: Compression) -> Writing {
    Writing {
        head: head.clone(),
        compression,
        packing: Packing::new(compression),
        table: Vec::new(),
        header: Vec::new(),
        at: 0,
        position: 0,
        rest: Vec::new(),
        packet: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    head: Head,
    compression: Compression,
    packing: Packing,
    table: Vec<Row>,
    /// The header, which is written again at the end.
    header: Vec<u8>,
    /// Bytes written so far.
    at: u64,
    /// Place in the header of the place of the table.
    position: u64,
    /// Events that do not fill a packet yet.
    rest: Vec<Event>,
    /// The memory of the last packet, reused because the system would clear new memory each time.
    packet: Vec<u8>,
}

impl Writing {
    fn packet(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        let (Some(first), Some(last)) = (events.first(), events.last()) else {
            return Ok(());
        };
        let ends = (first.t.0.cast_signed(), last.t.0.cast_signed());
        // A table of one field, the vector, right behind it; and the size in front.
        let mut front = Builder::new(*b"EVTS", 8, &[4]).bytes;
        front.extend(4_u32.to_le_bytes());
        front.extend((events.len() as u32).to_le_bytes());
        let bytes = &mut self.packet;
        bytes.clear();
        bytes.extend(((front.len() + events.len() * EVENT) as u32).to_le_bytes());
        bytes.extend(front);
        let from = bytes.len();
        bytes.resize(from + events.len() * EVENT, 0);
        let (records, _) = bytes[from..].as_chunks_mut::<EVENT>();
        for (record, e) in records.iter_mut().zip(events) {
            let word = u128::from(e.t.0)
                | u128::from(e.x) << 64
                | u128::from(e.y) << 80
                | u128::from(e.polarity.bit()) << 96;
            *record = word.to_le_bytes();
        }
        let packet = self.packing.pack(&self.packet)?;
        let length = u32::try_from(packet.len()).map_err(io::Error::other)?;
        out.write_all(&0_i32.to_le_bytes())?;
        out.write_all(&length.to_le_bytes())?;
        out.write_all(packet)?;
        self.table.push(Row {
            at: self.at + 8,
            stream: 0,
            bytes: length,
            events: Some((events.len() as u64, ends.0, ends.1)),
        });
        self.at += 8 + u64::from(length);
        Ok(())
    }

    /// Writes the events that wait.
    fn flush(&mut self, out: &mut dyn Out) -> io::Result<()> {
        let mut events = std::mem::take(&mut self.rest);
        self.packet(out, &events)?;
        events.clear();
        self.rest = events;
        Ok(())
    }

    /// The XML that describes the one stream.
    fn description(&self) -> String {
        let Size { height, width } = self.head.size;
        let compression = COMPRESSIONS[usize::from(number(self.compression))];
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
                <attr key="amacrine" type="string">{}{BLANK}</attr>
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
        let number = i32::from(number(self.compression));
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
        self.header = [MAGIC, &header].concat();
        Ok(())
    }

    fn put(&mut self, out: &mut dyn Out, mut events: &[Event]) -> io::Result<()> {
        while !events.is_empty() {
            let room = BLOCK - self.rest.len();
            let (now, later) = events.split_at(room.min(events.len()));
            if now.len() == BLOCK {
                self.packet(out, now)?;
            } else {
                self.rest.extend_from_slice(now);
                if self.rest.len() == BLOCK {
                    self.flush(out)?;
                }
            }
            events = later;
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        self.flush(out)?;
        let table = packets::written(&self.table);
        let table = self.packing.pack(&table)?;
        out.write_all(table)?;
        out.seek(SeekFrom::Start(self.position))?;
        out.write_all(&self.at.to_le_bytes())?;
        complete(out, &self.header, about)
    }
}
