//! The space constants of a sheet.

use crate::mesh::{MeshError, Sheet};

/// The space constants of a sheet, as they are asked for.
#[derive(Debug, clap::Args)]
pub(super) struct Constants {
    /// Space constant in pixels, 0 or more: λ² is transverse over lateral resistance
    #[arg(long, value_name = "L")]
    pub lambda: f64,
    /// Another space constant down the columns
    #[arg(long, value_name = "L")]
    pub lambda_y: Option<f64>,
}

impl Constants {
    pub fn sheet(&self) -> Result<Sheet, MeshError> {
        Sheet::anisotropic(self.lambda_y.unwrap_or(self.lambda), self.lambda)
    }
}
