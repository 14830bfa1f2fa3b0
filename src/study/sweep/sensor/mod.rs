//! From a point to its sensor.
//!
//! - [`description`]: the text of the sensor, and of the f64 sensor that it is measured against.
//! - [`build`]: the float model, or the chip with its program; [`level_program`]: programs of kernels
//!   in few values.

pub(super) mod build;
pub(super) mod description;
pub(super) mod level_program;
