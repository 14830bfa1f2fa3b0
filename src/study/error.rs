//! Why a study cannot go on.

use super::design::DesignError;
use crate::{compare::CompareError, rig::RigError, scene::SceneError, sensor::SensorError};

/// What any study can end with.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StudyError {
    /// A sensor cannot be made, or a kernel not be had as asked.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Design(#[from] DesignError),
    /// Scene or sensor cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rig(#[from] RigError),
    /// A float sensor cannot be made or go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
    /// The packets have nothing in common.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compare(#[from] CompareError),
    /// The scene cannot be opened again.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
}
