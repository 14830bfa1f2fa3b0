//! Event frames of a recording that comes part by part.

use super::{
    error::{TensorError, room},
    frame::{Fill, draw},
    sides::Sides,
};
use crate::{
    event::{Event, outside},
    plane::Size,
};

/// The event frames of events that come part by part: those that [`frames`](super::frames) makes.
#[derive(Clone, Debug)]
pub struct FrameStream {
    each: usize,
    sides: Sides,
    fill: Fill,
    size: Size,
    channels: u8,
    /// Events in the frame that has begun.
    drawn: usize,
    frame: Vec<i32>,
}

impl FrameStream {
    /// No events yet, of a sensor of this size with so many kinds of cells; frames of `each` events.
    ///
    /// # Errors
    /// When a frame is more than this machine holds.
    pub fn new(
        each: usize,
        sides: Sides,
        fill: Fill,
        size: Size,
        channels: u8,
    ) -> Result<Self, TensorError> {
        let planes = usize::from(channels) * sides.count();
        let cells = room(1, "event frames", size.pixels().saturating_mul(planes))?;
        Ok(Self {
            each: each.max(1),
            sides,
            fill,
            size,
            channels,
            drawn: 0,
            frame: vec![0; cells],
        })
    }

    /// The shape of a frame: kinds of cells, sides, rows, columns.
    #[must_use]
    pub const fn shape(&self) -> [usize; 4] {
        [
            self.channels as usize,
            self.sides.count(),
            self.size.height,
            self.size.width,
        ]
    }

    /// Takes in the next events, in the order of their times, and passes on each frame that is full.
    ///
    /// # Errors
    /// When an event lies outside of the sensor; the first of `pass`.
    pub fn pass<E: From<TensorError>>(
        &mut self,
        events: &[Event],
        mut pass: impl FnMut(&[i32]) -> Result<(), E>,
    ) -> Result<(), E> {
        outside::check(events, self.size, self.channels).map_err(TensorError::from)?;
        let mut rest = events;
        while !rest.is_empty() {
            let (now, later) = rest.split_at(rest.len().min(self.each - self.drawn));
            draw(now, self.size, self.sides, self.fill, &mut self.frame);
            self.drawn += now.len();
            if self.drawn == self.each {
                pass(&self.frame)?;
                self.frame.fill(0);
                self.drawn = 0;
            }
            rest = later;
        }
        Ok(())
    }

    /// The last frame, where it has fewer events than the others, and their number.
    #[must_use]
    pub fn rest(&self) -> Option<(&[i32], usize)> {
        (self.drawn > 0).then_some((&self.frame, self.drawn))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{
        event::{
            Packet, Polarity,
            tensor::{Alignment, SurfaceStream, TimeSurface, Windows, frames},
        },
        unit::Micros,
    };

    const SIZE: Size = Size {
        height: 2,
        width: 3,
    };

    fn packet() -> impl Strategy<Value = Packet> {
        let event = (0u64..2000, 0u16..3, 0u16..2, 0u8..2, any::<bool>()).prop_map(
            |(t, x, y, channel, on)| Event {
                // Several at one time.
                t: Micros(t / 8 * 8),
                x,
                y,
                polarity: Polarity::of(on),
                channel,
            },
        );
        proptest::collection::vec(event, 0..200).prop_map(|mut events| {
            events.sort_by_key(|event| event.t);
            let mut packet = Packet::new(SIZE, 2);
            packet.events = events;
            packet
        })
    }

    proptest! {
        /// However the parts are cut, frames and surfaces are those of the whole packet.
        #[test]
        fn parts_give_the_same(packet in packet(), each in 1usize..50, part in 1usize..60, split: bool, last: bool) {
            let sides = if split { Sides::Split } else { Sides::Signed };
            let fill = if last { Fill::Last } else { Fill::Count };
            let mut stream = FrameStream::new(each, sides, fill, SIZE, 2).unwrap();
            let mut got = Vec::new();
            for events in packet.events.chunks(part) {
                stream.pass(events, |frame| {
                    got.extend_from_slice(frame);
                    Ok::<(), TensorError>(())
                }).unwrap();
            }
            got.extend(stream.rest().map(|(frame, _)| frame).unwrap_or_default());
            prop_assert_eq!(got, frames(&packet, each, sides, fill).unwrap());

            let end = Micros(2000);
            let windows = Windows::new(24e-6, 24e-6, Alignment::Causal).unwrap();
            let mut how = TimeSurface::new(1e-4).unwrap();
            how.sides = sides;
            let times = (0..windows.count(end)).map(|n| Micros(windows.bounds(n).1.cast_unsigned()));
            let times: Vec<Micros> = times.collect();
            let mut stream = SurfaceStream::new(how, windows, SIZE, 2).unwrap();
            let mut got = Vec::new();
            for events in packet.events.chunks(part) {
                stream.pass(events, |surface| {
                    got.extend_from_slice(surface);
                    Ok::<(), TensorError>(())
                }).unwrap();
            }
            got.extend(std::iter::from_fn(|| stream.next_left(end)).flatten());
            prop_assert_eq!(got, how.of(&packet, &times).unwrap());
        }
    }
}
