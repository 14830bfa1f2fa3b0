//! Whether a kernel can run in the pixels of a chip, what that takes, and what is lost.
//!
//! One scene, watched by the float sensor, by a plain DVS at the same threshold, and by the
//! compiled program on the array, without the chip's errors and with them. Besides: the program
//! store, registers and time; the kernel in other few values; a resistor mesh instead; power and
//! link as intervals. What the public data leave open is drawn, not fixed: [`chips`] runs the
//! program on chips whose numbers lie where the data allow them. [`verdict`] says in words what
//! the numbers say, by rules that it states; [`mod@explain`] says what a number is made of.
//!
//! `docs/feasibility.md` derives every number; [`report`](super::report) makes a page of it.

mod answer;
mod ask;
mod assumption;
mod at_rate;
pub mod chip;
pub mod chips;
mod choice;
mod draw;
mod error;
pub mod estimate;
pub mod explain;
pub mod named;
pub mod power;
mod question;
pub mod readout;
mod reply;
mod runs;
mod several;
mod shared;
mod snapshot;
pub mod stream;
pub mod time;
pub mod tornado;
pub mod verdict;
mod watched;

pub use answer::{ChipSummary, Chosen, Feasibility, Fit, KernelSummary, Streams};
pub use assumption::Assumption;
pub use at_rate::{AtRate, at_rate};
pub use choice::ALIKE;
pub use error::FeasibilityError;
pub use estimate::Estimate;
pub use explain::explain;
pub use question::Question;
pub use reply::{Reply, ask};
pub use several::Several;
pub use shared::{Shared, SharedFit, SharedKind, SharedProgram};
pub use snapshot::Snapshot;
pub use stream::Stream;
pub use watched::SceneSummary;
