//! Points of a study: one sensor on one scene each.
//!
//! - [`point`]: a point; [`value`], [`thresholds`]: what its keys are set to.
//! - [`grid`]: every combination of the axes; [`sample`]: points drawn from it.
//! - [`plan`]: the points of a study with all that they name opened, each with its identity.

pub mod grid;
pub mod plan;
pub mod point;
pub mod sample;
pub mod thresholds;
pub mod value;
