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
//! [`Domain`]: what a cell holds and how the summing bus treats it. `engine` does the same on rows,
//! many pixels at once. A [`Chip`] is a program on an array in one domain; it is a
//! [`Sensor`](crate::sensor::Sensor), so light goes in and events come out.

mod answer;
mod arithmetic;
mod at_end;
mod bits;
mod check;
mod chip;
pub mod claim;
mod crossing;
mod domain;
mod each;
mod engine;
mod fixed;
mod float;
mod host;
mod layout;
mod ledger;
mod propagate;
mod readout;
mod register;
mod schedule;
pub mod semantics;
mod settings;
mod silicon;
mod state;
pub mod survival;
mod symbolic;
mod unheld;

pub use answer::answered;
pub use arithmetic::{Arithmetic, ArithmeticError};
pub use at_end::AtEnd;
pub use bits::BitPlane;
pub use check::{CodeError, CodeProblem, check};
pub use chip::{Array, Body, Chip, RunError, ShapeError};
pub use domain::{Ageing, Domain, Place, RowOps, Share, Undecided};
pub use fixed::Fixed;
pub use float::{Bfloat, Exact, Half, Single};
pub use host::{Reading, Readings};
pub use layout::Layout;
pub use ledger::Ledger;
pub use readout::Scanned;
pub use register::{Register, UnknownRegister};
pub use schedule::{Schedule, ScheduleError};
pub use settings::{Converters, Propagation, Settings};
pub use silicon::Silicon;
pub use state::State;
pub use symbolic::{CaptureError, GenericError, Input, check_capture, effort, range, taps};
pub use unheld::Unheld;
