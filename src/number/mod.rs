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
mod dyadic;
mod fixed;
mod float;
mod format;
mod halves;
mod real;
mod signed_digits;
mod visit;

pub use bound::gamma;
pub use dyadic::Dyadic;
pub use fixed::{Overflow, Q, Wide, Width, divide};
pub use float::{Bf16, F16, F32, F64};
pub use format::{FixedFormat, Format, FormatError};
pub(crate) use halves::{bf16_to_f32, f16_to_f32, f32_to_bf16, f32_to_f16};
pub use real::Real;
pub use signed_digits::signed_digits;
pub use visit::Visitor;

use std::fmt::Debug;

/// How a real is held, and the arithmetic that follows from it.
pub trait Number: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// What is stored.
    type Held: Copy + Debug + Default + PartialOrd + Send + Sync + 'static;

    /// The float in which what follows from held numbers is computed: f32 where that holds
    /// them all, f64 otherwise.
    type Real: Real;

    /// Nought, as it is held.
    const ZERO: Self::Held;

    /// The name of this format.
    fn format(&self) -> Format;

    /// The nearest that can be held, halves to even.
    ///
    /// Floats overflow to infinity. Fixed point saturates, or wraps where it was made so; an
    /// infinity saturates in both, and NaN becomes 0.
    fn hold(&self, real: f64) -> Self::Held;

    /// What is held, exactly.
    fn value(&self, held: Self::Held) -> f64;

    /// What is held, exactly.
    fn real(&self, held: Self::Held) -> Self::Real;

    /// The nearest that can be held, as [`Number::hold`].
    fn hold_real(&self, real: Self::Real) -> Self::Held;

    /// The sum, rounded once.
    fn add(&self, a: Self::Held, b: Self::Held) -> Self::Held;

    /// The difference, rounded once.
    fn sub(&self, a: Self::Held, b: Self::Held) -> Self::Held;

    /// The product, rounded once.
    fn mul(&self, a: Self::Held, b: Self::Held) -> Self::Held;
}
