//! AEDAT 4.0 as DV writes it: compressed packets,
//! `[p['events'] for p in aedat.Decoder(path) if 'events' in p]`.
//!
//! `#!AER-DAT4.0`, a header (how packets are compressed, where the table of packets is, and
//! XML that describes the streams), then packets: number of the stream, bytes, and a
//! `FlatBuffer`, compressed; an event has 16 bytes, t in 64 bits, x and y in 16 with a sign,
//! and the sign of the event. At the end the table of packets, so that players can seek.
//! Source: <https://docs.inivation.com/software/software-advanced-usage/file-formats/aedat-4.0.html>
//! and the schemata at <https://gitlab.com/inivation/dv/dv-core>.

mod reading;
mod writing;

use super::entry::{Entry, Limits, Sign, Streams};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "aedat4",
    extension: "aedat4",
    limits: Limits {
        x: i16::MAX.unsigned_abs(),
        y: i16::MAX.unsigned_abs(),
        channels: false,
        ..Limits::WIDE
    },
    readers: "aedat, dv, dv_processing, faery, eventcv",
    module: "aedat",
    python: "[p['events'] for p in aedat.Decoder(path) if 'events' in p]",
    sign: Sign::Bytes(b"#!AER-DAT4.0"),
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(reading::source(chunks)?)),
        sink: |head, compression| Ok(Box::new(writing::sink(head, compression))),
    }),
    compresses: true,
    ..Entry::PLAIN
};

const MAGIC: &[u8] = b"#!AER-DAT4.0\r\n";

/// Bytes of an event.
const EVENT: usize = 16;

/// Ways of compression by number, as the XML calls them.
const COMPRESSIONS: [&str; 5] = ["NONE", "LZ4", "LZ4_HIGH", "ZSTD", "ZSTD_HIGH"];
