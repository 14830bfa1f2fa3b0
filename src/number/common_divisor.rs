//! The greatest common divisor.

/// The greatest whole number that divides both, by Euclid's algorithm; 0 leaves the magnitude of the
/// other.
#[must_use]
pub const fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    let (mut a, mut b) = (a.abs(), b.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}
