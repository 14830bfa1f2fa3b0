//! Kernels and thresholds of event sensors, learned for a task through the event generator of
//! `amacrine`, and judged at equal bits.
//!
//! A task file names scenes, a network, a loss and arms. An arm is a sensor: one that is given, or
//! one whose kernels are learned. Every arm is trained with the same network from the same start,
//! for as many steps, at the same number of events.

pub mod arm;
pub mod cli;
pub mod levels;
pub mod network;
pub mod record;
pub mod report;
pub mod scene;
pub mod task;
pub mod train;
