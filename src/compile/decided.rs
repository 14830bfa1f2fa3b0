//! What a trial on moving light says of a filter.

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
