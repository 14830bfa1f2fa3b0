//! How a frame's events leave the chip, what each way costs, and which is the cheapest.
//!
//! A scan of events costs by the slot that is asked for, not by the event that is found; a scan
//! of bits costs by the row; a box, a count or a sum costs one call. Which is cheapest depends on
//! how many events a frame has ([`Demand`]) and on the times in the chip's data: [`Scans::plans`]
//! weighs them all. What is shared by `compile` and `feasibility` is here.

mod demand;
mod plan;
mod scans;
mod way;

pub use demand::Demand;
pub use plan::{Plan, choose};
pub use scans::Scans;
pub use way::Way;
