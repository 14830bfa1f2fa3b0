//! Kernels and names that make no levels.

use amacrine::{compile::CompileError, kernel::quantise::QuantiseError};

use super::list::KNOWN;

/// A kernel or a name that makes no levels.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LevelsError {
    /// A name that stands for no levels.
    #[error("`{name}` stands for no levels")]
    #[diagnostic(help("{KNOWN}"))]
    Name {
        /// What was given.
        name: String,
    },
    /// No level but 0 is left.
    #[error("few values leave nothing of the kernel: all its levels would be 0")]
    #[diagnostic(help("begin with another kernel, or leave its sum or its symmetry free"))]
    Empty,
    /// Sides of which an octagonal symmetry makes nothing.
    #[error("a kernel of {height}x{width} weights is not square, so it has no symmetry `d4`")]
    #[diagnostic(help("take `mirror`, or a square kernel"))]
    Square {
        /// Rows of the kernel.
        height: usize,
        /// Columns of the kernel.
        width: usize,
    },
    /// The library's quantiser refuses.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Quantise(#[from] QuantiseError),
    /// The compiler refuses.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compile(#[from] CompileError),
    /// Weights that make no kernel.
    #[error(transparent)]
    Kernel(#[from] amacrine::kernel::KernelError),
}
