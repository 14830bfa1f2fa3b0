//! Training.
//!
//! ```text
//! clips ─┬─ light + noise ─ kernel ─ thresholds ─ events ─ voxels ─┬─ network ─ loss
//!        └───────────── the first and the last frame ──────────────┘
//! ```
//!
//! A step is a pure function of the seed and its number. The kernel moves along the surface of constant
//! rate, the thresholds follow the target of events: all arms are compared at equal bits.

mod batch;
mod error;
mod evaluate;
mod trainee;

pub use batch::{Batch, Loss};
pub use error::{PINNED, TrainError};
pub use trainee::{State, Trainee, name};
