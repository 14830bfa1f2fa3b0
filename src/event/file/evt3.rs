//! Prophesee EVT 3.0: 16-bit words with a state, `faery.events_stream_from_file(path,
//! file_type='evt').to_array()`, which takes any name.
//!
//! Bits 15 to 12 say what a word is: 0 a row; 2 a column and a sign, that is an event; 3 the
//! first column of a vector, with a sign; 4 and 5 the next 12 or 8 columns, a bit each; 6 and
//! 8 the low and the upper 12 bits of the time; A a trigger, E others, 7 and F go on. The
//! time turns over after 2^24 us; each turn is written out, as the largest and then the
//! smallest upper part, and longer steps in two, so that readers follow however long nothing
//! happened. Little-endian. Source:
//! <https://docs.prophesee.ai/stable/data/encoding_formats/evt3.html>.

use std::io;

use super::{
    Fault, Format,
    about::About,
    chunks::Chunks,
    entry::{Entry, Sign, Streams},
    evt21::together,
    fault::Stop,
    head::Head,
    header::{complete, prophesee},
    prophesee::{ByteOrder, LIMITS, opened},
    source::{Out, Sink, Stream, Words},
};
use crate::{
    event::{Event, Polarity},
    unit::Micros,
};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "evt3",
    extension: "raw",
    limits: LIMITS,
    readers: "faery, evlib, eventcv",
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

/// Bits of each of the two parts of the time.
const PART: u32 = 12;

/// Number of values of a part.
const PARTS: u64 = 1 << PART;

/// Half of the range: no longer step of the upper part is written.
const HALF: u64 = PARTS / 2;

#[derive(Clone, Debug)]
pub(super) struct Evt3 {
    /// Upper part of the time, overflows included.
    high: Option<u64>,
    low: u16,
    y: Option<u16>,
    /// Next column of a vector.
    base: Option<u16>,
    polarity: Polarity,
    skipped: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Evt3>, Stop> {
    let header = opened(&mut chunks, Format::Evt3, &[ByteOrder::Little])?.0;
    let words = Evt3 {
        high: None,
        low: 0,
        y: None,
        base: None,
        polarity: Polarity::Off,
        skipped: 0,
    };
    Ok(Stream::new(chunks, words, header.about))
}

impl Evt3 {
    /// Time and row, once words have given both.
    fn here(&self) -> Option<(Micros, u16)> {
        let high = self.high?;
        Some((Micros(high << PART | u64::from(self.low)), self.y?))
    }

    /// Adds the events of a vector word: `width` pixels from the base on.
    fn vector(
        &mut self,
        mut pixels: u16,
        width: u16,
        events: &mut Vec<Event>,
    ) -> Result<(), Fault> {
        let (Some((t, y)), Some(base)) = (self.here(), self.base) else {
            self.skipped += u64::from(pixels.count_ones());
            return Ok(());
        };
        self.base = Some(base.saturating_add(width));
        while pixels != 0 {
            let x = base.saturating_add(pixels.trailing_zeros() as u16);
            if x > 0x7FF {
                let (name, value, limit) = ("x", x.into(), 0x7FF);
                return Err(Fault::Range { name, value, limit });
            }
            events.push(Event {
                t,
                x,
                y,
                polarity: self.polarity,
                channel: 0,
            });
            pixels &= pixels - 1;
        }
        Ok(())
    }

    /// Takes a new upper part of the time: a step back by more than half the range is an overflow.
    fn set_high(&mut self, part: u16) {
        let part = u64::from(part);
        let high = self.high.map_or(part, |last| {
            let turns = last >> PART;
            let turned = last % PARTS > part + HALF;
            (turns + u64::from(turned)) << PART | part
        });
        if self.high != Some(high) {
            self.high = Some(high);
            self.low = 0;
        }
    }
}

impl Words for Evt3 {
    const STEP: usize = 2;

    fn read(&mut self, bytes: &[u8], events: &mut Vec<Event>) -> Result<usize, (usize, Fault)> {
        let (words, _) = bytes.as_chunks();
        for (i, word) in words.iter().enumerate() {
            let word = u16::from_le_bytes(*word);
            match word >> 12 {
                0 => self.y = Some(word & 0x7FF),
                2 => match self.here() {
                    Some((t, y)) => events.push(Event {
                        t,
                        x: word & 0x7FF,
                        y,
                        polarity: Polarity::of(word & 0x800 != 0),
                        channel: 0,
                    }),
                    None => self.skipped += 1,
                },
                3 => {
                    self.base = Some(word & 0x7FF);
                    self.polarity = Polarity::of(word & 0x800 != 0);
                }
                4 => self
                    .vector(word & 0xFFF, 12, events)
                    .map_err(|fault| (i * 2, fault))?,
                5 => self
                    .vector(word & 0xFF, 8, events)
                    .map_err(|fault| (i * 2, fault))?,
                6 => self.low = word & 0xFFF,
                8 => self.set_high(word & 0xFFF),
                0xA | 0xE => self.skipped += 1,
                7 | 0xF => (),
                kind => {
                    let (format, kind) = (Format::Evt3, kind.into());
                    return Err((i * 2, Fault::Word { format, kind }));
                }
            }
        }
        Ok(words.len() * 2)
    }

    fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        header: prophesee(Format::Evt3, head),
        high: None,
        low: 0,
        y: None,
        bytes: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    header: String,
    high: Option<u64>,
    low: u16,
    y: Option<u16>,
    bytes: Vec<u8>,
}

impl Writing {
    fn word(&mut self, kind: u16, rest: u16) {
        self.bytes
            .extend_from_slice(&(kind << 12 | rest).to_le_bytes());
    }

    fn time(&mut self, t: u64) {
        let (high, low) = (t >> PART, (t % PARTS) as u16);
        if self.high != Some(high) {
            // The first word of a file is 0, so that no byte of a time looks like a header's %.
            let mut at = self.high.unwrap_or_else(|| {
                self.word(8, 0);
                0
            });
            while at != high {
                let (turn, part) = (at >> PART, at % PARTS);
                at = if turn < high >> PART {
                    // An overflow is recognised only by a step from the very end to the very start.
                    match part {
                        last if last == PARTS - 1 => at + 1,
                        near if near >= HALF - 1 => turn << PART | (PARTS - 1),
                        _ => at + HALF,
                    }
                } else {
                    high.min(at + HALF)
                };
                self.word(8, (at % PARTS) as u16);
            }
            self.high = Some(high);
            // Readers differ in whether a new upper part clears the low one.
            self.word(6, low);
            self.low = low;
        } else if self.low != low {
            self.word(6, low);
            self.low = low;
        }
    }
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(self.header.as_bytes())
    }

    fn put(&mut self, out: &mut dyn Out, mut events: &[Event]) -> io::Result<()> {
        self.bytes.clear();
        while let Some(e) = events.first() {
            self.time(e.t.0);
            if self.y != Some(e.y) {
                self.word(0, e.y);
                self.y = Some(e.y);
            }
            let sign = u16::from(e.polarity.bit()) << 11;
            let (pixels, count) = together(events, e.x, 32);
            // As the sensor does: a base, then 12, 12 and 8 pixels.
            let width = 32 - pixels.leading_zeros();
            let words = 2 + usize::from(width > 12) + usize::from(width > 24);
            if words < count {
                self.word(3, sign | e.x);
                self.word(4, (pixels & 0xFFF) as u16);
                if width > 12 {
                    self.word(4, (pixels >> 12 & 0xFFF) as u16);
                }
                if width > 24 {
                    self.word(5, (pixels >> 24) as u16);
                }
            } else {
                for e in &events[..count] {
                    self.word(2, sign | e.x);
                }
            }
            events = &events[count..];
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        complete(out, self.header.as_bytes(), about)
    }
}
