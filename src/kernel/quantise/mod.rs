//! Quantisers: a kernel in few values, and the scale that brings it back.
//!
//! A kernel `w` becomes `s · l`: levels `l` that shifts, additions and halvings can make, and one
//! scale `s`. Comparing `s l * u` with a threshold `θ` is comparing `l * u` with `θ / s`, so
//! the scale costs nothing on a chip.
//!
//! [`ENTRIES`] is the list of quantisers; `docs/guides/from-kernel-to-chip.md` shows it.
//!
//! With [`Sum::Zero`] or [`Sum::Kept`] the levels are the nearest, at their scale, among those
//! whose sum is what was asked; where a kept sum is nearest to 0, they are those of a sum of 0.
//! For `ternary` and a sum of 0 the scale is the best as well, and
//! for `csd-D` the levels are only near: one weight after the other is moved where it hurts
//! least.

mod digits;
mod entry;
mod erasure;
mod error;
mod fixed;
mod levels;
mod list;
mod quantised;
mod response;
mod summary;
mod total;

pub use digits::FINEST;
pub use entry::{Chosen, Entry, Parameters, Quantiser, Rounding, Sum};
pub use erasure::Erasure;
pub use error::QuantiseError;
pub use list::{ENTRIES, QuantiserNameError, known, pattern};
pub use quantised::Quantised;
pub use response::Change;
pub use summary::Summary;

#[cfg(test)]
mod tests;
