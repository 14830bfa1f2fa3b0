//! **If the retina's computation is moved into the pixels, what does real silicon do to it?**
//!
//! One scene is watched by two sensors at once, and a ruler compares what they say.
//!
//! ```text
//!                        ┌── reference ── the float model: equations, f64 ──────────────┐
//! scene ─ photoreceptor ─┤                                                              ├─ packets ─ compare ─ study ─ report
//! light over time        └── array ── a program on silicon, in any arithmetic ──────────┘     │
//!                               ▲                                                        readout, codec, files
//!    kernel ─ quantise ─ compile ─ program      isa/ (the chip, as data)
//! ```
//!
//! The rooms, in the order in which light passes them. Imports run downward only
//! (`docs/architecture.md` holds the table, `tests/layers.rs` holds the code to it). Fuzzers take
//! in bytes from outside: they are built with the rooms that do so, in seconds.

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod bits;
pub mod chance;
pub mod elementary;
pub mod guard;
pub mod limit;
#[cfg(not(fuzzing))]
mod lined;
pub mod memory;
pub mod plane;
pub mod save;
pub mod source;
pub mod unit;

#[cfg(not(fuzzing))]
pub mod number;

pub mod event;
#[cfg(not(fuzzing))]
pub mod isa;
#[cfg(not(fuzzing))]
pub mod kernel;
#[cfg(not(fuzzing))]
pub mod mesh;
#[cfg(not(fuzzing))]
pub mod photoreceptor;
#[cfg(not(fuzzing))]
pub mod scene;

#[cfg(not(fuzzing))]
pub mod compare;
#[cfg(not(fuzzing))]
pub mod picture;
#[cfg(not(fuzzing))]
pub mod program;
#[cfg(not(fuzzing))]
pub mod sensor;

#[cfg(not(fuzzing))]
pub mod array;
#[cfg(not(fuzzing))]
pub mod compile;
#[cfg(not(fuzzing))]
pub mod reference;
#[cfg(not(fuzzing))]
pub mod rig;

#[cfg(all(feature = "proptest", not(fuzzing)))]
pub mod property;
#[cfg(not(fuzzing))]
pub mod study;

#[cfg(all(feature = "cli", not(fuzzing)))]
pub mod cli;
