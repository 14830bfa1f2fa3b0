//! Prophesee EVT 2.1: 64-bit words, each up to 32 pixels of a row with one time and sign:
//! `evlib.load_events(path).collect()`.
//!
//! Bits 63 to 60 say what a word is, as in [EVT 2.0](super::evt2); an event word has the low
//! six bits of the time (59 to 54), x of its first pixel (53 to 43), y (42 to 32), and a bit
//! for each pixel from there on. Upper parts of the time are in bits 59 to 32. Little-endian;
//! `endianness=legacy` has the two halves of a word exchanged. Source:
//! <https://docs.prophesee.ai/stable/data/encoding_formats/evt21.html>.

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
    name: "evt2.1",
    extension: "raw",
    limits: LIMITS,
    readers: "evlib",
    module: "evlib",
    python: "evlib.load_events(path).collect()",
    sign: Sign::Encoding,
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks)?)),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    also: &["evt21"],
    few_bits_of_size: true,
    ..Entry::PLAIN
};

#[derive(Clone, Debug, Default)]
pub(super) struct Evt21 {
    clock: Clock,
    is_upper_half_first: bool,
    skipped: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Evt21>, Stop> {
    let known = [ByteOrder::Little, ByteOrder::UpperHalfFirst];
    let (header, order) = opened(&mut chunks, Format::Evt21, &known)?;
    let words = Evt21 {
        is_upper_half_first: order == ByteOrder::UpperHalfFirst,
        ..Evt21::default()
    };
    Ok(Stream::new(chunks, words, header.about))
}

impl Words for Evt21 {
    const STEP: usize = 8;

    fn read(&mut self, bytes: &[u8], events: &mut Vec<Event>) -> Result<usize, (usize, Fault)> {
        let (words, _) = bytes.as_chunks();
        for (i, word) in words.iter().enumerate() {
            let mut word = u64::from_le_bytes(*word);
            if self.is_upper_half_first {
                word = word.rotate_left(32);
            }
            let (upper, mut pixels) = ((word >> 32) as u32, word as u32);
            match upper >> 28 {
                kind @ (0 | 1) => {
                    let first = upper >> 11 & 0x7FF;
                    let last = first + (31_u32.saturating_sub(pixels.leading_zeros()));
                    if pixels != 0 && last > 0x7FF {
                        let (name, value, limit) = ("x", last.into(), 0x7FF);
                        return Err((i * 8, Fault::Range { name, value, limit }));
                    }
                    let Some(t) = self.clock.time(upper >> 22 & 0x3F) else {
                        self.skipped += u64::from(pixels.count_ones());
                        continue;
                    };
                    while pixels != 0 {
                        events.push(Event {
                            t,
                            x: (first + pixels.trailing_zeros()) as u16,
                            y: (upper & 0x7FF) as u16,
                            polarity: Polarity::of(kind == 1),
                            channel: 0,
                        });
                        pixels &= pixels - 1;
                    }
                }
                8 => self.clock.set(upper & 0x0FFF_FFFF),
                0xA | 0xE => self.skipped += 1,
                0xF => (),
                kind => {
                    let format = Format::Evt21;
                    return Err((i * 8, Fault::Word { format, kind }));
                }
            }
        }
        Ok(words.len() * 8)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        header: prophesee(Format::Evt21, head),
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

/// Groups events into one word: the bit mask of pixels from column `from` on, `width` of them, and
/// the number of events in it. Only events in order of x are grouped, so that their order is kept.
pub fn together(events: &[Event], from: u16, width: u32) -> (u32, usize) {
    let (mut pixels, mut count) = (0_u32, 0);
    let Some(first) = events.first() else {
        return (0, 0);
    };
    for e in events {
        let at = u32::from(e.x.wrapping_sub(from));
        let same = e.t == first.t && e.y == first.y && e.polarity == first.polarity;
        // Nothing at this pixel or behind it.
        if !same || at >= width || pixels >> at != 0 {
            break;
        }
        pixels |= 1 << at;
        count += 1;
    }
    (pixels, count)
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(self.header.as_bytes())
    }

    fn put(&mut self, out: &mut dyn Out, mut events: &[Event]) -> io::Result<()> {
        self.bytes.clear();
        while let Some(e) = events.first() {
            let high = e.t.0 >> LOW;
            if self.high != Some(high) {
                for part in Clock::steps(self.high, high) {
                    let word = u64::from(0x8000_0000 | part) << 32;
                    self.bytes.extend_from_slice(&word.to_le_bytes());
                }
                self.high = Some(high);
            }
            // The sensor's own groups start at multiples of 32.
            let from = e.x & !31;
            let (pixels, count) = together(events, from, 32);
            let low = (e.t.0 as u32 & 0x3F) << 22;
            let kind = u32::from(e.polarity.bit()) << 28;
            let upper = kind | low | u32::from(from) << 11 | u32::from(e.y);
            let word = u64::from(upper) << 32 | u64::from(pixels);
            self.bytes.extend_from_slice(&word.to_le_bytes());
            events = &events[count.max(1)..];
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        complete(out, self.header.as_bytes(), about)
    }
}
