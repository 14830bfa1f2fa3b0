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
}

impl Decided {
    /// Both in steps of what is told apart, as silicon first.
    pub(super) fn steps(&self) -> [i64; 2] {
        [self.silicon, self.exact].map(|f1| (f1 / EQUAL_F1).round() as i64)
    }
}
