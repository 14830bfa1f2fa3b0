//! A sensor with a stopwatch.

use std::time::{Duration, Instant};

use crate::{
    event::Packet,
    plane::Size,
    scene::Frame,
    sensor::{Sensor, SensorError},
};

/// A sensor, and the time it has spent on its frames.
#[derive(Debug)]
pub struct Timed<S> {
    /// The sensor.
    pub sensor: S,
    /// Time spent.
    pub spent: Duration,
    /// Frames seen.
    pub frames: u64,
}

impl<S: Sensor> Timed<S> {
    /// A sensor that has not seen anything yet.
    pub const fn new(sensor: S) -> Self {
        Self {
            sensor,
            spent: Duration::ZERO,
            frames: 0,
        }
    }

    /// Frames per second of computing.
    pub fn speed(&self) -> f64 {
        self.frames as f64 / self.spent.as_secs_f64()
    }
}

impl<S: Sensor> Sensor for Timed<S> {
    fn name(&self) -> &str {
        self.sensor.name()
    }

    fn size(&self) -> Size {
        self.sensor.size()
    }

    fn channels(&self) -> u8 {
        self.sensor.channels()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        let start = Instant::now();
        let watched = self.sensor.watch(frame, packet);
        self.spent += start.elapsed();
        self.frames += 1;
        watched
    }
}
