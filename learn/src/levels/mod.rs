//! Kernels of few values: what the chip can compute.
//!
//! Training holds a kernel of any weights, the latent one, and draws it towards the nearest one in few
//! values, [`Levels::project`], until it is that. One scale is free, since thresholds absorb it.
//! [`Chip::compile`] says what the chip makes of it: words, halvings, noise, the least threshold;
//! [`search()`] looks among neighbours for one that is worth more there.

mod chip;
mod error;
mod list;
mod orbits;
mod project;
mod search;

pub use chip::{Chip, OnChip, memory_spread};
pub use error::LevelsError;
pub use list::{KNOWN, Levels};
pub use orbits::Symmetry;
pub use project::Projected;
pub use search::{Found, search};
