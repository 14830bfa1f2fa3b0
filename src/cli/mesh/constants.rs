//! The space constants of a sheet.

use crate::mesh::{MeshError, Sheet};

/// The space constants of a sheet, as they are asked for.
#[derive(Debug, clap::Args)]
pub(super) struct Constants {
    /// Space constant in pixels, 0 or more
    ///
    /// λ² is the ratio of transverse to lateral resistance.
    #[arg(long, value_name = "L")]
    pub lambda: f64,
    /// Space constant down the columns, if it is another [default: --lambda]
    #[arg(long, value_name = "L")]
    pub lambda_y: Option<f64>,
}

impl Constants {
    pub fn sheet(&self) -> Result<Sheet, MeshError> {
        Sheet::anisotropic(self.lambda_y.unwrap_or(self.lambda), self.lambda)
    }
}
