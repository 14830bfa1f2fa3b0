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
mod checkpoint;
mod dead_time;
mod error;
mod evaluate;
mod export;
mod fit;
mod folder;
mod judged;
mod kept;
mod lock;
pub mod need;
mod on_chip;
mod pilot;
mod price;
mod rate;
mod retrain;
mod run;
mod sources;
mod step;
mod trainee;

pub use batch::{Batch, Loss};
pub use dead_time::DeadTime;
pub use error::{PINNED, TrainError};
pub use export::sensor_text;
pub use fit::no_program;
pub use judged::Judged;
pub use run::{Job, Progress, Run, jobs};
pub use trainee::{State, Trainee, name};
