//! What a figure of a chip is for, as far as errors go.

/// The part that a figure has in a chip's errors. Whoever predicts, draws, leaves out or reports
/// errors asks for figures by it, so that a new one reaches all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A store errs by it: systematically, alike in all cells and in all words.
    Systematic,
    /// A store errs by it: fixed-pattern, each cell or pixel in its own way, the same in all words.
    Mismatch,
    /// A store errs by it: temporal noise, drawn anew for every word.
    Noise,
    /// It bounds what a register holds.
    Range,
    /// Registers and bits forget by it.
    Decay,
    /// It is in no error.
    None,
}

impl Role {
    /// Whether a store errs by it.
    #[must_use]
    pub const fn is_of_a_store(self) -> bool {
        match self {
            Self::Systematic | Self::Mismatch | Self::Noise => true,
            Self::Range | Self::Decay | Self::None => false,
        }
    }
}
