//! Kernels that cannot be quantised as asked.

use super::{super::KernelError, entry::Quantiser};

/// A kernel that cannot be quantised as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum QuantiseError {
    /// Weights too small or too large to compute with.
    #[error(transparent)]
    #[diagnostic(help("multiply the kernel by a number, and the threshold with it"))]
    Weights(#[from] KernelError),
    /// More work than is allowed.
    #[error("{weights} weights in {quantiser} take {needed:.1e} {what}, more than {most:.1e}")]
    #[diagnostic(help(
        "cut the kernel where its weights are small, take a quantiser of fewer levels or digits, or leave the sum free"
    ))]
    Work {
        /// Which quantiser.
        quantiser: Quantiser,
        /// How many weights there are.
        weights: usize,
        /// How much it would be.
        needed: f64,
        /// How much it may be.
        most: f64,
        /// What is counted: entries of a table, steps of a search.
        what: &'static str,
    },
    /// No weight but 0.
    #[error("all weights are 0")]
    #[diagnostic(help("give a kernel that sees something"))]
    Nothing,
    /// A sum that these levels cannot have.
    #[error("no choice of levels of {quantiser} sums to {sum} over {}", crate::unit::counted(*weights, "weight"))]
    #[diagnostic(help(
        "leave the sum free (--sum free), or take a quantiser whose levels allow it, such as ternary; of a Q format more bits before the point"
    ))]
    Sum {
        /// Which quantiser.
        quantiser: Quantiser,
        /// The sum that was asked: of the levels, times their scale where that is not free.
        sum: f64,
        /// How many weights there are.
        weights: usize,
    },
    /// A sum over levels that have no common step.
    #[error("the two scales of ternary-split leave the sum as it comes")]
    #[diagnostic(help("leave the sum free (--sum free), or take `ternary`, which can keep it"))]
    SplitSum,
    /// A rounding that is a rule for each weight, and a sum that needs others.
    #[error("{quantiser} rounds each weight by itself, which leaves no sum of 0")]
    #[diagnostic(help("leave `:floor` or `:stochastic` out, or ask for no sum (`--sum free`)"))]
    RoundedSum {
        /// The quantiser.
        quantiser: Quantiser,
    },
    /// Everything became 0.
    #[error("every weight becomes 0 in {quantiser}; the largest is {largest}")]
    #[diagnostic(help(
        "take more bits: after the point where weights are small, before it where they are beyond the format; a sum of 0 over a single weight leaves nothing of it"
    ))]
    Vanished {
        /// Which quantiser.
        quantiser: Quantiser,
        /// The largest weight's magnitude.
        largest: f64,
    },
}

/// Refuses work that would take too long or too much room.
pub(super) fn affordable(
    quantiser: Quantiser,
    weights: usize,
    needed: f64,
    most: u64,
    what: &'static str,
) -> Result<(), QuantiseError> {
    let most = most as f64;
    if needed <= most {
        return Ok(());
    }
    Err(QuantiseError::Work {
        quantiser,
        weights,
        needed,
        most,
        what,
    })
}
