//! What the reference and the device have in common: light in, events out.

use crate::{event::Packet, photoreceptor::LightError, plane::Size, scene::Frame};

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

impl<S: Sensor + ?Sized> Sensor for Box<S> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn size(&self) -> Size {
        (**self).size()
    }

    fn channels(&self) -> u8 {
        (**self).channels()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        (**self).watch(frame, packet)
    }
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
    /// A sensor without pixels, or with more than addresses.
    #[error("a sensor of {size} pixels cannot be addressed")]
    #[diagnostic(help("width and height must be from 1 to 65536"))]
    Addresses {
        /// The size.
        size: Size,
    },
    /// Light that the photoreceptor's response is not defined for.
    #[error("frame {index}, x = {x}, y = {y}: {cause}")]
    #[diagnostic(help(
        "give finite light, not below zero; a signal that may be negative needs response = \"identity\""
    ))]
    Light {
        /// Which frame.
        index: u64,
        /// Row.
        y: usize,
        /// Column.
        x: usize,
        /// What is wrong with it.
        cause: LightError,
    },
    /// A frame that is not later than the one before.
    #[error("frame {index} is at {seconds} s, not after the frame before it")]
    #[diagnostic(help("frames must come in order of time"))]
    Time {
        /// Which frame.
        index: u64,
        /// Its time.
        seconds: f64,
    },
    /// The event list has reached its bound.
    #[error("the event list is full: more than {limit} events")]
    #[diagnostic(help(
        "raise the thresholds or the limit (--max-events), ask for --counts or --voxels instead of --events, or choose to drop (--when-full drop)"
    ))]
    ListFull {
        /// How many events it may hold.
        limit: usize,
    },
    /// More steps of a memory than are counted.
    #[error(
        "the memory of the cell at x = {x}, y = {y} of channel {channel} is more than 2^30 thresholds from where it began"
    )]
    #[diagnostic(help(
        "the thresholds are too small for this light: raise them, or check the response"
    ))]
    Uncountable {
        /// Kind of cell.
        channel: usize,
        /// Row.
        y: usize,
        /// Column.
        x: usize,
    },
}
