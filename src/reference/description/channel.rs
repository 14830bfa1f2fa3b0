//! One kind of cell: its kernel or resistor sheets, and its thresholds.

use crate::{kernel::Kernel, reference::surround::Surrounds};

/// One kind of cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What it is called.
    pub name: Option<String>,
    /// One kernel, or four for a 2x2 pattern; with sheets, the pixel alone.
    pub kernels: Vec<Kernel>,
    /// The resistor sheets that it sees through in place of a kernel.
    pub surrounds: Option<Surrounds>,
    /// As many thresholds as kernels.
    pub thresholds: Vec<Threshold>,
    /// The kernel that the memory is seen through; only for
    /// [`MemoryRule::AuthorsPixelStep`](super::MemoryRule).
    pub memory_kernel: Option<Kernel>,
    /// `ln(max(W u, 1e-8) + 1)` in place of `W u`: the released simulator's `log_temporal`. Only with a
    /// memory of the filtered signal.
    pub log_temporal: bool,
}

/// When a cell fires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// For ON events, above zero.
    pub on: f64,
    /// For OFF events, a positive magnitude.
    pub off: f64,
    /// Standard deviation of the fixed-pattern mismatch, same unit as the thresholds.
    pub sigma: f64,
}
