//! Counters of a run of the float model.

use crate::sensor::Overflowed;

/// Counters of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Report {
    /// Number of events.
    pub events: u64,
    /// Crossings lost to the refractory period.
    pub lost_to_refractory: u64,
    /// Events of `raw-snap` cells that fired again though nothing they see had changed: on a
    /// still scene they go on for ever.
    pub livelocked: u64,
    /// Cells that fired without a sign of their own (`polarity = "pixel"`), and emitted nothing.
    pub without_sign: u64,
    /// Pairs of frames that are not further apart than the refractory period of the authors' rule, in
    /// which no cell fires.
    pub muted_pairs: u64,
    /// Drives of each frame, and what they are compared with, that the number format does not hold:
    /// only in fixed point, as floats beyond their range are refused.
    pub overflowed: Overflowed,
}
