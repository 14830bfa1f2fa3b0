//! From text to tokens: what the compiler of the vendor does before it parses.
//!
//! - [`source_map`]: a file and what it includes, as one space of places.
//! - [`includes`]: the files that a text asks for, read from the disk; [`prototype`]: functions
//!   that it declares and does not define, whose bodies may lie beside it.
//! - [`token`]: tokens of C++.
//! - [`preprocessor`]: `#include`, `#define`, `#if`; [`constant`]: the conditions of `#if`.

pub(super) mod constant;
pub(super) mod includes;
pub(super) mod preprocessor;
mod prototype;
pub(super) mod source_map;
pub(super) mod token;
