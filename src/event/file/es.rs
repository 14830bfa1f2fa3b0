//! Event Stream, version 2, events of a DVS: `list(event_stream.Decoder(path))`.
//!
//! `Event Stream`, the version, the kind (1), width and height in 16 bits each; then for each
//! event a byte (bits 7 to 1 the microseconds since the last, 0 to 126; bit 0 the sign), x
//! and y in 16 bits each. 255 lets 127 us pass, 254 is padding. Rows are written as they are,
//! top first; some readers (faery) count them from the bottom. Source:
//! <https://github.com/neuromorphicsystems/event_stream>.

use std::io;

use super::{
    Fault, Format, Place,
    about::About,
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    head::Head,
    source::{Out, Sink, Stream, Words},
};
use crate::{
    event::{Event, Polarity},
    plane::Size,
    unit::Micros,
};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "es",
    extension: "es",
    // Silence costs a byte each 127 us: an hour 28 megabytes.
    limits: Limits {
        x: u16::MAX - 1,
        y: u16::MAX - 1,
        silence: u32::MAX as u64,
        channels: false,
        ..Limits::WIDE
    },
    readers: "event_stream, faery (rows from the bottom)",
    module: "event_stream",
    python: "list(event_stream.Decoder(path))",
    sign: Sign::Bytes(MAGIC),
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks)?)),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    rewinds: false,
    few_bits_of_size: true,
    remarks: false,
    ..Entry::PLAIN
};

const MAGIC: &[u8; 12] = b"Event Stream";

/// The byte that only lets time pass.
const WAIT: u8 = 0xFF;

/// The time that it lets pass, in microseconds.
const PAUSE: u64 = 127;

/// The padding byte.
const PADDING: u8 = 0xFE;

#[derive(Clone, Debug)]
pub(super) struct Es {
    t: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Es>, Stop> {
    let wrong = |at, why| {
        let format = Format::Es;
        Err(Stop::Fault(Place::Byte(at), Fault::Layout { format, why }))
    };
    let magic: [u8; 12] = chunks.take("the first twelve bytes")?;
    if magic != *MAGIC {
        return wrong(0, "does not start with `Event Stream`".into());
    }
    let [major, minor, patch, kind] = chunks.take("its version and kind")?;
    if major != 2 {
        let why = format!("is of version {major}.{minor}.{patch}; 2 is known");
        return wrong(12, why);
    }
    if kind != 1 {
        let why = format!("holds events of kind {kind}; those of a DVS, kind 1, are read");
        return wrong(15, why);
    }
    let [w0, w1, h0, h1] = chunks.take("the size of its sensor")?;
    let (width, height) = (u16::from_le_bytes([w0, w1]), u16::from_le_bytes([h0, h1]));
    let about = About {
        size: Some(Size::new(height.into(), width.into())),
        ..About::NOTHING
    };
    Ok(Stream::new(chunks, Es { t: 0 }, about))
}

impl Words for Es {
    const STEP: usize = 1;

    fn read(&mut self, bytes: &[u8], events: &mut Vec<Event>) -> Result<usize, (usize, Fault)> {
        let mut at = 0;
        while let Some((first, rest)) = bytes[at..].split_first() {
            match *first {
                WAIT => {
                    self.t = self.t.saturating_add(PAUSE);
                    at += 1;
                }
                PADDING => at += 1,
                first => {
                    let Some([x0, x1, y0, y1]) = rest.first_chunk().copied() else {
                        break;
                    };
                    self.t = self.t.saturating_add(u64::from(first >> 1));
                    events.push(Event {
                        t: Micros(self.t),
                        x: u16::from_le_bytes([x0, x1]),
                        y: u16::from_le_bytes([y0, y1]),
                        polarity: Polarity::of(first & 1 == 1),
                        channel: 0,
                    });
                    at += 5;
                }
            }
        }
        Ok(at)
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        size: head.size,
        last: 0,
        bytes: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    size: Size,
    last: u64,
    bytes: Vec<u8>,
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(MAGIC)?;
        out.write_all(&[2, 0, 0, 1])?;
        for side in [self.size.width, self.size.height] {
            let side = u16::try_from(side).map_err(io::Error::other)?;
            out.write_all(&side.to_le_bytes())?;
        }
        Ok(())
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.bytes.clear();
        for e in events {
            let mut pause = e.t.0 - self.last;
            while pause >= PAUSE {
                self.bytes.push(WAIT);
                pause -= PAUSE;
                // A long silence is written out at once, not buffered.
                if self.bytes.len() > 1 << 16 {
                    out.write_all(&self.bytes)?;
                    self.bytes.clear();
                }
            }
            self.last = e.t.0;
            let first = (pause as u8) << 1 | e.polarity.bit();
            let ([x0, x1], [y0, y1]) = (e.x.to_le_bytes(), e.y.to_le_bytes());
            self.bytes.extend_from_slice(&[first, x0, x1, y0, y1]);
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, _: &mut dyn Out, _: &About) -> io::Result<()> {
        Ok(())
    }
}
