//! Why a point has no result.

use miette::Diagnostic;

use crate::advice::in_study;

/// Why a point has no figures.
#[derive(Clone, Debug)]
pub(in crate::study::sweep) enum Refusal {
    /// It cannot be, here or elsewhere.
    Cannot(String),
    /// It was given up: with more time or memory it may be.
    GivenUp(String),
}

impl Refusal {
    /// Of what may be mended until the next run.
    pub fn given_up(error: &impl Diagnostic) -> Self {
        let help = error.help().map(|help| format!(" ({help})"));
        Self::GivenUp(format!("{error}{}", help.unwrap_or_default()))
    }
}

impl<E: Diagnostic> From<E> for Refusal {
    fn from(error: E) -> Self {
        let help = error
            .help()
            .map(|help| format!(" ({})", in_study(&help.to_string())));
        Self::Cannot(format!("{error}{}", help.unwrap_or_default()))
    }
}
