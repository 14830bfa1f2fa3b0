//! The points of a plan, measured.
//!
//! - [`request`]: which points are asked for, and what they may take; [`limits`]: time and memory.
//! - [`run`]: all points of a plan on all cores; [`memo`]: what several of them need, made once.
//! - [`measure`]: one point; [`watch`]: its sensor is shown its scene; [`ground_truth`]: what it is
//!   compared with; [`refusal`]: why it has no result.
//! - [`fidelity`]: points that a pilot finds alike are computed once.

mod fidelity;
mod ground_truth;
pub mod limits;
pub(super) mod measure;
pub(super) mod memo;
pub(super) mod refusal;
pub mod request;
pub mod run;
mod watch;
