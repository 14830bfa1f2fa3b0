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
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    head::Head,
    header::{Header, complete, prophesee},
    source::{Out, Sink, Stream, Words},
};
use crate::{
    event::{Event, Polarity},
    unit::Micros,
};

/// Addresses have eleven bits. Every overflow of the time is written out, so times are limited such
/// that this takes a few megabytes.
pub(super) const LIMITS: Limits = Limits {
    x: (1 << 11) - 1,
    y: (1 << 11) - 1,
    t: (1 << 44) - 1,
    channels: false,
    ..Limits::WIDE
};

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

/// Low bits of the time that an event carries itself.
pub const LOW: u32 = 6;

/// Bits of the time in a word of its own.
const HIGH: u32 = 28;

/// The time, whose overflows the reader counts itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    high: Option<u64>,
    turns: u64,
}

impl Clock {
    /// Takes a new upper part: a step back by more than half the range is an overflow.
    pub fn set(&mut self, high: u32) {
        let high = u64::from(high);
        let turned = |last: &u64| last.wrapping_sub(high) > 1 << (HIGH - 1) && high < *last;
        self.turns += u64::from(self.high.as_ref().is_some_and(turned));
        self.high = Some(high);
    }

    /// The time of an event with these low bits; `None` before the first upper part.
    pub fn time(self, low: u32) -> Option<Micros> {
        let high = self.turns << HIGH | self.high?;
        Some(Micros(high << LOW | u64::from(low)))
    }

    /// The upper parts to write between that of the last event (0 at first) and `to`, both with
    /// their overflows counted.
    pub fn steps(last: Option<u64>, to: u64) -> impl Iterator<Item = u32> {
        let from = last.unwrap_or(0);
        let most = (1 << HIGH) - 1;
        // The first word of a file is 0, so that no byte of a time looks like a header's %.
        let start = last.is_none().then_some(0);
        let turns = (from >> HIGH)..(to >> HIGH);
        let turns = turns.flat_map(move |_| [most, 0]);
        let end = (to != from).then_some(to as u32 & most);
        // None twice in a row, which some readers take for an overflow.
        let mut before = last.map(|last| last as u32 & most);
        start
            .into_iter()
            .chain(turns)
            .chain(end)
            .filter(move |part| before.replace(*part) != Some(*part))
    }
}

/// Whether a polarity is ON, in words that have it as a bit.
pub const fn polarity(on: bool) -> Polarity {
    if on { Polarity::On } else { Polarity::Off }
}

/// Reads the header of a file of words, and checks the byte order.
pub fn opened(chunks: &mut Chunks, format: Format) -> Result<Header, Stop> {
    let mut header = Header::read(chunks, format, b'%', "end")?;
    header.names(format).map_err(|fault| chunks.stop(fault))?;
    header.about.size = header.size(format).map_err(|fault| chunks.stop(fault))?;
    let order = header.setting("endianness").or(header.get("endianness"));
    match order {
        None | Some("little" | "legacy") => Ok(header),
        Some(other) => {
            let why = format!("is {other}-endian; only little-endian files are read");
            Err(chunks.stop(Fault::Layout { format, why }))
        }
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Evt2 {
    clock: Clock,
    skipped: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Stream<Evt2>, Stop> {
    let header = opened(&mut chunks, Format::Evt2)?;
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
                        polarity: polarity(kind == 1),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever lies between two events, a reader counts the turns.
    #[test]
    fn every_turn_of_the_clock_is_told() {
        let times = [
            0,
            5,
            63,
            64,
            (1 << 34) - 1,
            1 << 34,
            3 << 34,
            (9 << 34) + 77,
            1 << 43,
        ];
        for (i, first) in times.iter().enumerate() {
            let mut clock = Clock::default();
            let mut last = None;
            for t in &times[i..] {
                for part in Clock::steps(last, t >> LOW) {
                    clock.set(part);
                }
                last = Some(t >> LOW);
                let low = (*t & 63) as u32;
                assert_eq!(clock.time(low), Some(Micros(*t)), "from {first}");
            }
        }
    }
}
