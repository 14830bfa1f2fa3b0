//! Why there is no answer.

use crate::{
    compare::CompareError,
    isa::FigureError,
    rig::RigError,
    scene::SceneError,
    study::{
        design::DesignError, equivalent::EquivalentError, quantisation::QuantisationError,
        rate::RateError, waterfall::WaterfallError,
    },
};

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FeasibilityError {
    /// Nothing is asked about.
    #[error("there is no kernel to ask about")]
    #[diagnostic(help("give one kernel at least"))]
    NoKernel,
    /// There is no threshold for a rate.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rate(#[from] RateError),
    /// The question makes no sense.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Design(#[from] DesignError),
    /// The table cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Quantisation(#[from] QuantisationError),
    /// Scene or sensor cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rig(#[from] RigError),
    /// The scene cannot be read again.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The waterfall cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Waterfall(#[from] WaterfallError),
    /// Nothing to be told of thresholds.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Equivalent(#[from] EquivalentError),
    /// A drawn number makes no sense.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Figure(#[from] FigureError),
    /// Packets of one scene that do not compare.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compare(#[from] CompareError),
}
