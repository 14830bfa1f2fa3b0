//! Configuration files: from text to typed values, every fault with its place.
//!
//! A file of one kind is described by its keys ([`Key`]): what each takes, in which range and
//! unit, what holds when it is left out. The description is data. [`File::read`] checks a text
//! against it and hands the values to whoever builds something of them, and [`schema`] makes
//! JSON Schema of it, so what an editor is told and what is read cannot differ.
//!
//! ```text
//! text ─ [document] spanned values ─ [check] against the keys ─ [section] typed values ─ constructor
//!                                              │
//!                                   [schema] JSON Schema
//! ```
//!
//! Places, faults and suggestions serve other texts as well: programs and macros.

mod check;
mod commented;
mod document;
mod fault;
mod file;
mod key;
mod kind;
mod nearest;
mod place;
mod range;
pub mod schema;
mod section;
mod text;
mod unknown;
mod word;

pub use commented::{that_hold, with_keys};
pub use document::{Document, Name, Node};
pub use fault::{CHANGES_NOTHING, Fault, Faults, Located, Read, Severity, enough, thin};
pub use file::File;
pub use key::{Absent, Key, Table};
pub use kind::{Kind, Spelling};
pub use nearest::{asked, nearest, suggestion, suggestion_or};
pub use place::{Lines, Place, line_column};
pub use range::Range;
pub use section::Section;
pub use text::on_one_line;
pub use unknown::{choice, unknown_key};
pub(crate) use word::listed;
pub use word::{UnknownWord, variant};
