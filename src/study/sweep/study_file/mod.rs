//! The study file: which points are asked for, and what is measured of each.
//!
//! - [`study`]: the file as a whole; [`sides`]: its sides, each with its axes.
//! - [`key`]: the one table of its keys; [`key_values`]: from the text to the values of a key.
//! - [`overrides`]: keys set on the command line.
//! - [`schema`]: the same table as JSON Schema; [`stated`]: as words, in which two studies differ.

pub mod key;
pub(super) mod key_values;
pub mod overrides;
pub mod schema;
mod sides;
pub(super) mod stated;
pub mod study;
