//! A sensor with other kernels, thresholds and spreads than its own.

use super::{Channel, Description};
use crate::kernel::Kernel;

/// What a sensor cannot be changed to.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum ChangeError {
    /// It has no kernel to be replaced.
    #[error(
        "--kernel {given}: the first kind of the sensor has a mesh or a pattern in place of a kernel"
    )]
    #[diagnostic(help("give a sensor file whose first kind has a kernel of its own, such as rgc"))]
    NoKernel {
        /// What the kernels are called.
        given: String,
    },
    /// A threshold that is not above 0.
    #[error("--threshold {threshold} is no threshold")]
    #[diagnostic(help("give a finite number above 0, in units of the response"))]
    Threshold {
        /// What was given.
        threshold: f64,
    },
    /// A spread below 0.
    #[error("--sigma {sigma} is no spread of thresholds")]
    #[diagnostic(help("give a finite number of 0 or more, in units of the response"))]
    Sigma {
        /// What was given.
        sigma: f64,
    },
}

impl Description {
    /// With these kernels in place of its own, a kind of cell for each, which is otherwise as the
    /// first; `given` is what they are called.
    ///
    /// # Errors
    /// When the first kind has a mesh or a pattern.
    pub fn with_kernels(
        mut self,
        kernels: Vec<(String, Kernel)>,
        given: &str,
    ) -> Result<Self, ChangeError> {
        let Some(first) = self.channels.first().cloned() else {
            return Ok(self);
        };
        if first.surrounds.is_some() || first.thresholds.len() != 1 {
            let given = given.to_owned();
            return Err(ChangeError::NoKernel { given });
        }
        let several = kernels.len() > 1;
        let kinds = kernels.into_iter().map(|(name, kernel)| Channel {
            name: several.then_some(name),
            kernels: vec![kernel],
            ..first.clone()
        });
        self.channels = kinds.collect();
        Ok(self)
    }

    /// With this threshold, for ON and for OFF, and this spread of every kind; what is not given stays.
    ///
    /// # Errors
    /// When a threshold is not above 0, or the spread is below it.
    pub fn with_thresholds(
        mut self,
        threshold: Option<[f64; 2]>,
        sigma: Option<f64>,
    ) -> Result<Self, ChangeError> {
        let is_bad = |threshold: &&f64| !(**threshold > 0.0 && threshold.is_finite());
        if let Some(threshold) = threshold.iter().flatten().find(is_bad).copied() {
            return Err(ChangeError::Threshold { threshold });
        }
        if let Some(sigma) = sigma.filter(|it| !(*it >= 0.0 && it.is_finite())) {
            return Err(ChangeError::Sigma { sigma });
        }
        let kinds = self.channels.iter_mut();
        for own in kinds.flat_map(|kind| &mut kind.thresholds) {
            if let Some([on, off]) = threshold {
                (own.on, own.off) = (on, off);
            }
            own.sigma = sigma.unwrap_or(own.sigma);
        }
        Ok(self)
    }
}
