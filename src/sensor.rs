//! What the reference and the device have in common: light in, events out.

mod overflowed;
mod silence;

use crate::{
    event::Packet,
    number::Format,
    photoreceptor::LightError,
    plane::Size,
    scene::Frame,
    unit::{counted, five_digits},
};

pub use overflowed::Overflowed;
pub use silence::Silence;

/// A sensor that watches a scene frame by frame.
pub trait Sensor {
    /// A short name for tables and pictures.
    fn name(&self) -> &str;

    /// Size of the sensor, in pixels.
    fn size(&self) -> Size;

    /// Kinds of cells per pixel.
    fn channels(&self) -> u8;

    /// What the kinds of cells are called, for packets and files; none where they have no names.
    fn names(&self) -> Vec<String> {
        Vec::new()
    }

    /// Watches one frame and appends to `packet` what happened since the frame before, in order of
    /// time.
    ///
    /// The first frame sets the memory and emits nothing. Who shows the frames sets the packet's
    /// `span`, if this does not: [`rig::watch`](crate::rig::watch) does.
    ///
    /// # Errors
    /// When the frame has another size than the sensor, or the sensor cannot go on. A frame whose
    /// size, time or light is refused leaves a [`Reference`](crate::reference::Reference) and an array
    /// as they were, so that it can be shown repaired; what else is left after an error they say
    /// themselves.
    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError>;

    /// Why it has been silent in all frames so far, as far as it knows; for whoever saw no event.
    fn silence(&self) -> Silence {
        Silence::default()
    }

    /// How much of what its cells saw in all frames so far its number format did not hold, as far as
    /// it knows, and where that may change one in a hundred of its events.
    fn overflowed(&self) -> Overflowed {
        Overflowed::default()
    }
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

    fn names(&self) -> Vec<String> {
        (**self).names()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        (**self).watch(frame, packet)
    }

    fn silence(&self) -> Silence {
        (**self).silence()
    }

    fn overflowed(&self) -> Overflowed {
        (**self).overflowed()
    }
}

/// The furthest that a frame's time may be from 0, in seconds: 2^51 microseconds, 71 years.
/// Beyond, an `f64` of seconds no longer tells one microsecond from the next.
pub(crate) const MOST_SECONDS: f64 = 2_251_799_813.685_248;

/// Whether a frame comes after the one at `last`, at a time that events can have.
pub(crate) fn check_time(frame: &Frame, last: Option<f64>) -> Result<(), SensorError> {
    let Frame { index, seconds, .. } = *frame;
    if !seconds.is_finite() || last.is_some_and(|last| seconds <= last) {
        return Err(SensorError::Time { index, seconds });
    }
    if seconds.abs() > MOST_SECONDS {
        return Err(SensorError::Epoch { index, seconds });
    }
    Ok(())
}

/// The light of a frame that is furthest from 0, as its size; all of it must be a number.
pub(crate) fn brightest(frame: &Frame) -> Result<f64, SensorError> {
    const LANES: usize = 8;
    let mut most = [0.0f64; LANES];
    let mut numbers = [true; LANES];
    // In lanes, so that this runs in vectors.
    let mut look = |lane: usize, light: f64| {
        let size = light.abs();
        most[lane] = if size > most[lane] { size } else { most[lane] };
        numbers[lane] &= size <= f64::MAX;
    };
    let rows = frame.light.as_standard_layout();
    let (blocks, rest) = rows.as_slice().unwrap_or_default().as_chunks::<LANES>();
    for block in blocks {
        for (lane, light) in block.iter().enumerate() {
            look(lane, *light);
        }
    }
    for (lane, light) in rest.iter().enumerate() {
        look(lane, *light);
    }
    if numbers.contains(&false) {
        return Err(light_error(frame, |light| {
            (!light.is_finite()).then_some(LightError::NotFinite(light))
        }));
    }
    Ok(most.into_iter().fold(0.0, f64::max))
}

/// The first light of a frame that something is wrong with.
pub(crate) fn light_error(frame: &Frame, wrong: impl Fn(f64) -> Option<LightError>) -> SensorError {
    let mut cells = frame.light.indexed_iter();
    let first = cells.find_map(|((y, x), light)| Some((y, x, wrong(*light)?)));
    let (y, x, cause) = first.unwrap_or((0, 0, LightError::NotFinite(f64::NAN)));
    SensorError::Light {
        index: frame.index,
        y,
        x,
        cause,
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
    #[diagnostic(help("correct the sensor's program or settings at the place that is named"))]
    Stopped {
        /// Which sensor.
        sensor: String,
        /// What it says.
        why: String,
    },
    /// The sensor did not get through an earlier frame.
    #[error("{sensor} failed in an earlier frame, which only some of its cells have processed")]
    #[diagnostic(help(
        "make the sensor anew, or keep a copy of it from before a frame that may fail"
    ))]
    Halfway {
        /// Which sensor.
        sensor: String,
    },
    /// What is to take the events is for a sensor of another shape.
    #[error(
        "{sink} of {got} and {}, the sensor is {want} with {}",
        counted(*got_kinds, "kind of cells"), counted(*want_kinds, "kind of cells")
    )]
    #[diagnostic(help("make it with the size and the channels of the sensor"))]
    Sink {
        /// What it is.
        sink: &'static str,
        /// Its size.
        got: Size,
        /// Its kinds of cells.
        got_kinds: usize,
        /// The sensor's size.
        want: Size,
        /// The sensor's kinds of cells.
        want_kinds: usize,
    },
    /// A sensor without pixels, or with more than addresses.
    #[error("a sensor of {size} pixels cannot be addressed")]
    #[diagnostic(help(
        "width and height must be from 1 to 65536, and pixels no more than 4096 times 4096"
    ))]
    Addresses {
        /// The size.
        size: Size,
    },
    /// A sensor that cannot be.
    #[error("{sensor}: {what}")]
    #[diagnostic(help("{help}"))]
    Impossible {
        /// Which sensor.
        sensor: String,
        /// What cannot be.
        what: String,
        /// What can.
        help: &'static str,
    },
    /// Light that the photoreceptor's response is not defined for.
    #[error("frame {index}, x = {x}, y = {y}: {cause}")]
    #[diagnostic(help(
        "give finite light, not below zero, and no more than the number format holds; a signal that may be negative needs response = \"identity\""
    ))]
    Light {
        /// Which frame.
        index: u64,
        /// Row.
        y: usize,
        /// Column.
        x: usize,
        /// What is wrong with it.
        #[source]
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
    /// A frame at a time that events cannot have.
    #[error("frame {index} is at {seconds:e} s, too far from 0 to be counted in microseconds")]
    #[diagnostic(help(
        "let the scene begin near time 0, or raise its frame rate (--fps): event times reach 2^51 us, 71 years"
    ))]
    Epoch {
        /// Which frame.
        index: u64,
        /// Its time.
        seconds: f64,
    },
    /// The event list has reached its bound.
    #[error("the event list is full: more than {limit} events")]
    #[diagnostic(help(
        "raise the thresholds or the limit (--max-events, and --max-memory where there is no room for more); `amacrine run` also has --counts and --voxels instead of --events, and --when-full drop"
    ))]
    ListFull {
        /// How many events it may hold.
        limit: usize,
    },
    /// The events of a pair of frames have no room, before they are passed on.
    #[error("one pair of frames has more than {room} events, for which there is no memory")]
    #[diagnostic(help(
        "allow more with --max-memory SIZE, raise the thresholds, or insert frames (--upsample); `amacrine run` also has --counts and --voxels instead of --events, and --when-full drop"
    ))]
    PairFull {
        /// How many events there is room for.
        room: usize,
    },
    /// Weights times light that the number format cannot hold.
    #[error(
        "the filtered signal of the cell at x = {x}, y = {y} of channel {channel} exceeds the largest number of the format {format}"
    )]
    #[diagnostic(help(
        "use a wider format, smaller weights, or a response with smaller values for this light"
    ))]
    Overflow {
        /// Kind of cell.
        channel: usize,
        /// Row.
        y: usize,
        /// Column.
        x: usize,
        /// The format.
        format: Format,
    },
    /// A threshold that is so small that a memory's steps cannot be counted in it.
    #[error(
        "a threshold of channel {channel} is {threshold:e}, too small for the format {format}: its reciprocal is infinite, so crossings cannot be counted"
    )]
    #[diagnostic(help(
        "give {} or more, or scale response and thresholds up together",
        five_digits(*least)
    ))]
    Threshold {
        /// Kind of cell.
        channel: usize,
        /// The threshold.
        threshold: f64,
        /// The smallest that can be counted in.
        least: f64,
        /// The format.
        format: Format,
    },
    /// More steps of a memory than are counted.
    #[error(
        "the memory of the cell at x = {x}, y = {y} of channel {channel} is 2^30 thresholds or more from its first value"
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
