//! **If the retina's computation is moved into the pixels, what does real silicon do to it?**
//!
//! One scene is watched by two sensors at once, and a ruler compares what they say.
//!
//! ```text
//!                   ┌── photoreceptor ─ reference ── the float model: equations, f64 ──┐
//! scene ────────────┤                                                                  ├─ packets ─ compare ─ study ─ report
//! light over time   └── array ── a program on silicon, in any arithmetic ──────────────┘     │
//!                          ▲                                                            readout, codec, files
//!    kernel ─ quantise ─ compile ─ program      isa/ (the chip, as data)
//! ```
//!
//! The rooms stand by their name. Imports run downward only
//! (`docs/architecture.md` holds the table, `tests/layers.rs` holds the code to it).
//! The last room, `cli`, belongs to the program (`src/main.rs`).

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod aligned;
pub mod bits;
pub mod bundled;
pub mod catch_panic;
pub mod config;
pub mod elementary;
pub mod limit;
pub mod memory;
pub mod mosaic;
pub mod npy;
mod order;
mod parallel;
pub mod plane;
pub mod rng;
pub mod save;
pub mod source;
pub mod stop;
pub mod unit;

pub mod number;

pub mod event;
pub mod isa;
pub mod kernel;
pub mod mesh;
pub mod photoreceptor;
pub mod scene;

pub mod compare;
pub mod picture;
pub mod program;
pub mod sensor;

pub mod array;
pub mod compile;
pub mod reference;
pub mod rig;

pub mod gradient;
#[cfg(feature = "proptest")]
pub mod property;
pub mod study;
