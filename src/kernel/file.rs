//! Kernel files: TOML with the weights, or with the formula they come from.
//!
//! ```toml
//! name = "centre-surround-5x5"
//! source = "where it came from"
//! weights = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]   # or one of the next two
//! centre-surround = 5                 # centre 1, the others -1/(k*k - 1)
//! gaussians = [{ sigma = 1, gain = 1 }, { sigma = 2, gain = -1 }]
//! ```

use serde::Deserialize;

use super::{Kernel, KernelError};
use crate::plane::Plane;

/// A kernel file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum KernelFileError {
    /// Not TOML, or not the keys of a kernel file.
    #[error("{0}")]
    Syntax(#[from] toml::de::Error),
    /// Not a kernel.
    #[error("{0}")]
    Kernel(#[from] KernelError),
    /// None or several of the ways to give the weights.
    #[error("give the kernel by exactly one of `weights`, `centre-surround` and `gaussians`")]
    OneWay,
    /// A formula with a parameter it is not defined for.
    #[error("{0}")]
    Parameter(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Written {
    #[expect(dead_code, reason = "for people")]
    name: Option<String>,
    #[expect(dead_code, reason = "for people")]
    source: Option<String>,
    weights: Option<Vec<Vec<f64>>>,
    centre_surround: Option<usize>,
    gaussians: Option<Vec<Gaussian>>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Gaussian {
    sigma: f64,
    gain: f64,
}

impl Kernel {
    /// Reads a kernel file's text.
    ///
    /// # Errors
    /// When the text is not a kernel file, or what it says is not a kernel.
    pub fn from_toml(text: &str) -> Result<Self, KernelFileError> {
        let written: Written = toml::from_str(text)?;
        match written {
            Written {
                weights: Some(rows),
                centre_surround: None,
                gaussians: None,
                ..
            } => Ok(Self::from_rows(&rows)?),
            Written {
                weights: None,
                centre_surround: Some(side),
                gaussians: None,
                ..
            } => Self::centre_surround(side),
            Written {
                weights: None,
                centre_surround: None,
                gaussians: Some(parts),
                ..
            } => sum_of_gaussians(&parts),
            _ => Err(KernelFileError::OneWay),
        }
    }

    /// Centre 1 and a surround of equal weights that sum to -1, `side` by `side`.
    ///
    /// # Errors
    /// When `side` is even, or below 3.
    pub fn centre_surround(side: usize) -> Result<Self, KernelFileError> {
        if side < 3 {
            return Err(KernelFileError::Parameter(format!(
                "centre-surround must be an odd side of 3 or more, it is {side}"
            )));
        }
        let others = -1.0 / ((side * side - 1) as f64);
        let mut weights = Plane::from_elem((side, side), others);
        weights[[side / 2, side / 2]] = 1.0;
        Ok(Self::new(weights)?)
    }
}

/// Each Gaussian is cut at `int(6 sigma) + 1` (made odd) and normalised to sum 1 before its
/// gain, as in the released Neural Ganglion Sensors simulator.
fn sum_of_gaussians(parts: &[Gaussian]) -> Result<Kernel, KernelFileError> {
    if let Some(bad) = parts.iter().find(|g| !(g.sigma > 0.0 && g.sigma <= 20.0)) {
        return Err(KernelFileError::Parameter(format!(
            "sigma must be above 0 and at most 20 pixels, it is {}",
            bad.sigma
        )));
    }
    let side_of = |g: &Gaussian| ((6.0 * g.sigma) as usize + 1) | 1;
    let side = parts.iter().map(side_of).max().ok_or(KernelError::Empty)?;
    let mut weights = Plane::<f64>::zeros((side, side));
    for part in parts {
        let own = side_of(part);
        let half = (own / 2) as f64;
        let line: Vec<f64> = (0..own)
            .map(|i| (-(i as f64 - half).powi(2) / (2.0 * part.sigma * part.sigma)).exp())
            .collect();
        let total: f64 = line.iter().sum::<f64>().powi(2);
        let inset = (side - own) / 2;
        for (y, row) in line.iter().enumerate() {
            for (x, column) in line.iter().enumerate() {
                weights[[inset + y, inset + x]] += part.gain * row * column / total;
            }
        }
    }
    Ok(Kernel::new(weights)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_have_the_sums_they_promise() {
        let cs = Kernel::from_toml("centre-surround = 5").unwrap();
        assert!(cs.sum().abs() < 1e-15);
        let dog = Kernel::from_toml(
            "gaussians = [{ sigma = 1, gain = 1.3 }, { sigma = 2, gain = -0.9 }]",
        )
        .unwrap();
        assert_eq!(dog.weights().dim(), (13, 13));
        assert!((dog.sum() - 0.4).abs() < 1e-12);
    }

    #[test]
    fn one_way_only() {
        for text in ["", "weights = [[1]]\ncentre-surround = 3"] {
            assert!(matches!(
                Kernel::from_toml(text),
                Err(KernelFileError::OneWay)
            ));
        }
        assert!(matches!(
            Kernel::from_toml("colour = 3"),
            Err(KernelFileError::Syntax(_))
        ));
    }
}
