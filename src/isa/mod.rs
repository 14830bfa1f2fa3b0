//! The chip as data: registers, primitives, macros, costs.
//!
//! A SCAMP-5 pixel can put registers on a summing bus (every store inverts), connect to a
//! neighbour's NEWS cell, set FLAG from a sign, do a few one-bit operations, propagate, and
//! diffuse. Those are the [`Primitive`]s; everything else (`mov`, `add`, `abs`, `XORX`, …)
//! is a macro, text in `isa/<chip>/macros.scamp`.

mod connection;
mod device;
mod direction;
mod errors;
mod extent;
mod figure;
mod interval;
mod left_out;
mod load;
pub mod macros;
mod names;
pub mod operands;
mod primitive;
mod registers;
mod role;
pub mod row;
pub mod signature;
mod substance;
pub mod text;
mod value;

pub use connection::{Analog, Bit, Digital, Source, Target};
pub use device::{Callable, Device, FigureError};
pub use direction::Direction;
pub use errors::{Errors, StoreTerms, added, split, stored, uneven};
pub use figure::{Evidence, Figure, FigureRange, Quantity};
pub use interval::Interval;
pub use left_out::LeftOut;
pub use load::{LoadError, keys};
pub use macros::Macro;
pub use operands::{Cell, Operands};
pub use primitive::Primitive;
pub use registers::{Registers, Roles};
pub use role::Role;
pub use row::{Clock, HostKind, HostRow, PrimitiveKind, PrimitiveRow};
pub use signature::{Operand, Signature};
pub use value::Value;
