//! Limits of a point, beyond which it is given up: time and memory.
//!
//! Both are looked at between two frames; a frame that has begun is finished.

use std::fmt;

use super::refusal::Refusal;
use crate::{event::Event, plane::Size, scene::SceneError, sensor::SensorError};

/// Seconds since some moment.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// The limits of a point.
#[derive(Clone, Copy)]
pub struct Limits<'a> {
    /// The present time.
    pub clock: Clock<'a>,
    /// Seconds for a sensor to watch its scene, and as many for the f64 sensor that it is
    /// measured against.
    pub seconds: Option<f64>,
    /// Bytes of one point at a time.
    pub bytes: Option<u64>,
}

impl fmt::Debug for Limits<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Limits")
            .field("seconds", &self.seconds)
            .field("bytes", &self.bytes)
            .finish_non_exhaustive()
    }
}

/// Memory per pixel in bytes: two sensors with up to 24 planes of eight bytes each (light, drives,
/// memories, registers, counts).
const PIXEL: u128 = 2 * 24 * 8;

/// Memory per pixel of each kind of cells beyond the first: two sensors with up to twelve planes
/// of its own (drives, memories, thresholds, counts, times).
const KIND: u128 = 2 * 12 * 8;

/// Memory per event in bytes: in its list as it grows, sorted by cell for comparison, in the list
/// of the sensor that it is measured against, and drawn anew.
const EVENT: u128 = 5 * size_of::<Event>() as u128;

/// A limit was reached.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub(in crate::study::sweep) enum Exhausted {
    /// Time.
    #[error("it took more than {0} s")]
    #[diagnostic(help("raise --max-seconds-per-point"))]
    Seconds(f64),
    /// Memory.
    #[error("it needs {need} bytes (with {events} events); the limit is {may}")]
    #[diagnostic(help("raise --max-memory, or lower --jobs: points share it"))]
    Bytes { need: u128, events: usize, may: u64 },
}

impl Exhausted {
    /// As the reason of a point.
    pub fn given_up(&self) -> Refusal {
        Refusal::given_up(self)
    }
}

impl Limits<'_> {
    /// Whether sensors of a size and so many kinds of cells fit at all.
    pub(super) fn fits(&self, size: Size, kinds: usize) -> Result<(), Exhausted> {
        self.hold(0.0, (size, kinds), 0)
    }

    /// Whether a point that has taken so long, and holds so many events, may go on.
    pub(in crate::study::sweep) fn hold(
        &self,
        seconds: f64,
        (size, kinds): (Size, usize),
        events: usize,
    ) -> Result<(), Exhausted> {
        if let Some(most) = self.seconds.filter(|most| seconds > *most) {
            return Err(Exhausted::Seconds(most));
        }
        let need = need(size, kinds, events);
        match self.bytes {
            Some(may) if need > u128::from(may) => Err(Exhausted::Bytes { need, events, may }),
            _ => Ok(()),
        }
    }
}

/// Upper bound on the memory of a point, bytes.
fn need(size: Size, kinds: usize, events: usize) -> u128 {
    let pixel = PIXEL + kinds.saturating_sub(1) as u128 * KIND;
    size.height as u128 * size.width as u128 * pixel + events as u128 * EVENT
}

/// Why a scene or a sensor stopped.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(in crate::study::sweep) enum Stop {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Exhausted(#[from] Exhausted),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_takes_room() {
        let size = Size::new(10, 10);
        let limits = Limits {
            clock: &|| 0.0,
            seconds: None,
            bytes: Some(2 * 100 * PIXEL as u64),
        };
        assert_eq!(limits.fits(size, 1), Ok(()));
        assert_eq!(limits.fits(size, 3), Ok(()));
        assert!(matches!(limits.fits(size, 4), Err(Exhausted::Bytes { .. })));
    }
}
