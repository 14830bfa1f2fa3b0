//! Reading a chip: `device.toml`, `primitives.toml`, `macros.scamp`, and what it extends.
//!
//! The shipped chips are part of the program text, so that it runs anywhere; a folder on disk
//! is read when it is asked for. Every check says which file, which place, and what to do.

mod assemble;
mod chips;
mod error;
mod figures;
mod file;
mod host_form;
pub mod keys;
mod layers;
mod naming;
mod primitive_form;
mod registers;
mod rows;

pub use self::error::LoadError;
