//! Errors of the resistive grid.

use crate::plane::Size;

/// Why a resistive grid cannot be solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum MeshError {
    /// A space constant that is not a number, negative or too large.
    #[error("the space constant is {value:?}")]
    #[diagnostic(help(
        "give a number of pixels from 0 (no surround) to {most:e}; λ² is transverse over lateral resistance"
    ))]
    Lambda {
        /// What was given.
        value: f64,
        /// The largest magnitude that is possible.
        most: f64,
    },
    /// A time that is negative or not finite.
    #[error("the {what} is {value} s")]
    #[diagnostic(help("give a finite number of seconds, zero or more"))]
    Time {
        /// The name of the time.
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// A signal that is no number, or too large to be summed.
    #[error("the pixel at x = {x}, y = {y} is {value:?}")]
    #[diagnostic(help(
        "every pixel must be a finite number, at most {most:e} in size; a node without a signal cannot be solved for"
    ))]
    Signal {
        /// Row of the node, from 0 at the top.
        y: usize,
        /// Column of the node, from 0 on the left.
        x: usize,
        /// What it is.
        value: f64,
        /// The largest magnitude that is possible.
        most: f64,
    },
    /// A plane of another size than the sheet.
    #[error("the signal is {got}, the sheet is {want}")]
    #[diagnostic(help("give one signal for each node of the sheet"))]
    Size {
        /// The size of the signal.
        got: Size,
        /// The sheet's size.
        want: Size,
    },
    /// Space constants that differ, where there can only be one.
    #[error("the sheet has two space constants, and v2e's has one")]
    #[diagnostic(help("give one space constant, or use the exact solution"))]
    Anisotropic,
    /// A conductance or capacitance of a network that is out of range.
    #[error("the {what} at x = {x}, y = {y} is {value}")]
    #[diagnostic(help(
        "conductances to the signals and capacitances are above 0, laterals 0 (open) or above"
    ))]
    Part {
        /// The kind of part.
        what: &'static str,
        /// Row of the node, from 0 at the top.
        y: usize,
        /// Column of the node, from 0 on the left.
        x: usize,
        /// What it is.
        value: f64,
    },
    /// The scale of a nonlinear lateral that is not above 0.
    #[error("the laterals bend at {value}")]
    #[diagnostic(help("give the difference at which they bend, above 0, in the signal's unit"))]
    Scale {
        /// What was given.
        value: f64,
    },
    /// Nonlinear laterals, where only a linear network can be simulated in time.
    #[error("the laterals are not resistors, and only a linear network is moved on in time")]
    #[diagnostic(help("settle it for each signal, or use linear laterals"))]
    Laterals,
    /// A solution that is not accurate enough.
    #[error("the network does not settle: what was found may be off by {error:e}")]
    #[diagnostic(help(
        "the parts are too far apart for double precision: bring their conductances closer together"
    ))]
    Unsettled {
        /// The bound on the error, in the unit of the signal.
        error: f64,
    },
    /// Too much work for one frame.
    #[error("the {what} would take more than {most} steps from one frame to the next")]
    #[diagnostic(help(
        "use a smaller space constant or a shorter time, or a sheet of equal parts by its exact rule, whose work does not depend on them"
    ))]
    Steps {
        /// What is moved on.
        what: &'static str,
        /// The most steps.
        most: u64,
    },
    /// A kernel that cannot be fitted.
    #[error("{}", match sheets {
        1..=3 => "a kernel of zeros cannot be fitted".to_owned(),
        _ => format!("a kernel is to be fitted by {}", crate::unit::counted(*sheets, "sheet")),
    })]
    #[diagnostic(help("give a kernel with a weight that is not 0, and 1 to 3 sheets"))]
    Fit {
        /// How many sheets were asked for.
        sheets: usize,
    },
    /// No pixels.
    #[error("a sheet of {size} pixels has no node")]
    #[diagnostic(help("give at least one row and one column"))]
    Empty {
        /// The size.
        size: Size,
    },
}
