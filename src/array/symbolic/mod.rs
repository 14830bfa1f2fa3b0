//! Programs on linear forms and intervals: the kernel that a program computes, and its ranges.

mod capture;
mod form;
mod pixel;
pub mod range;
pub mod taps;

pub use capture::{CaptureError, check_capture};
pub use form::Input;
pub(super) use pixel::reach;
pub use pixel::{GenericError, effort};
