//! The steps from the float sensor to the chip, in the order in which they are added.

use serde::Serialize;

use crate::{config::listed, study::pilot::ErrorTerm};

listed! {
/// One step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// A cell says one event a frame at most, at the frame's time.
    Frames = "frames",
    /// The memory snaps to the drive, where it moved by whole thresholds.
    Memory = "memory",
    /// The kernel in few values.
    Kernel = "kernel",
    /// The compiled program on the array, in the cells' number format.
    Format = "format",
    /// The host sets thresholds in steps of its converter.
    Converter = "converter",
    /// Registers have a range.
    Saturation = "saturation",
    /// Every store errs and loses a part, and a bus that splits errs more.
    Transfer = "transfer",
    /// No two cells are alike.
    Mismatch = "mismatch",
    /// Every store is noisy.
    Noise = "noise",
    /// Registers forget.
    Decay = "decay",
    /// What the readout loses, and when events arrive.
    Readout = "readout",
}
}

impl Cause {
    /// Those of an array of analogue cells: all.
    pub const SILICON: &'static [Self] = Self::ALL;

    /// Those of an array whose cells hold numbers.
    pub const NUMBERS: [Self; 6] = [
        Self::Frames,
        Self::Memory,
        Self::Kernel,
        Self::Format,
        Self::Saturation,
        Self::Readout,
    ];

    /// The step that an error of analogue cells is.
    #[must_use]
    pub const fn of(term: ErrorTerm) -> Self {
        match term {
            ErrorTerm::Converter => Self::Converter,
            ErrorTerm::Saturation => Self::Saturation,
            ErrorTerm::Transfer => Self::Transfer,
            ErrorTerm::Mismatch => Self::Mismatch,
            ErrorTerm::Noise => Self::Noise,
            ErrorTerm::Decay => Self::Decay,
        }
    }

    /// A few words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frames => "one event a frame",
            Self::Memory => "memory rule",
            Self::Kernel => "kernel in few values",
            Self::Format => "number format",
            Self::Converter => "threshold in steps",
            Self::Saturation => ErrorTerm::Saturation.name(),
            Self::Transfer => ErrorTerm::Transfer.name(),
            Self::Mismatch => ErrorTerm::Mismatch.name(),
            Self::Noise => ErrorTerm::Noise.name(),
            Self::Decay => ErrorTerm::Decay.name(),
            Self::Readout => "readout",
        }
    }

    /// Whether it is another on every chip.
    #[must_use]
    pub const fn is_chance(self) -> bool {
        match self {
            Self::Mismatch | Self::Noise => true,
            Self::Frames
            | Self::Memory
            | Self::Kernel
            | Self::Format
            | Self::Converter
            | Self::Saturation
            | Self::Transfer
            | Self::Decay
            | Self::Readout => false,
        }
    }

    /// Whether it belongs to the float model; the others are the chip's.
    #[must_use]
    pub const fn is_float(self) -> bool {
        matches!(self, Self::Frames | Self::Memory | Self::Kernel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::{Figure, Role};

    /// Chips differ in a store's mismatch and noise, and in nothing else of it.
    #[test]
    fn each_figure_of_a_store_is_a_step() {
        for figure in Figure::of_a_store() {
            let cause = ErrorTerm::of(figure.role()).map(Cause::of).unwrap();
            assert!(Cause::SILICON.contains(&cause), "{figure}");
            let is_chance = matches!(figure.role(), Role::Mismatch | Role::Noise);
            assert_eq!(cause.is_chance(), is_chance, "{figure}");
        }
    }
}
