//! Static analysis: what a text says without being run.
//!
//! - [`effects`]: what a statement could do, for branches of which only the run of the program knows
//!   whether they are taken.
//! - [`static_type`]: the type of an expression.
//! - [`free_variables`]: what the block of a kernel reads of the variables around it.
//! - [`unreachable`]: kernels that no run reaches.

pub(super) mod effects;
pub(super) mod free_variables;
mod static_type;
pub(super) mod unreachable;
