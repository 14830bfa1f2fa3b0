//! The float model: ganglion cells that watch through a kernel and fire on change.
//!
//! One file a step, in the order of the paper (So & Wetzstein, *Neural Ganglion Sensors*,
//! arXiv 2504.13457):
//!
//! ```text
//! light ─ response ─ [drive] W * u ─ [memory] distance d ─ [fire] |d| > θ ─ [refractory] ─ trains ─┬─ [voxel] counts, voxels
//!                                        └──────────── what an event does to it ──────────────┘     └─ [list] events
//! ```
//!
//! `docs/reference.md` states every rule, and where the paper, the released code and this
//! model part.

mod cells;
mod description;
mod drive;
mod fire;
mod list;
mod memory;
mod noise;
mod refractory;
mod train;
mod voxel;

pub use description::{
    Border, Channel, Description, DescriptionError, Memory, PolarityRule, ReadFile, Refractory,
    RefractoryRule, Threshold,
};
pub use list::{EventList, Limit, WhenFull};
pub use noise::Noise;
pub use train::{Cell, Pair, Sink, Train};
pub use voxel::{Counts, VoxelGrid, bins};

use crate::{
    event::Packet,
    plane::{Plane, Size},
    scene::Frame,
    sensor::{Sensor, SensorError},
    unit::Micros,
};

use self::{cells::Cells, drive::Padded};

/// The float model of one sensor.
#[derive(Clone, Debug)]
pub struct Reference {
    description: Description,
    size: Size,
    limit: Limit,
    signal: Plane<f64>,
    padded: Padded,
    cells: Vec<Cells>,
    /// Time of the last frame, in seconds.
    last: Option<f64>,
    pairs: u64,
    report: Report,
}

/// What a run noticed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Report {
    /// Frame pairs seen.
    pub pairs: u64,
    /// Events made.
    pub events: u64,
    /// Crossings lost to the refractory period.
    pub lost_to_refractory: u64,
    /// Events of `raw-snap` cells that fired again though nothing they see had changed: on a
    /// still scene they go on for ever.
    pub livelocked: u64,
    /// Cells that fired without a sign of their own (`polarity = "pixel"`), and emitted nothing.
    pub without_sign: u64,
}

impl Reference {
    /// A sensor of `size` as `description` says; `seed` chooses its mismatch and noise.
    #[must_use]
    pub fn new(description: Description, size: Size, seed: u64) -> Self {
        let reach = description
            .channels
            .iter()
            .flat_map(|channel| channel.kernels.iter().chain(&channel.memory_kernel))
            .map(crate::kernel::Kernel::reach)
            .fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let cells = (0..description.channels.len())
            .map(|channel| Cells::new(&description, channel, size, seed))
            .collect();
        Self {
            description,
            size,
            limit: Limit::default(),
            signal: Plane::zeros(size.shape()),
            padded: Padded::new(size, reach),
            cells,
            last: None,
            pairs: 0,
            report: Report::default(),
        }
    }

    /// Sets the bound on event lists that [`Sensor::watch`] keeps.
    #[must_use]
    pub const fn with_limit(mut self, limit: Limit) -> Self {
        self.limit = limit;
        self
    }

    /// What this sensor is.
    #[must_use]
    pub const fn description(&self) -> &Description {
        &self.description
    }

    /// What the run so far noticed.
    #[must_use]
    pub const fn report(&self) -> Report {
        self.report
    }

    /// The memory of a channel, `[y, x]`, in the unit of the drive (or of the signal, for
    /// pixel memories); `None` before the first frame.
    #[must_use]
    pub fn memory(&self, channel: usize) -> Option<Plane<f64>> {
        self.cells.get(channel)?.memory()
    }

    /// Watches one frame and tells `sink` of the trains since the frame before.
    ///
    /// The first frame sets the memory; the sink hears nothing of it.
    ///
    /// # Errors
    /// When the frame has another size, is not later than the last, holds light that the
    /// response is not defined for, or the sink or the memory cannot take more.
    pub fn watch_into<S: Sink>(&mut self, frame: &Frame, sink: &mut S) -> Result<(), SensorError> {
        self.see(frame)?;
        let Some(from) = self.last.replace(frame.seconds) else {
            for cells in &mut self.cells {
                cells.settle(&self.description, &self.signal, &mut self.padded);
            }
            return Ok(());
        };
        let pair = Pair {
            index: self.pairs,
            from,
            to: frame.seconds,
        };
        self.pairs += 1;
        self.report.pairs += 1;
        sink.begin(pair);
        for cells in &mut self.cells {
            cells.advance(
                &self.description,
                &self.signal,
                &mut self.padded,
                pair,
                sink,
                &mut self.report,
            )?;
        }
        Ok(())
    }

    /// Light to signal, with a rim.
    fn see(&mut self, frame: &Frame) -> Result<(), SensorError> {
        let (index, seconds) = (frame.index, frame.seconds);
        let got = Size::of(&frame.light);
        if got != self.size {
            return Err(SensorError::Size {
                index,
                got,
                want: self.size,
            });
        }
        if self
            .last
            .is_some_and(|last| seconds.partial_cmp(&last) != Some(std::cmp::Ordering::Greater))
        {
            return Err(SensorError::Time { index, seconds });
        }
        for ((y, x), &light) in frame.light.indexed_iter() {
            let signal = self.description.response.apply(light);
            self.signal[[y, x]] =
                signal.map_err(|cause| SensorError::Light { index, y, x, cause })?;
        }
        Ok(())
    }
}

impl Sensor for Reference {
    fn name(&self) -> &str {
        &self.description.name
    }

    fn size(&self) -> Size {
        self.size
    }

    fn channels(&self) -> u8 {
        self.cells.len() as u8
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        if self.last.is_none() {
            packet.span.0 = Micros::from_seconds(frame.seconds);
        }
        let mut list = EventList::new(packet, self.limit);
        self.watch_into(frame, &mut list)?;
        list.finish();
        packet.span.1 = Micros::from_seconds(frame.seconds);
        Ok(())
    }
}
