//! What a guard says: what was seen, why that probably is, and what to change.

use std::fmt;

use super::About;

/// A guard that has something to say.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Warning {
    /// What it is about.
    pub about: About,
    /// Of whom it holds: sensors, or the scene.
    pub subjects: Vec<String>,
    /// What was seen, of the first of them.
    pub seen: String,
    /// Why that probably is.
    pub why: String,
    /// What to change.
    pub change: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, others) = match self.subjects.split_first() {
            Some((first, others)) => (first.as_str(), others),
            None => ("the run", [].as_slice()),
        };
        write!(f, "{first}: {}", self.seen)?;
        if !others.is_empty() {
            write!(f, " (also: {})", others.join("; "))?;
        }
        write!(f, ": {}\nhelp: {}", self.why, self.change)
    }
}

impl Warning {
    pub(in crate::rig) fn new(
        about: About,
        subject: &str,
        seen: impl Into<String>,
        why: impl Into<String>,
        change: impl Into<String>,
    ) -> Self {
        Self {
            about,
            subjects: vec![subject.to_owned()],
            seen: seen.into(),
            why: why.into(),
            change: change.into(),
        }
    }
}
