//! How much of what cells see lies beyond what their numbers hold.

use std::ops::AddAssign;

/// Values that a number format does not hold, of those that were computed in it: drives, and the
/// differences that are compared with thresholds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Overflowed {
    /// How many are not held: cut off, or come in again at the other end.
    pub at: u64,
    /// Of how many; 0 where the format has no ends.
    pub of: u64,
}

impl AddAssign for Overflowed {
    fn add_assign(&mut self, other: Self) {
        self.at += other.at;
        self.of += other.of;
    }
}
