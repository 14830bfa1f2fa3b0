//! Event frames: pictures of so many events each.

use std::str::FromStr;

use super::{
    error::{TensorError, named, room},
    sides::Sides,
    sorted,
};
use crate::{
    event::{Event, Packet, outside},
    plane::Size,
};

/// What a pixel of an event frame holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fill {
    /// The number of its events: ON less OFF, or each on its own.
    #[default]
    Count,
    /// Its last event: 1 for ON, -1 for OFF; with [`Sides::Split`] 1 where there was any.
    Last,
}

const NAMES: [(&str, Fill); 2] = [("count", Fill::Count), ("last", Fill::Last)];

impl FromStr for Fill {
    type Err = TensorError;

    fn from_str(text: &str) -> Result<Self, TensorError> {
        named(&NAMES, "way to fill a frame", text)
    }
}

/// Frames of `each` events in the order of their times, `[frame][channel][side][y, x]`; the last
/// has what is left. No events are no frame.
///
/// # Errors
/// When an event lies outside of the packet, or the frames are more than this machine holds.
pub fn frames(
    packet: &Packet,
    each: usize,
    sides: Sides,
    fill: Fill,
) -> Result<Vec<i32>, TensorError> {
    outside::check(&packet.events, packet.size, packet.channels)?;
    let cells = packet
        .size
        .pixels()
        .saturating_mul(usize::from(packet.channels) * sides.count());
    let events = sorted(&packet.events);
    let parts = events.chunks(each.max(1));
    let mut out = vec![0; room(parts.len() as u64, "event frames", cells)?];
    for (events, out) in parts.zip(out.chunks_mut(cells.max(1))) {
        draw(events, packet.size, sides, fill, out);
    }
    Ok(out)
}

/// Draws events, in the order of their times, into a frame.
pub(super) fn draw(events: &[Event], size: Size, sides: Sides, fill: Fill, frame: &mut [i32]) {
    for event in events {
        if let Some(cell) = frame.get_mut(sides.place(event, size)) {
            let sign = sides.sign(event.polarity);
            *cell = match fill {
                Fill::Count => *cell + sign,
                Fill::Last => sign,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Polarity, unit::Micros};

    #[test]
    fn frames_of_three_events() {
        let mut packet = Packet::new(Size::new(1, 2), 1);
        let signs = [Polarity::On, Polarity::On, Polarity::Off, Polarity::On];
        packet.events = (0..4)
            .map(|n| Event {
                t: Micros(n),
                x: u16::from(n == 3),
                y: 0,
                polarity: signs[n as usize],
                channel: 0,
            })
            .collect();
        let of = |packet: &Packet, sides, fill| frames(packet, 3, sides, fill).unwrap();
        assert_eq!(of(&packet, Sides::Signed, Fill::Count), [1, 0, 0, 1]);
        assert_eq!(of(&packet, Sides::Signed, Fill::Last), [-1, 0, 0, 1]);
        assert_eq!(
            of(&packet, Sides::Split, Fill::Count),
            [1, 0, 2, 0, 0, 0, 0, 1]
        );
        assert_eq!(
            of(&packet, Sides::Split, Fill::Last),
            [1, 0, 1, 0, 0, 0, 0, 1]
        );
        packet.events.clear();
        assert!(of(&packet, Sides::Signed, Fill::Count).is_empty());
    }
}
