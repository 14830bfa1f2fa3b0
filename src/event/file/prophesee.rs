//! What Prophesee's encodings share: EVT 2.0, 2.1 and 3.0.

use super::{Fault, Format, chunks::Chunks, entry::Limits, fault::Stop, header::Header};
use crate::unit::Micros;

/// Addresses have eleven bits. Every overflow of the time is written out, so times are limited such
/// that this takes a few megabytes.
pub(super) const LIMITS: Limits = Limits {
    x: (1 << 11) - 1,
    y: (1 << 11) - 1,
    t: (1 << 44) - 1,
    channels: false,
    ..Limits::WIDE
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

/// How the bytes of a word lie in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// The lowest byte first.
    Little,
    /// Each half of a word with its lowest byte first, the upper half before the lower one:
    /// `endianness=legacy`.
    UpperHalfFirst,
}

/// Reads the header of a file of words, whose byte order must be one of `known`.
///
/// The order stands behind the format (`% format EVT21;endianness=legacy`) or in a line of its own
/// (`% endianness legacy`).
pub fn opened(
    chunks: &mut Chunks,
    format: Format,
    known: &[ByteOrder],
) -> Result<(Header, ByteOrder), Stop> {
    let mut header = Header::read(chunks, format, b'%', "end")?;
    header.names(format).map_err(|fault| chunks.stop(fault))?;
    header.about.size = header.size(format).map_err(|fault| chunks.stop(fault))?;
    let said = header.setting("endianness").or(header.get("endianness"));
    let order = match said {
        None | Some("little") => Some(ByteOrder::Little),
        Some("legacy") => Some(ByteOrder::UpperHalfFirst),
        Some(_) => None,
    };
    if let Some(order) = order.filter(|order| known.contains(order)) {
        return Ok((header, order));
    }
    let said = said.unwrap_or_default();
    let why = format!("is {said}-endian; only little-endian files are read");
    Err(chunks.stop(Fault::Layout { format, why }))
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
