//! Packed events: 8 bytes each, as bands pass them on.

use crate::{
    event::{Event, Polarity},
    unit::Micros,
};

/// An event in 8 bytes, from the lowest bit on: 16 bits each for column and row, 8 for the channel,
/// one for the sign (1 is ON), 23 for the microseconds since the quantiser's start.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PackedEvent(u64);

/// An event for every channel and sign: copied from here, both fields are written at once.
static KINDS: [Event; 512] = kinds();

const fn kinds() -> [Event; 512] {
    let mut kinds = [Event {
        t: Micros(0),
        x: 0,
        y: 0,
        polarity: Polarity::Off,
        channel: 0,
    }; 512];
    let mut kind = 0;
    while kind < 512 {
        kinds[kind].channel = kind as u8;
        if kind >= 256 {
            kinds[kind].polarity = Polarity::On;
        }
        kind += 1;
    }
    kinds
}

impl PackedEvent {
    /// Place of the sign bit; the address is below it.
    const SIGN: u32 = 40;
    /// Place of the time, and its number of bits.
    const TIME: u32 = 41;
    pub(super) const TIME_BITS: u32 = 64 - Self::TIME;

    /// At the clock's start, in column 0, and ON.
    pub(super) fn new(channel: usize, y: usize) -> Self {
        Self((y as u64) << 16 | (channel as u64) << 32 | 1 << Self::SIGN)
    }

    /// The same event in another column, with the sign of a count.
    #[inline]
    pub(super) const fn column(self, x: usize, count: i32) -> Self {
        let off = count as i64 as u64 & 1 << Self::SIGN;
        Self((self.0 + x as u64) ^ off)
    }

    /// The same event `since` microseconds later; bits that a time does not have are lost.
    #[inline]
    pub(super) const fn after(self, since: u64) -> Self {
        Self(self.0.wrapping_add(since << Self::TIME))
    }

    #[inline]
    pub(super) const fn since(self) -> u64 {
        self.0 >> Self::TIME
    }

    #[inline]
    pub(super) fn at(self, t: Micros) -> Event {
        Event {
            t,
            x: self.0 as u16,
            y: (self.0 >> 16) as u16,
            ..KINDS[(self.0 >> 32) as usize % KINDS.len()]
        }
    }
}
