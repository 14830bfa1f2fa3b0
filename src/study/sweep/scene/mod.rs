//! Scenes that many points watch.
//!
//! - [`cached_scene`]: a scene, kept in memory while it is small; [`stamp`]: whether its files are
//!   still those that were read first.
//! - [`drive`]: what the resistor sheets of several points make of a scene, computed once.

pub(super) mod cached_scene;
pub(super) mod drive;
mod stamp;
