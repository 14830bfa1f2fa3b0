//! The thresholds of a question that asks for a rate of events.

use super::FeasibilityError;
use crate::{
    compile::Effort,
    isa::Device,
    kernel::Kernel,
    reference::MemoryRule,
    rig::guard::Warning,
    scene::Reopen,
    study::{design::Design, rate},
};

/// Thresholds for a rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtRate {
    /// The threshold of each kernel, to four digits.
    pub thresholds: Vec<f64>,
    /// The kernels whose events no threshold brings near the rate.
    pub missed: Vec<Warning>,
}

/// The thresholds at which the float sensors of some kernels, each with its name, have `rate` events
/// per pixel and second together, each an equal share.
///
/// # Errors
/// When a kernel is all 0, no threshold gives its share, or the scene cannot be read.
pub fn at_rate<'a>(
    kernels: impl ExactSizeIterator<Item = (&'a str, &'a Kernel)>,
    (rate, seed): (f64, u64),
    device: &Device,
    open: &Reopen<'_>,
) -> Result<AtRate, FeasibilityError> {
    let share = rate / kernels.len() as f64;
    let mut found = AtRate::default();
    for (name, kernel) in kernels {
        let design = Design {
            kernel,
            threshold: rate::start(kernel),
            device,
            // Nothing is compiled.
            effort: Effort::states(0),
            seed,
        };
        let description = design.description(MemoryRule::FilteredSnap)?;
        let factor = rate::factor(&description, share, seed, open)?;
        let threshold = rate::four_digits(design.threshold * factor.factor);
        found.thresholds.push(threshold);
        found.missed.extend(Warning::rate(name, share, factor.rate));
    }
    Ok(found)
}
