//! Prophesee EVT 2.0: one 32-bit word an event, `faery.events_stream_from_file(path,
//! file_type='evt').to_array()`, which takes any name.
//!
//! Bits 31 to 28 say what a word is: 0 OFF, 1 ON, with the low six bits of the time (27 to
//! 22), x (21 to 11) and y (10 to 0); 8 carries the upper 28 bits of the time; A a trigger,
//! E others, F goes on. The time turns over after 2^34 us; each turn is written out, as a
//! largest and then a smallest upper part, so that readers count it however long nothing
//! happened. Little-endian. Source:
//! <https://docs.prophesee.ai/stable/data/encoding_formats/evt2.html>.

use std::io;

use super::{
    Fault, Format,
    about::About,
    chunks::Chunks,
    entry::{Entry, Sign, Streams},
    fault::Stop,
    head::Head,
    header::{complete, prophesee},
    prophesee::{ByteOrder, Clock, LIMITS, LOW, opened},
    source::{Out, Sink, Stream, Words},
};
use crate::event::{Event, Polarity};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "evt2",
    extension: "raw",
    limits: LIMITS,
    readers: "faery, expelliarmus, evlib, eventcv",
    module: "faery",
    python: "faery.events_stream_from_file(path, file_type='evt').to_array()",
    sign: Sign::Encoding,
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks)?)),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    few_bits_of_size: true,
    ..Entry::PLAIN
};

#[derive(Clone, Debug, Default)]
pub(super) struct Evt2 {
    clock: Clock,
    skipped: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Evt2>, Stop> {
    let header = opened(&mut chunks, Format::Evt2, &[ByteOrder::Little])?.0;
    Ok(Stream::new(chunks, Evt2::default(), header.about))
}

impl Words for Evt2 {
    const STEP: usize = 4;

    fn read(&mut self, bytes: &[u8], events: &mut Vec<Event>) -> Result<usize, (usize, Fault)> {
        let (words, _) = bytes.as_chunks();
        events.reserve(words.len());
        for (i, word) in words.iter().enumerate() {
            let word = u32::from_le_bytes(*word);
            match word >> 28 {
                kind @ (0 | 1) => match self.clock.time(word >> 22 & 0x3F) {
                    Some(t) => events.push(Event {
                        t,
                        x: (word >> 11 & 0x7FF) as u16,
                        y: (word & 0x7FF) as u16,
                        polarity: Polarity::of(kind == 1),
                        channel: 0,
                    }),
                    None => self.skipped += 1,
                },
                8 => self.clock.set(word & 0x0FFF_FFFF),
                0xA | 0xE => self.skipped += 1,
                0xF => (),
                kind => {
                    let format = Format::Evt2;
                    return Err((i * 4, Fault::Word { format, kind }));
                }
            }
        }
        Ok(words.len() * 4)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        header: prophesee(Format::Evt2, head),
        high: None,
        bytes: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    header: String,
    high: Option<u64>,
    bytes: Vec<u8>,
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(self.header.as_bytes())
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.bytes.clear();
        for e in events {
            let high = e.t.0 >> LOW;
            if self.high != Some(high) {
                for part in Clock::steps(self.high, high) {
                    self.bytes
                        .extend_from_slice(&(0x8000_0000 | part).to_le_bytes());
                }
                self.high = Some(high);
            }
            let low = (e.t.0 as u32 & 0x3F) << 22;
            let kind = u32::from(e.polarity.bit()) << 28;
            let word = kind | low | u32::from(e.x) << 11 | u32::from(e.y);
            self.bytes.extend_from_slice(&word.to_le_bytes());
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        complete(out, self.header.as_bytes(), about)
    }
}
