//! Why there is no answer.

use crate::{
    isa::FigureError,
    study::{
        StudyError, quantisation::QuantisationError, rate::RateError, waterfall::WaterfallError,
    },
};

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FeasibilityError {
    /// What any study can end with.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(StudyError),
    /// Nothing is asked about.
    #[error("there is no kernel to ask about")]
    #[diagnostic(help("give one kernel at least"))]
    NoKernel,
    /// There is no threshold for a rate.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rate(#[from] RateError),
    /// The table cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Quantisation(#[from] QuantisationError),
    /// The waterfall cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Waterfall(#[from] WaterfallError),
    /// A drawn number makes no sense.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Figure(#[from] FigureError),
}

impl<E: Into<StudyError>> From<E> for FeasibilityError {
    fn from(cause: E) -> Self {
        Self::Study(cause.into())
    }
}
