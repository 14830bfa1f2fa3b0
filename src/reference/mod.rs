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
//! [`model`] is the same for one cell, with numbered equations: the definition that the rows are
//! held to. `docs/reference.md` states every rule, and where the paper, the released code and this
//! model part.

mod any_format;
mod band;
mod bytes;
mod counts;
mod description;
pub(crate) mod drive;
pub(crate) mod fire;
mod firing;
mod list;
mod low_pass;
pub(crate) mod memory;
pub mod model;
mod noise;
mod noise_event;
mod reason;
pub(crate) mod refractory;
mod report;
mod rounding;
mod sensor;
mod sheets;
pub(crate) mod signal;
mod sinks;
pub(crate) mod step;
mod surround;
mod tally;
pub(crate) mod thresholds;
mod train;
mod voxel;

pub use any_format::{AnyReference, Sinks};
pub use bytes::StateBytes;
pub use counts::{CountBand, Counts};
pub use description::{
    Alone, Border, ChangeError, Channel, Description, Effect, InBetween, Influence, MemoryRule,
    OpenError, PolarityRule, ReadFile, Refractory, RefractoryRule, Region, Stage, Threshold, keys,
};
pub use firing::{Firing, FiringBand};
pub use list::{EventList, Limit, ListBand, WhenFull};
pub use noise::Noise;
pub use report::Report;
pub use sensor::{Reference, bands_of};
pub use sheets::{SheetDrive, SheetSpec};
pub use surround::{SheetRule, Surround, Surrounds};
pub use tally::{Tally, TallyBand};
pub use train::{BandSink, Interval, Sink, Train, TrainRow};
pub use voxel::{VoxelBand, VoxelGrid, bins};
