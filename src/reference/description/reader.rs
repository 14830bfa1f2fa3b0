//! A sensor file while it is read.

use crate::config::{Fault, Place};

/// Reads a file that a sensor file names; the path is as written there.
pub type ReadFile<'a> = dyn Fn(&str) -> std::io::Result<Vec<u8>> + 'a;

/// A sensor file being read.
pub(super) struct Reader<'a> {
    pub(super) file: &'a str,
    pub(super) read: &'a ReadFile<'a>,
}

/// What is wrong here, and what to do.
pub(super) fn wrong(place: Place, message: impl Into<String>, advice: &str) -> Fault {
    Fault::error(place, message, "here").help(advice)
}
