//! What a chip refuses.

use crate::plane::Size;

/// A plane of another size than the array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("a plane of {got} on an array of {want}")]
#[diagnostic(help("give a plane of the size of the array"))]
pub struct ShapeError {
    /// The plane's size.
    pub got: Size,
    /// The array's size.
    pub want: Size,
}

/// A program stopped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("line {line}: `{operation}` has no answer in the domain {domain}")]
#[diagnostic(help(
    "here it depends on the light; run the program in a domain of numbers, such as exact"
))]
pub struct RunError {
    /// Line of the program text, from 1.
    pub line: u32,
    /// Which instruction.
    pub operation: &'static str,
    /// Which domain.
    pub domain: String,
}
