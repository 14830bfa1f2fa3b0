//! Quantisers, what a kernel's sum must be, number formats and arithmetics, on the command line.

use miette::Diagnostic;

use crate::{
    array::{Arithmetic, ArithmeticError},
    kernel::quantise::{Quantiser, QuantiserNameError, Sum},
    number::{Format, FormatError},
};

/// [`Sum`], as it is written. All verbs that quantise have the same default.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub(in crate::cli) enum Total {
    /// Any sum
    Free,
    /// 0, so that uniform light gives no response. With `ternary` the best levels and scale of that
    /// sum; with all others the nearest levels, at a scale near the best
    Zero,
    /// The sum of the kernel, as near as the levels allow
    #[default]
    Kept,
}

impl Total {
    /// As it is written.
    pub(in crate::cli) const fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Zero => "zero",
            Self::Kept => "kept",
        }
    }
}

impl From<Total> for Sum {
    fn from(total: Total) -> Self {
        match total {
            Total::Free => Self::Free,
            Total::Zero => Self::Zero,
            Total::Kept => Self::Kept,
        }
    }
}

/// A quantiser, for the command line, which shows no help beside a message.
pub(in crate::cli) fn quantiser(name: &str) -> Result<Quantiser, String> {
    name.parse()
        .map_err(|error: QuantiserNameError| with_help(&error))
}

/// A number format, for the command line.
pub(in crate::cli) fn number_format(name: &str) -> Result<Format, String> {
    name.parse().map_err(|error: FormatError| with_help(&error))
}

/// An arithmetic, for the command line.
pub(in crate::cli) fn arithmetic(name: &str) -> Result<Arithmetic, String> {
    name.parse()
        .map_err(|error: ArithmeticError| with_help(&error))
}

/// What was wrong, and what to do.
fn with_help(error: &dyn Diagnostic) -> String {
    let help = error.help();
    let help = help.map_or(String::new(), |help| format!("; {help}"));
    format!("{error}{help}")
}
