//! Damaged files of points and of pilots.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

use serde::Serialize;

use crate::unit::counted;

/// A point's or a pilot's file that is damaged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Damage {
    /// The point's number; none: it is a pilot's.
    pub point: Option<usize>,
    /// Its file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub why: String,
}

/// The most lines of a list that is shown.
pub const SHOWN: usize = 20;

/// A list for people, one a line, of which the first twenty are shown.
#[must_use]
pub fn listed(lines: impl ExactSizeIterator<Item = String>) -> String {
    let more = lines.len().saturating_sub(SHOWN);
    let mut text = String::new();
    for line in lines.take(SHOWN) {
        let _ = write!(text, "\n  {line}");
    }
    if more > 0 {
        let _ = write!(text, "\n  and {more} more");
    }
    text
}

/// What a sweep says of files that it has set aside in its folder: how many, of what, where they are,
/// and which.
#[must_use]
pub fn set_aside(all: &[Damage], folder: &Path) -> String {
    format!(
        "{}, set aside in {}/damaged:{}",
        files(all),
        folder.display(),
        damages(all)
    )
}

/// How many files are damaged, of what.
fn files(damaged: &[Damage]) -> String {
    let pilots = damaged
        .iter()
        .filter(|damage| damage.point.is_none())
        .count();
    let of = |files: usize, what: &str| format!("{} of {what}", counted(files, "file"));
    match (damaged.len() - pilots, pilots) {
        (points, 0) => of(points, "points"),
        (0, pilots) => of(pilots, "pilots"),
        (points, pilots) => format!("{} and {}", of(points, "points"), of(pilots, "pilots")),
    }
}

/// Damaged files for people.
pub(super) fn damages(all: &[Damage]) -> String {
    listed(
        all.iter()
            .map(|damage| format!("{}: {}", damage.path.display(), damage.why)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_are_shown_and_the_others_counted() {
        let of = |n: usize| listed((0..n).map(|line| format!("line {line}")));
        assert_eq!(of(2), "\n  line 0\n  line 1");
        assert_eq!(of(20).lines().count(), 21);
        assert!(of(23).ends_with("line 19\n  and 3 more"));
    }
}
