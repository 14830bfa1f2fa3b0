//! Address events as bits: fixed words, bursts of a row, and kinds in Huffman code.
//!
//! | layout | of each event | of each burst |
//! |---|---|---|
//! | [`Layout::Single`] | row, column, kind, sign | |
//! | [`Layout::Burst`] | 0, column, kind, sign | 1, row |
//!
//! Rows, columns and signs have the widths of [`AddressWord`]; a kind has its fixed width, or
//! the word that a [`CodeBook`] gives it. A burst is what consecutive events of one row and one
//! time are sent as; the leading bit tells rows from columns. Bits go most significant first.
//!
//! Time is when a word arrives, so it costs no bits: [`Coded::arrivals`] is the receiver's
//! clock. Sender and receiver know the sensor and the layout; the code book travels in front
//! of the words. `decode` gives back every event, at its time, in its order.

mod book;
mod fault;
mod rate;
mod wire;

pub use book::{CodeBook, entropy};
pub use fault::{BookFault, CodecError};
pub use rate::{Rate, frames};

use self::wire::{Reader, Writer};
use super::{Event, Packet, Polarity, address::AddressWord};
use crate::{plane::Size, unit::Micros};

/// What goes into a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// Every event on its own.
    Single,
    /// A row, then the columns that spoke in it.
    Burst,
}

/// A way to write events.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coding {
    /// What goes into a word.
    pub layout: Layout,
    /// The words of kinds; `None` for a field of fixed width.
    pub book: Option<CodeBook>,
}

/// Events that arrived within one microsecond.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Arrival {
    /// When.
    pub t: Micros,
    /// How many.
    pub events: u64,
}

/// Events as bits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coded {
    /// Size of the sensor.
    pub size: Size,
    /// Kinds of cells.
    pub channels: u8,
    /// What goes into a word.
    pub layout: Layout,
    /// Whether kinds are in Huffman code; then a code book comes first.
    pub huffman: bool,
    /// The code book, if any, then the words; the last byte is filled up with zeros.
    pub bytes: Vec<u8>,
    /// Bits of book and words.
    pub bits: u64,
    /// When the events arrive.
    pub arrivals: Vec<Arrival>,
}

impl Coding {
    /// The events of a packet as bits.
    ///
    /// # Errors
    /// When an event lies off the packet's sensor, or the book has no word for its kind.
    pub fn encode(&self, packet: &Packet) -> Result<Coded, CodecError> {
        let fields = AddressWord::new(packet.size, packet.channels);
        let mut arrivals: Vec<Arrival> = Vec::new();
        let mut out = Writer::default();
        if let Some(book) = &self.book {
            for byte in book.to_bytes() {
                out.write(8, byte);
            }
        }
        let mut before: Option<&Event> = None;
        for (number, e) in packet.events.iter().enumerate() {
            on_sensor(packet, number, e)?;
            match self.layout {
                Layout::Single => out.write(fields.y, e.y),
                Layout::Burst => {
                    if opens_burst(before, e) {
                        out.write(1, 1_u8);
                        out.write(fields.y, e.y);
                    }
                    out.write(1, 0_u8);
                }
            }
            out.write(fields.x, e.x);
            match &self.book {
                None => out.write(fields.channel, e.channel),
                Some(book) => {
                    let (length, word) = book.word(e.channel).ok_or_else(|| no_code(number, e))?;
                    out.write(length, word);
                }
            }
            out.write(fields.polarity, e.polarity.bit());
            match arrivals.last_mut() {
                Some(last) if last.t == e.t => last.events += 1,
                _ => arrivals.push(Arrival { t: e.t, events: 1 }),
            }
            before = Some(e);
        }
        let (bytes, bits) = out.finish();
        Ok(Coded {
            size: packet.size,
            channels: packet.channels,
            layout: self.layout,
            huffman: self.book.is_some(),
            bytes,
            bits,
            arrivals,
        })
    }

    /// Bits of each event, without writing them; the row of a burst counts to its first event.
    /// The code book is not among them.
    ///
    /// # Errors
    /// As [`Coding::encode`].
    pub fn costs(&self, packet: &Packet) -> Result<Vec<u32>, CodecError> {
        let fields = AddressWord::new(packet.size, packet.channels);
        let mut before: Option<&Event> = None;
        let cost = |(number, e)| {
            on_sensor(packet, number, e)?;
            let kind = match &self.book {
                None => fields.channel,
                Some(book) => book.word(e.channel).ok_or_else(|| no_code(number, e))?.0,
            };
            let place = match self.layout {
                Layout::Single => fields.y,
                Layout::Burst if opens_burst(before, e) => 2 + fields.y,
                Layout::Burst => 1,
            };
            before = Some(e);
            Ok(place + fields.x + kind + fields.polarity)
        };
        packet.events.iter().enumerate().map(cost).collect()
    }

    /// Bits of the code book; 0 without one.
    #[must_use]
    pub fn book_bits(&self) -> u64 {
        self.book
            .as_ref()
            .map_or(0, |book| 8 * book.to_bytes().len() as u64)
    }
}

impl Coded {
    /// The events again.
    ///
    /// # Errors
    /// When the bits are not what was agreed; the message names the bit or byte.
    pub fn decode(&self) -> Result<Vec<Event>, CodecError> {
        let fields = AddressWord::new(self.size, self.channels);
        let mut input = Reader::new(&self.bytes, self.bits)?;
        let book = if self.huffman {
            Some(CodeBook::read(&mut input, self.channels)?)
        } else {
            None
        };
        let (mut events, mut row) = (Vec::new(), None);
        let times = self.arrivals.iter();
        let times = times.flat_map(|a| (0..a.events).map(move |_| a.t));
        for (number, t) in times.enumerate() {
            input.event = number;
            let y = match self.layout {
                Layout::Single => input.read("row", fields.y, self.size.height)?,
                Layout::Burst => {
                    if input.flag("leading bit")? {
                        row = Some(input.read("row", fields.y, self.size.height)?);
                        let bit = input.at();
                        if input.flag("leading bit")? {
                            return Err(CodecError::EmptyRow { bit });
                        }
                    }
                    row.ok_or(CodecError::NoRow)?
                }
            };
            let x = input.read("column", fields.x, self.size.width)?;
            let channel = match &book {
                None => input.read("kind", fields.channel, self.channels.into())? as u8,
                Some(book) => book.decode(|| input.flag("kind"))?,
            };
            let polarity = Polarity::of(input.flag("sign")?);
            events.push(Event {
                t,
                x,
                y,
                polarity,
                channel,
            });
        }
        input.finish()?;
        Ok(events)
    }
}

/// Whether an event begins a new burst, so that its row is sent.
fn opens_burst(before: Option<&Event>, e: &Event) -> bool {
    before.is_none_or(|before| (before.t, before.y) != (e.t, e.y))
}

fn on_sensor(packet: &Packet, number: usize, e: &Event) -> Result<(), CodecError> {
    let Size { height, width } = packet.size;
    if usize::from(e.x) < width && usize::from(e.y) < height && e.channel < packet.channels {
        return Ok(());
    }
    Err(CodecError::Cell {
        event: number,
        x: e.x,
        y: e.y,
        channel: e.channel,
        size: packet.size,
        channels: packet.channels,
    })
}

const fn no_code(event: usize, e: &Event) -> CodecError {
    CodecError::NoCode {
        event,
        channel: e.channel,
    }
}
