//! Pictures of one packet: frames, time surfaces, clouds, rates, intervals, kinds.
//!
//! | view | what it shows |
//! |---|---|
//! | [`View::Overview`] | all that follows, on one page |
//! | [`View::Frame`] | each pixel in the colour of the sign that prevails in a window, the fuller the more |
//! | [`View::Surface`] | each pixel's last event, `exp(-(now - t)/tau)` |
//! | [`View::Cloud`] | events in x, y and time |
//! | [`View::Rate`] | ON and OFF events a second, over time |
//! | [`View::Intervals`] | times between successive events of a cell: ON-ON, OFF-OFF, and where the sign changes |
//! | [`View::Kinds`] | a frame for each kind |
//!
//! A window `from..to` holds the events of `from < t <= to`, as everywhere in this room.

mod cloud;
mod frame;
mod intervals;
mod kinds;
mod layout;
mod look;
#[cfg(feature = "mcap")]
pub mod mcap;
mod page;
mod pages;
mod rate;
mod surface;
mod time;
mod window;

pub use frame::frames;
pub use look::{Look, View};
pub use page::draw;
pub use pages::pages;

#[cfg(test)]
mod tests {
    use crate::{
        event::{Event, Packet, Polarity},
        plane::Size,
        unit::Micros,
    };

    pub(super) fn packet(events: &[(u64, u16, u16, bool)]) -> Packet {
        let mut packet = Packet::new(Size::new(4, 6), 1);
        packet.events = events
            .iter()
            .map(|(t, x, y, on)| Event {
                t: Micros(*t),
                x: *x,
                y: *y,
                polarity: Polarity::of(*on),
                channel: 0,
            })
            .collect();
        packet.span = (Micros(0), Micros(1000));
        packet
    }
}
