//! The error terms of a chip, each of which can be left out by itself.

use std::fmt;

use crate::array::Errors;

/// A kind of error of analogue cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorTerm {
    /// The host sets values in steps of its converter.
    Converter,
    /// Registers have a range.
    Saturation,
    /// Every store errs and loses a part, and a bus that splits errs more.
    Transfer,
    /// No two cells are alike.
    Mismatch,
    /// Every store is noisy.
    Noise,
    /// Registers forget.
    Decay,
}

impl ErrorTerm {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Converter,
        Self::Saturation,
        Self::Transfer,
        Self::Mismatch,
        Self::Noise,
        Self::Decay,
    ];

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

    /// How it is written on a command line.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Converter => "converter",
            Self::Saturation => "saturation",
            Self::Transfer => "transfer",
            Self::Mismatch => "mismatch",
            Self::Noise => "noise",
            Self::Decay => "decay",
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
