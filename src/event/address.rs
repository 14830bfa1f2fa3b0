//! The address word: what one event costs in bits.
//!
//! In address-event representation an event is the address of its cell, sent when it
//! happens: column, row, sign and kind. Its time is when it arrives, so time costs no bits
//! (Mahowald 1992; Boahen 2000). Here each part has a field of its own, as in the fixed
//! words of AER chips; shorter words for frequent kinds, or rows sent once, are codecs.

use crate::{event::Packet, plane::Size};

/// The fields of a fixed address word, in bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
pub struct AddressWord {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// ON or OFF.
    pub polarity: u32,
    /// Kind of cell.
    pub channel: u32,
}

impl AddressWord {
    /// The word of a sensor: each field as wide as its count of values asks, so none for a
    /// single row, column or kind.
    #[must_use]
    pub fn new(size: Size, channels: u8) -> Self {
        Self {
            x: width(size.width),
            y: width(size.height),
            polarity: 1,
            channel: width(channels.into()),
        }
    }

    /// Bits of one event.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.x + self.y + self.polarity + self.channel
    }
}

/// Bits of all events of a packet, each sent as one fixed word. What was dropped was not sent.
#[must_use]
pub fn bits(packet: &Packet) -> u64 {
    let word = AddressWord::new(packet.size, packet.channels);
    packet.events.len() as u64 * u64::from(word.bits())
}

/// Bits that tell `values` values apart: `ceil(log2(values))`.
const fn width(values: usize) -> u32 {
    match values {
        0 | 1 => 0,
        _ => (values - 1).ilog2() + 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_the_narrowest_that_counts_far_enough() {
        for values in 1..2000_usize {
            let bits = width(values);
            assert!(1 << bits >= values);
            assert!(bits == 0 || 1 << (bits - 1) < values);
        }
    }

    #[test]
    fn known_sensors() {
        assert_eq!(AddressWord::new(Size::new(256, 256), 1).bits(), 17);
        assert_eq!(AddressWord::new(Size::new(260, 346), 1).bits(), 19);
        assert_eq!(AddressWord::new(Size::new(256, 256), 4).bits(), 19);
        assert_eq!(AddressWord::new(Size::new(1, 1), 1).bits(), 1);
    }
}
