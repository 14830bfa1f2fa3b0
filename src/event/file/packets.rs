//! The table of packets at the end of an AEDAT4 file: written for players that seek, and read to
//! check the packets of a file.

use super::{
    Fault, Format,
    flat::{Builder, Table, identifier},
};

/// A row of the table; also what was found of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Place of its buffer, behind its header.
    pub at: u64,
    /// Number of its stream.
    pub stream: i32,
    /// Its bytes, compressed.
    pub bytes: u32,
    /// Number of its events, and the times of the first and the last; `None` for packets of other
    /// streams.
    pub events: Option<(u64, i64, i64)>,
}

/// Whether the table starts here, however it is compressed. No packet starts like it, as no stream
/// has such a number, and no packet so many bytes.
pub fn starts(here: &[u8]) -> bool {
    let compressed = [[0x04, 0x22, 0x4D, 0x18], [0x28, 0xB5, 0x2F, 0xFD]];
    compressed.iter().any(|magic| here.starts_with(magic)) || here.get(8..12) == Some(&b"FTAB"[..])
}

/// The rows of a table that is no longer compressed.
pub fn read(table: &[u8]) -> Option<Vec<Row>> {
    let body = whole(table)?;
    if identifier(body) != Some(*b"FTAB") {
        return None;
    }
    let (offsets, start) = Table::root(body)?.vector(0, 4)?;
    let (offsets, _) = offsets.as_chunks();
    let rows = offsets.iter().enumerate().map(|(i, offset)| {
        let offset = u32::from_le_bytes(*offset) as usize;
        let row = Table::at(body, (start + 4 * i).checked_add(offset)?);
        let (stream, bytes) = row.pair(1).unwrap_or_default();
        let number = |field| row.i64(field).unwrap_or(0);
        Some(Row {
            at: u64::try_from(number(0)).ok()?,
            stream,
            bytes: u32::try_from(bytes).ok()?,
            events: Some((u64::try_from(number(2)).ok()?, number(3), number(4))),
        })
    });
    rows.collect()
}

/// Whether a block is one LZ4 frame, from its first byte to the mark at its end. Layout:
/// <https://github.com/lz4/lz4/blob/dev/doc/lz4_Frame_format.md>.
pub fn is_lz4_frame(block: &[u8]) -> bool {
    let end = || {
        let flags = *block.get(4)?;
        let has = |bit: u8, bytes: usize| usize::from(flags >> bit & 1) * bytes;
        // Magic, flags and sizes, check sum of these.
        let mut at = 4 + 2 + has(3, 8) + has(0, 4) + 1;
        loop {
            let size = u32::from_le_bytes(*block.get(at..)?.first_chunk()?);
            at += 4;
            if size == 0 {
                return Some(at + has(2, 4));
            }
            at += (size & i32::MAX as u32) as usize + has(4, 4);
        }
    };
    end() == Some(block.len())
}

/// A buffer without its size prefix, which must match its length.
pub fn whole(buffer: &[u8]) -> Option<&[u8]> {
    let (size, body) = buffer.split_first_chunk()?;
    (u32::from_le_bytes(*size) as usize == body.len()).then_some(body)
}

/// Checks the packets that were found against the table.
pub fn agree(found: &[Row], table: &[Row]) -> Result<(), Fault> {
    for (i, (found, stated)) in found.iter().zip(table).enumerate() {
        let mut pairs = vec![
            (
                "starts at byte",
                stated.at.cast_signed(),
                found.at.cast_signed(),
            ),
            ("is of stream", stated.stream.into(), found.stream.into()),
            (
                "has this many bytes:",
                stated.bytes.into(),
                found.bytes.into(),
            ),
        ];
        if let (Some(stated), Some(found)) = (stated.events, found.events) {
            let (count, here) = (stated.0.cast_signed(), found.0.cast_signed());
            pairs.push(("has this many events:", count, here));
            if here > 0 {
                pairs.push(("has its first event at", stated.1, found.1));
                pairs.push(("has its last event at", stated.2, found.2));
            }
        }
        if let Some((what, stated, here)) = pairs.into_iter().find(|(_, a, b)| a != b) {
            let one = format!("its table says that packet {i} {what} {stated}");
            let other = format!("the packet at byte {} has {here}", found.at);
            return Err(Fault::twice(Format::Aedat4, one, other));
        }
    }
    if found.len() == table.len() {
        return Ok(());
    }
    let one = format!(
        "its table lists {}",
        crate::unit::counted(table.len(), "packet")
    );
    let other = format!("there are {}", found.len());
    Err(Fault::twice(Format::Aedat4, one, other))
}

/// Writes the table: a vector of offsets to tables of one layout.
pub fn written(rows: &[Row]) -> Vec<u8> {
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
        let (events, from, to) = row.events.unwrap_or((0, -1, -1));
        bytes.extend(((bytes.len() - fields) as u32).to_le_bytes());
        for number in [row.at, events] {
            bytes.extend(number.to_le_bytes());
        }
        for time in [from, to] {
            bytes.extend(time.to_le_bytes());
        }
        bytes.extend(row.stream.to_le_bytes());
        bytes.extend(row.bytes.to_le_bytes());
        bytes.extend([0; 4]);
    }
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_reads_back_and_every_number_counts() {
        let row = |i: u64| Row {
            at: 100 * i,
            stream: 3,
            bytes: 92,
            events: Some((7, 5, 9)),
        };
        let rows = [row(1), row(2)];
        let table = written(&rows);
        assert!(starts(&table));
        assert_eq!(read(&table).unwrap(), rows);
        agree(&rows, &rows).unwrap();
        let other = |change: fn(&mut Row)| {
            let mut stated = rows;
            change(&mut stated[1]);
            agree(&rows, &stated).unwrap_err().to_string()
        };
        assert!(other(|r| r.at += 1).contains("packet 1 starts at byte 201"));
        assert!(other(|r| r.stream = 0).contains("is of stream 0"));
        assert!(other(|r| r.bytes = 0).contains("bytes: 0"));
        assert!(other(|r| r.events = Some((6, 5, 9))).contains("events: 6"));
        assert!(other(|r| r.events = Some((7, 4, 9))).contains("first event at 4"));
        assert!(other(|r| r.events = Some((7, 5, 8))).contains("last event at 8"));
        assert!(agree(&rows, &rows[..1]).is_err() && agree(&rows[..1], &rows).is_err());
    }
}
