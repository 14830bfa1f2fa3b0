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
//! A scene, two sensors, and what their packets have in common:
//!
//! ```
//! use amacrine::{
//!     compare::Pair,
//!     reference::{Description, Reference},
//!     rig,
//!     scene::{OpenOptions, open},
//! };
//!
//! let disc = "pattern:disc?width=64&height=48&frames=30";
//! let mut scene = open(disc, &OpenOptions::default())?;
//! let size = scene.size();
//! let mut one = Reference::new(Description::open("dvs-clean")?, size, 0)?;
//! let mut other = Reference::new(Description::open("dvs-noisy")?, size, 0)?;
//! let packets = rig::watch(&mut *scene, &mut [&mut one, &mut other], |_| ())?;
//! let [clean, noisy] = Pair::new(&packets[0], &packets[1])?.events();
//! assert!(clean > 0 && noisy > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | for | go to |
//! |---|---|
//! | light: clips, pictures, arrays, patterns | [`scene`] |
//! | a sensor of the float model, from a file or made in code | [`reference`](mod@reference) |
//! | a sensor of one's own | the trait [`sensor::Sensor`] |
//! | kernels, and the few values of a chip | [`kernel`], [`kernel::quantise`] |
//! | a program for a chip: compiled, parsed, run | [`compile`], [`program`], [`array`](mod@array) |
//! | events: files, readouts, tensors for networks | [`event`] |
//! | how far two packets agree | [`compare`] |
//! | gradients of kernels and thresholds | [`gradient`] |
//! | whole studies, as the command line makes them | [`study`] |
//!
//! | feature | default | what it adds |
//! |---|---|---|
//! | `cli` | yes | the program `amacrine` |
//! | `mp4` | yes | scenes of mp4 files |
//! | `mcap` | yes | recordings for viewers |
//! | `hdf5` | | event files of HDF5 |
//! | `parquet` | | event files of Parquet, and tables of sweeps |
//! | `proptest` | | `property`: strategies, and property tests of a design |
//!
//! The library alone is `default-features = false`. Errors are types of their own with a help
//! ([`miette::Diagnostic`]); nothing of the library prints.
//!
//! The rooms stand by their name. Imports run downward only
//! (`docs/architecture.md` holds the table, `tests/layers.rs` holds the code to it).
//! The last room, `cli`, belongs to the program (`src/main.rs`).

#![warn(clippy::disallowed_methods)]
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod advice;
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
pub mod told;
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
