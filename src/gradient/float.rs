//! The floats that gradients are computed in.

use crate::number::{F32, F64, Number, Real};

/// f32 or f64: a number format whose held numbers are reals.
pub trait Float: Real {
    /// The number format.
    type Number: Number<Held = Self, Real = Self>;

    /// Its value.
    const NUMBER: Self::Number;
}

impl Float for f32 {
    type Number = F32;
    const NUMBER: F32 = F32;
}

impl Float for f64 {
    type Number = F64;
    const NUMBER: F64 = F64;
}
