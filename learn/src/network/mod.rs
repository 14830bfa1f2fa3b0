//! Networks: layers, their derivatives, and the optimiser.
//!
//! They are written here because the framework that was measured takes 2.8 times as long as
//! `PyTorch` on one core, and these 1.3 times (`docs/learning.md`). Pictures are worked on four at a
//! time, and sums over a batch are taken in its order, so everything has the same bits on any
//! number of threads.

mod adam;
mod convolution;
mod maps;
mod resample;
mod unet;

pub use adam::Adam;
pub use maps::{Maps, Shape};
pub use unet::{Network, PICTURES, Packed, Plan, Seen};

#[cfg(test)]
mod tests;
