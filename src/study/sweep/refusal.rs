//! Why a point has no result.

use miette::Diagnostic;

/// Why a point has no figures.
#[derive(Clone, Debug)]
pub(super) enum Refusal {
    /// It cannot be, here or elsewhere.
    Cannot(String),
    /// It was given up: with more time or memory it may be.
    GivenUp(String),
}

impl<E: Diagnostic> From<E> for Refusal {
    fn from(error: E) -> Self {
        let help = error.help().map(|help| format!(" ({help})"));
        Self::Cannot(format!("{error}{}", help.unwrap_or_default()))
    }
}
