//! Property tests of a design against the float model (feature `proptest`).
//!
//! Strategies for what a design meets, and one question: does a program on the array say what a
//! sensor of the float model says, on whatever scene? A scene on which they part is shrunk to
//! the smallest that still shows it.
//!
//! ```
//! use amacrine::{isa::Device, program::Program, property::{Tolerance, assert_agrees}, reference::Description};
//!
//! let program = Program::parse("dvs", include_str!("../../programs/dvs/snap.scamp"))?;
//! let float = "memory = \"filtered-snap\"\nresponse = \"identity\"\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 20, off = 20 }\n";
//! let float = Description::parse("float", float, &|name| Err(std::io::Error::other(name.to_owned())))?;
//! assert_agrees(&program, &float, &Tolerance::default());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod agreement;
mod strategy;

pub use agreement::{Disagreement, Tolerance, agree, assert_agrees};
pub use strategy::{Clip, clips, devices, formats, kernels, programs};
