//! Why there is nothing to choose from.

use super::super::{
    StudyError,
    rate::{RateError, down, up},
};
use crate::config::Faults;

/// Why nothing could be explored.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ExplorationError {
    /// What any study can end with.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(StudyError),
    /// No threshold gives the rate.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rate(#[from] RateError),
    /// No threshold of a kernel gives its share of the rate.
    #[error(
        "{rate} events per pixel and second are {share} of each of {kernels} kernels: with {name} this scene gives {} to {}, with thresholds from 4096 times as high to 1/4096",
        up(*least),
        down(*most)
    )]
    #[diagnostic(help("give a rate whose equal share lies between them"))]
    Share {
        /// The rate that was asked for.
        rate: f64,
        /// One kernel's part of it.
        share: f64,
        /// How many kernels.
        kernels: usize,
        /// Which of them does not have it.
        name: String,
        /// With thresholds 4096 times as high.
        least: f64,
        /// With thresholds of a 4096th.
        most: f64,
    },
    /// A program that was found is not what the chip takes.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Program(#[from] Faults),
    /// Names, kernels and thresholds do not go together.
    #[error(
        "{} and {} for {}",
        crate::unit::counted(*names, "name"),
        crate::unit::counted(*thresholds, "threshold"),
        crate::unit::counted(*kernels, "kernel")
    )]
    #[diagnostic(help("give one of each for every kernel, and one kernel at least"))]
    Numbers {
        /// Kernels.
        kernels: usize,
        /// Names.
        names: usize,
        /// Thresholds.
        thresholds: usize,
    },
    /// The float sensor says nothing.
    #[error(
        "the float sensor has no event on this scene with {} {}, so that nothing can be judged",
        if thresholds.len() == 1 { "a threshold of" } else { "thresholds of" },
        thresholds.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
    )]
    #[diagnostic(help("give lower thresholds, a higher rate, or a scene with more movement"))]
    Silent {
        /// The thresholds, in kernel times light (0 to 255).
        thresholds: Vec<f64>,
    },
    /// Nothing fits.
    #[error("none of these choices gives a program for this chip")]
    #[diagnostic(help("give fewer kernels, smaller ones, other quantisers or another chip"))]
    Nothing {
        /// What was tried.
        #[related]
        refused: Vec<Untaken>,
    },
}

impl<E: Into<StudyError>> From<E> for ExplorationError {
    fn from(cause: E) -> Self {
        Self::Study(cause.into())
    }
}

/// One that the chip does not take.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{0}")]
pub struct Untaken(pub String);
