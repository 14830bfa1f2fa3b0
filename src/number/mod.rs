//! How a real is held: f64, f32, f16, bf16 and fixed point.
//!
//! A [`Number`] is a small value that knows how to hold a real in so many bits, and what
//! adding and multiplying then mean. It is a value and not only a type, because a fixed-point
//! format is chosen at run time: three widths of integer serve every Q format.
//!
//! ```
//! use amacrine::number::{Number, Q};
//!
//! let q = Q::<i16>::new(8);
//! assert_eq!(q.hold(1.0), 256);
//! assert_eq!(q.value(q.hold(1.0 / 512.0)), 0.0); // halfway: to even
//! assert_eq!(q.value(q.hold(1000.0)), 127.99609375); // saturates
//! ```
//!
//! Everything rounds to the nearest, halves to even, once an operation.

mod bound;
mod common_divisor;
mod dyadic;
mod fixed;
mod float;
mod format;
mod halves;
mod held;
mod real;
mod signed_digits;
mod visit;

pub use common_divisor::greatest_common_divisor;
pub use dyadic::Dyadic;
pub use fixed::{Q, Wide, Width, divide};
pub use float::{Bf16, F16, F32, F64};
pub(crate) use format::known_floats;
pub use format::{FIXED, FORMAT_PATTERN, FixedFormat, Format, FormatError, Overflow};
pub use halves::{HeldBf16, HeldF16};
pub use held::Number;
pub use real::Real;
pub use signed_digits::signed_digits;
pub use visit::Visitor;
