//! The array: every pixel a small analogue processor, all in step.
//!
//! ```text
//!   frame ─► PIX ┐                        ┌─► registers, FLAG, NEWS of neighbours
//!                ├─► bus: -(sum)/n ─store─┤
//!   IN, A…F, NEWS┘   domain: how it      └─► one-bit registers ─► scan ─► events
//!                    adds and rounds
//! ```
//!
//! What each instruction word does is written once, for one cell, in [`semantics`], for any
//! [`Domain`]: what a cell holds and how the summing bus treats it. Rows do the same at once. A [`Chip`] is a program on an array in one
//! domain; it is a [`Sensor`](crate::sensor::Sensor), so light goes in and events come out.

mod active;
mod arithmetic;
mod band;
mod bits;
mod check;
mod chip;
mod cone;
mod domain;
mod each;
mod field;
mod fixed;
mod float;
mod form;
mod generic;
mod halves;
mod host;
mod layout;
mod ledger;
mod light;
mod live;
mod logic;
mod pair;
mod patch;
mod positive;
pub mod range;
mod readout;
mod rows;
mod runs;
mod schedule;
mod segment;
pub mod semantics;
mod settings;
mod silicon;
mod state;
mod store;
mod sweep;
pub mod taps;
mod tiled;
mod tiles;
mod walks;
mod window;
mod wire;

pub use arithmetic::{Arithmetic, ArithmeticError};
pub use bits::BitPlane;
pub use check::{CodeError, CodeProblem, check};
pub use chip::{Array, Chip, RunError, ShapeError};
pub use domain::{Domain, Place, Share, Undecided};
pub use fixed::Fixed;
pub use float::{Exact, Single};
pub use form::Input;
pub use generic::GenericError;
pub use halves::Halves;
pub use host::{Reading, Readings};
pub use layout::Layout;
pub use ledger::Ledger;
pub use readout::{Address, Scan};
pub use schedule::{Schedule, ScheduleError};
pub use settings::{Converters, Propagation, Settings};
pub use silicon::{Errors, Silicon};
pub use state::State;
