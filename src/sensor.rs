//! What the reference and the device have in common: light in, events out.

use crate::{event::Packet, plane::Size, scene::Frame};

/// A sensor that watches a scene frame by frame.
pub trait Sensor {
    /// A short name for tables and pictures.
    fn name(&self) -> &str;

    /// Size of the sensor, in pixels.
    fn size(&self) -> Size;

    /// Kinds of cells per pixel.
    fn channels(&self) -> u8;

    /// Watches one frame and appends to `packet` what happened since the frame before.
    ///
    /// The first frame sets the memory and emits nothing.
    ///
    /// # Errors
    /// When the frame has another size than the sensor, or the sensor cannot go on.
    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError>;
}

/// Why a sensor cannot go on.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SensorError {
    /// A frame of another size than the sensor.
    #[error("frame {index} is {got}, the sensor is {want}")]
    #[diagnostic(help("all frames of a scene must have the size of the sensor"))]
    Size {
        /// Which frame.
        index: u64,
        /// Its size.
        got: Size,
        /// The sensor's size.
        want: Size,
    },
    /// The sensor itself stopped.
    #[error("{sensor} stopped: {why}")]
    #[diagnostic(help("mend the sensor's program or settings at the place that is named"))]
    Stopped {
        /// Which sensor.
        sensor: String,
        /// What it says.
        why: String,
    },
}
