//! Rounding without an instruction for it.

/// 2^52: the first double after which there are no fractions. Added to it, a number from 0 to
/// 2^52 is rounded to a whole one, which stands in the lowest bits.
pub(super) const TWO_52: f64 = 4_503_599_627_370_496.0;
