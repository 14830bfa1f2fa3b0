//! Time surfaces: how long ago each cell fired.

use std::str::FromStr;

use super::{
    error::{TensorError, check_room, named, time},
    last_event::{LastEvent, LastEvents},
    sides::Sides,
    sorted,
};
use crate::{
    elementary,
    event::{Packet, outside},
    plane::Size,
    unit::Micros,
};

/// How a cell forgets its last event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Decay {
    /// `exp(-age / tau)` (Lagorce et al., TPAMI 2017).
    #[default]
    Exponential,
    /// `1 - age / tau`, 0 from there on.
    Linear,
}

const NAMES: [(&str, Decay); 2] = [
    ("exponential", Decay::Exponential),
    ("linear", Decay::Linear),
];

impl FromStr for Decay {
    type Err = TensorError;

    fn from_str(text: &str) -> Result<Self, TensorError> {
        named(&NAMES, "decay", text)
    }
}

/// How events become time surfaces: at each time `[channel][side][y, x]`, 1 where a cell fires just
/// then, 0 where it never did; with [`Sides::Signed`] below 0 where its last event was OFF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSurface {
    tau: f64,
    /// How cells forget.
    pub decay: Decay,
    /// ON and OFF.
    pub sides: Sides,
}

impl TimeSurface {
    /// Surfaces that forget within `tau` seconds.
    ///
    /// # Errors
    /// When that is less than a microsecond, or not finite.
    pub fn new(tau: f64) -> Result<Self, TensorError> {
        Ok(Self {
            tau: time("tau", tau)?,
            decay: Decay::default(),
            sides: Sides::default(),
        })
    }

    /// The surfaces of a packet at these times, in any order: each has seen the events up to its
    /// time, that time among them.
    ///
    /// # Errors
    /// When an event lies outside of the packet, or the surfaces are more than this machine holds.
    pub fn of(&self, packet: &Packet, times: &[Micros]) -> Result<Vec<f32>, TensorError> {
        outside::check(&packet.events, packet.size, packet.channels)?;
        let held = self.held(packet.size, packet.channels, times.len());
        check_room(times.len() as u64, "time surfaces", held)?;
        let each = self.len(packet.size, packet.channels);
        let events = sorted(&packet.events);
        let mut order: Vec<usize> = (0..times.len()).collect();
        order.sort_by_key(|n| times[*n]);
        let mut out = vec![0.0; times.len() * each];
        let mut last = LastEvents::new(*self, packet.size, packet.channels);
        let mut rest = &events[..];
        for n in order {
            let (seen, later) = rest.split_at(rest.partition_point(|e| e.t <= times[n]));
            last.take(seen);
            last.surface(times[n], &mut out[n * each..(n + 1) * each]);
            rest = later;
        }
        Ok(out)
    }

    /// The shape of a surface: kinds of cells, sides, rows, columns.
    #[must_use]
    pub const fn shape(&self, size: Size, channels: u8) -> [usize; 4] {
        [
            channels as usize,
            self.sides.count(),
            size.height,
            size.width,
        ]
    }

    /// Values of a surface.
    #[must_use]
    pub fn len(&self, size: Size, channels: u8) -> usize {
        let sides = self.shape(size, channels);
        sides.into_iter().fold(1, usize::saturating_mul)
    }

    /// Bytes that are held when so many surfaces are made: they, and when each cell fired last.
    #[must_use]
    pub fn held(&self, size: Size, channels: u8, count: usize) -> u128 {
        let cells = self.len(size, channels) as u128;
        cells.saturating_mul(count as u128 * 4 + size_of::<LastEvent>() as u128)
    }

    /// What is left of an event of this age.
    pub(super) fn left(&self, age: Micros) -> f32 {
        let age = age.seconds() / self.tau;
        match self.decay {
            Decay::Exponential => elementary::exp(-age) as f32,
            Decay::Linear => (1.0 - age).max(0.0) as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        event::{Event, Polarity},
        plane::Size,
    };

    #[test]
    fn cells_forget() {
        let mut packet = Packet::new(Size::new(1, 2), 1);
        let event = |t, x, polarity| Event {
            t: Micros(t),
            x,
            y: 0,
            polarity,
            channel: 0,
        };
        // Not in order.
        packet.events = vec![event(3000, 0, Polarity::Off), event(1000, 0, Polarity::On)];
        let times = [Micros(3000), Micros(999), Micros(2000)];
        let mut surface = TimeSurface::new(0.002).unwrap();
        let half = (-0.5f64).exp() as f32;
        assert_eq!(
            surface.of(&packet, &times).unwrap(),
            [-1.0, 0.0, 0.0, 0.0, half, 0.0]
        );
        surface.sides = Sides::Split;
        surface.decay = Decay::Linear;
        let split = [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.5, 0.0],
        ];
        assert_eq!(surface.of(&packet, &times).unwrap(), split.concat());
    }
}
