//! Bins over a stretch of time.

use super::Pair;
use crate::unit::Micros;

/// Bins over a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Bins {
    /// Centre of the first bin.
    pub first: Micros,
    /// Centre of the last bin.
    pub last: Micros,
    /// How many; at least 1.
    pub bins: usize,
}

impl Bins {
    /// Bins over all events of a pair; around zero when there is none.
    #[must_use]
    pub fn over(pair: &Pair, bins: usize) -> Self {
        let (first, last) = pair.span().unwrap_or_default();
        let bins = bins.max(1);
        Self { first, last, bins }
    }

    /// The whole of an event, in the units of [`Bins::place`]; never 0.
    pub(super) const fn unit(self) -> u64 {
        let length = self.last.0.saturating_sub(self.first.0);
        if length == 0 { 1 } else { length }
    }

    /// The bin before `t`, and the share that goes to the one after it.
    pub(super) fn place(self, t: u64) -> (usize, i128) {
        let (steps, unit) = (self.bins.saturating_sub(1) as u64, self.unit());
        let since = t.saturating_sub(self.first.0).min(unit);
        if self.last <= self.first {
            return (0, 0);
        }
        if let Some(at) = since.checked_mul(steps) {
            return ((at / unit) as usize, i128::from(at % unit));
        }
        let (at, unit) = (u128::from(since) * u128::from(steps), u128::from(unit));
        ((at / unit) as usize, (at % unit) as i128)
    }
}
