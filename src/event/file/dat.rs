//! Prophesee DAT, version 2: 64 bits an event, `faery.events_stream_from_file(path).to_array()`.
//!
//! A header of `%` lines, two bytes (kind of event 12 or 0, eight bytes an event), then for
//! each event the time in 32 bits and a word with x (13 to 0), y (27 to 14) and the sign (31
//! to 28). Version 1, read too, has x in 8 to 0, y in 16 to 9, the sign in 20 to 17. No turn
//! of the clock: what comes after 2^32 us (71 min) is refused. Source:
//! <https://docs.prophesee.ai/stable/data/file_formats/dat.html>.

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
    unit::Micros,
};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "dat",
    extension: "dat",
    limits: Limits {
        x: (1 << 14) - 1,
        y: (1 << 14) - 1,
        t: u32::MAX as u64,
        channels: false,
        ..Limits::WIDE
    },
    readers: "faery, expelliarmus, eventcv",
    module: "faery",
    python: "faery.events_stream_from_file(path).to_array()",
    sign: Sign::Line(|words| matches!(words, ["data", "file", "containing", ..])),
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks)?)),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    few_bits_of_size: true,
    ..Entry::PLAIN
};

#[derive(Clone, Debug)]
pub(super) struct Dat {
    /// Bits of the column and of the row in an address.
    address: (u32, u32),
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Dat>, Stop> {
    let mut header = Header::read(&mut chunks, Format::Dat, b'%', "end")?;
    let wrong = |why| Fault::Layout {
        format: Format::Dat,
        why,
    };
    let address = match header.get("version") {
        Some("2") => (14, 14),
        Some("1") | None => (9, 8),
        Some(other) => {
            let why = format!("is of version {other}; 1 and 2 are known");
            return Err(chunks.stop(wrong(why)));
        }
    };
    let here = chunks.at();
    let [kind, bytes] = chunks.take("the kind of its events")?;
    if !matches!(kind, 0 | 12) || bytes != 8 {
        let why = format!(
            "holds records of kind {kind} and {bytes} bytes; those of pixels are of kind 12 or 0 and 8 bytes"
        );
        return Err(Stop::Fault(super::Place::Byte(here), wrong(why)));
    }
    header.about.size = header
        .size(Format::Dat)
        .map_err(|fault| chunks.stop(fault))?;
    if header.ours && address.0 != 14 {
        let one = "the comment `# amacrine …` is that of a file of version 2";
        let fault = Fault::twice(Format::Dat, one, "its header says another version");
        return Err(chunks.stop(fault));
    }
    Ok(Stream::new(chunks, Dat { address }, header.about))
}

impl Words for Dat {
    const STEP: usize = 8;

    fn read(&mut self, bytes: &[u8], events: &mut Vec<Event>) -> Result<usize, (usize, Fault)> {
        let (words, _) = bytes.as_chunks();
        let (columns, rows) = self.address;
        let place = |word: &[u8; 8]| u64::from_le_bytes(*word) >> 32;
        let sign = |word: &[u8; 8]| place(word) >> (columns + rows) & 0xF;
        // All at once first: this runs in vectors.
        let bad = words.iter().fold(0, |most, word| sign(word).max(most)) > 1;
        let at = if bad {
            words.iter().position(|word| sign(word) > 1)
        } else {
            None
        };
        let good = at.map_or(words, |at| &words[..at]);
        events.extend(good.iter().map(|word| Event {
            t: Micros(u64::from_le_bytes(*word) & u64::from(u32::MAX)),
            x: (place(word) & ((1 << columns) - 1)) as u16,
            y: (place(word) >> columns & ((1 << rows) - 1)) as u16,
            polarity: Polarity::of(sign(word) == 1),
            channel: 0,
        }));
        if let Some(at) = at {
            let found = sign(&words[at]).into();
            return Err((at * 8, Fault::Polarity { found }));
        }
        Ok(words.len() * 8)
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        header: format!(
            "% Data file containing CD events.\n% Version 2\n% Height {}\n% Width {}\n% {}{BLANK}\n",
            head.size.height,
            head.size.width,
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
        out.write_all(self.header.as_bytes())?;
        out.write_all(&[12, 8])
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.bytes.resize(8 * events.len(), 0);
        for (word, e) in self.bytes.as_chunks_mut().0.iter_mut().zip(events) {
            let sign = u64::from(e.polarity.bit()) << 28;
            let place = sign | u64::from(e.y) << 14 | u64::from(e.x);
            *word = (place << 32 | e.t.0).to_le_bytes();
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        complete(out, self.header.as_bytes(), about)
    }
}
