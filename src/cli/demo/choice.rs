//! What the demo shows: a kernel, the few values that it is carried in, and arithmetics.

/// The kernel of the demo.
pub(super) const KERNEL: &str = "rgc-5x5";

/// The few values that the chip can carry it in: what `feasibility` chooses of its candidates
/// for this kernel and clip. `tests/demo.rs` makes the choice again.
pub(super) const CHOSEN: &str = "int-5";

/// Fewer values, for comparison.
pub(super) const FEWER: &str = "ternary";

/// An event where kernel times light (0 to 255) moved by more than this.
pub(super) const THRESHOLD: f64 = 128.0;

/// What the array computes in, and what that is.
pub(super) const DOMAINS: [(&str, &str); 3] = [
    ("exact", "without any error"),
    ("q8.8", "in 16-bit fixed point"),
    ("silicon", "with the errors of one modelled chip"),
];

/// Which of them the pictures show.
pub(super) const SHOWN: &str = "silicon";
