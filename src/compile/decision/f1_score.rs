//! What a trial on moving light says of a filter.

/// Shares of events within this are equal.
const EQUAL_F1: f64 = 0.01;

/// How well a filter decides on light that moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Decided {
    /// F1 of the events as silicon, the mean of all kinds of light: 1 where all are those of the
    /// kernel itself.
    pub silicon: f64,
    /// F1 in exact arithmetic with registers of the chip's range, of the kind of light of which it
    /// is least: 1 where nothing saturates.
    pub exact: f64,
    /// Whether the kernel itself has an event on this light: where not, there is nothing to keep.
    #[serde(skip)]
    pub(super) any: bool,
}

impl Decided {
    /// Whether there is an event to keep: a threshold beyond all that light changes leaves none.
    #[must_use]
    pub const fn has_events(&self) -> bool {
        self.any
    }

    /// Both in steps of what is told apart, as silicon first.
    pub(in crate::compile) fn steps(&self) -> [i64; 2] {
        [self.silicon, self.exact].map(|f1| (f1 / EQUAL_F1).round() as i64)
    }
}
