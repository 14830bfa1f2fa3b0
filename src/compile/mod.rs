//! From kernels to instruction words.
//!
//! A filter is found backwards, from the kernels to the input: each step removes the last bus word
//! and replaces the value that it stored by those that it read. Everything that a bus does in one
//! word is a step: up to four sources, neighbours among them, the negation by every store, halving
//! by two targets. So symmetry, separability, running sums and common subexpressions of several
//! kernels are found without being special cases. A `walk` over the kernel is the plan to beat; for
//! dense kernels, which have nothing of that, a `tour` with copies of the input is often
//! shorter, and is tried last.
//!
//! ```
//! use amacrine::{compile::{Effort, Request}, isa::Device, kernel::Kernel};
//!
//! let device = Device::scamp5();
//! let kernels = [Kernel::builtin("sobel-x").unwrap()];
//! let mut request = Request::new(&kernels, &device)?;
//! request.effort = Effort::states(20_000);
//! let filter = request.filter()?;
//! assert!(filter.words.len() <= 10);
//! # Ok::<(), amacrine::compile::CompileError>(())
//! ```

mod allocate;
mod beam;
mod bit_memory;
mod border_safe;
pub mod bound;
mod cell_kind;
mod comparison;
mod dark;
mod decided;
mod deciding;
mod decision;
mod digit;
mod error;
mod event_readout;
mod filter;
mod forecast;
mod found;
mod goals;
pub mod leaves;
mod linear_form;
mod listed;
mod naive_cost;
mod need;
mod noise;
mod one_bit;
mod plan;
mod plan_builder;
mod register_levels;
mod request;
mod rim;
mod route;
mod scale;
mod sensor;
mod separable;
mod shared_memory;
mod solve;
mod steady;
#[cfg(test)]
mod strategy;
mod survival;
mod tour;
mod walk;
mod wired;
mod words;

pub use bit_memory::{BitMemory, Restless};
pub use cell_kind::{CellKind, DriveMemory, FRAMES};
pub use decided::Decided;
pub use decision::{Compared, Decision};
pub use error::{CompileError, four_digits, largest_of_both_signs};
pub use event_readout::EventReadout;
pub use filter::Filter;
pub use forecast::{Forecast, Signal};
pub use naive_cost::naive_cost;
pub use need::{MEMORY_BITS, Need, carried, like_these};
pub use noise::FilterNoise;
pub use request::{Border, Effort, Objective, Request};
pub use sensor::{SensorProgram, brightest};
pub use words::check_words;
