//! The folder of results.
//!
//! - [`store`]: the folder; [`manifest`]: what it says about itself; [`error`]: why it cannot be used.
//! - [`record`]: the file of a point; [`pilot_file`]: that of a pilot or of a rung of a search;
//!   [`provenance`]: who computed it.
//! - [`seal`]: files that carry their checksum; [`damage`]: those whose checksum is wrong;
//!   [`regular_file`]: no symlink or device is read or written in place of one.
//! - [`merge`]: folders joined; [`verify`]: points computed again; [`difference`]: where two results
//!   differ.

pub mod damage;
pub(super) mod difference;
pub(super) mod error;
pub mod manifest;
pub mod merge;
pub(super) mod pilot_file;
pub mod provenance;
pub mod record;
mod regular_file;
mod seal;
pub mod store;
pub mod verify;
