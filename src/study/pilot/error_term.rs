//! The error terms of a chip, each of which can be left out by itself.

use std::fmt;

use crate::{config::listed, isa::Errors};

listed! {
/// A kind of error of analogue cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorTerm {
    /// The host sets values in steps of its converter.
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
}
}

impl ErrorTerm {
    /// The errors without it.
    pub const fn leave_out(self, errors: &mut Errors) {
        match self {
            Self::Converter => errors.input_step = 0.0,
            Self::Saturation => errors.range = (f64::NEG_INFINITY, f64::INFINITY),
            Self::Transfer => {
                (errors.transfer, errors.loss, errors.division) = (0.0, 0.0, 0.0);
            }
            Self::Mismatch => {
                (errors.gain_mismatch, errors.offset_mismatch) = (0.0, 0.0);
                errors.division_mismatch = 0.0;
            }
            Self::Noise => errors.noise = 0.0,
            Self::Decay => (errors.decay, errors.retention) = (0.0, f64::INFINITY),
        }
    }

    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converter => "steps of the converter",
            Self::Saturation => "saturation",
            Self::Transfer => "transfer and division",
            Self::Mismatch => "mismatch",
            Self::Noise => "temporal noise",
            Self::Decay => "decay",
        }
    }
}

impl fmt::Display for ErrorTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
