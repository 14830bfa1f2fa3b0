//! The trait of all number formats: how a real is held, and what arithmetic then means.

use std::fmt::Debug;

use super::{format::Format, real::Real};

/// How a real is held, and the arithmetic that follows from it.
pub trait Number: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// What is stored.
    type Held: Copy + Debug + Default + PartialOrd + Send + Sync + 'static;

    /// The float in which what follows from held numbers is computed: f32 where that holds
    /// them all, f64 otherwise.
    type Real: Real;

    /// Zero, as it is held.
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
