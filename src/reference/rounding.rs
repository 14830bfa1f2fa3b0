//! Rounding to integers by adding 2^52.

/// 2^52: doubles of this size are integers. A number from 0 to 2^52 that is added to it is rounded
/// to an integer, which is then in the lowest bits.
pub(super) const TWO_52: f64 = 4_503_599_627_370_496.0;
