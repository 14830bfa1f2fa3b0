//! The syntax of C++, as far as it is understood.
//!
//! - [`parser`]: from tokens to the tree.
//! - [`tree`]: the syntax tree.
//! - [`walk`]: the parts of a statement of it, one after the other.

pub(super) mod parser;
pub(super) mod tree;
pub(super) mod walk;
